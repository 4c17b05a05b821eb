"""What the library does not give out, whoever signs it anew, wherever somebody looks for it."""

import json
import unittest

from library_shelf import Shelf


class Revocation(unittest.TestCase):
    def setUp(self):
        self.shelf = Shelf(self)

    def refused(self, why, action, *words):
        done = self.shelf.library(action, *words)
        self.assertEqual(done.returncode, 1, done.stdout)
        (line,) = done.stderr.strip().splitlines()
        self.assertRegex(line, r"^airside library: .+: found .+; expected .+; .+")
        self.assertIn(why, line)

    def test_a_wrong_address_is_no_library_and_stays_as_it_is(self):
        shelf = self.shelf
        (digest,) = shelf.add("a.blob")
        for action, *words in (
            ["find"],
            ["show", digest],
            ["lineage", digest],
            ["get", digest, "-o", "x.blob"],
            ["check"],
            ["revoke", digest, "--why", "x", "--key", "me.key"],
            ["find", "--at-least", "1"],
        ):
            self.refused("typo/index: found no index", action, *words, "--library", "typo", "--keys", "me.pub")
        self.refused("1 or later", "add", "b.blob", "--key", "me.key", "--library", "typo", "--at-least", "1")
        self.assertEqual(list(shelf.folder.glob("typo/*")), [])

    def test_a_library_whose_index_is_gone_is_not_begun_anew(self):
        shelf = self.shelf
        shelf.add("a.blob")
        (shelf.folder / "library" / "index").unlink()
        self.refused("no index, though there are blobs", "add", "b.blob", "--key", "me.key")
        self.assertEqual(len(list((shelf.folder / "library" / "blobs").iterdir())), 1)
        self.assertFalse((shelf.folder / "library" / "index").exists())

    def test_a_first_add_with_a_wrong_file_in_it_leaves_no_blob(self):
        (self.shelf.folder / "text.blob").write_text("no weights")
        self.refused("text.blob", "add", "a.blob", "text.blob", "--key", "me.key")
        self.assertEqual(len(self.shelf.add("a.blob")), 1)

    def test_whose_key_is_not_trusted_writes_no_index_that_nobody_could_read(self):
        shelf = self.shelf
        shelf.add("a.blob")
        shelf.airside("keygen", "-o", "other", "--name", "Bob")
        index = shelf.folder / "library" / "index"
        before = index.read_bytes()
        self.refused("none of the trusted keys", "add", "b.blob", "--key", "other.key", "--keys", "me.pub")
        self.assertEqual(index.read_bytes(), before)
        self.assertEqual(shelf.read("check").returncode, 0)

    def signed_copies(self):
        """Digests of weights that Ann has signed, of a copy with a higher counter, and of what was made from it."""
        shelf = self.shelf
        for counter, name in ((1, "first"), (7, "copy")):
            shelf.airside("sign", "a.blob", "--key", "me.key", "--counter", str(counter), "-o", f"{name}.blob")
        first, copy = shelf.add("first.blob", "copy.blob")
        (child,) = shelf.add("b.blob", "--parent", copy)
        return first, copy, child

    def assert_none_is_given_out(self, first, copy, child):
        shelf = self.shelf
        self.assertEqual(shelf.read("find").returncode, 1)
        for digest in (first, copy, child):
            self.refused("wrong weather", "get", digest, "-o", "no.blob", "--keys", "me.pub")
        self.assertIn(f"the same as {first[:12]}, which is revoked", shelf.read("show", copy).stdout)

    def test_a_copy_under_another_signature_is_revoked_too_with_what_was_made_from_it(self):
        first, copy, child = self.signed_copies()
        self.assertNotEqual(first, copy)
        words = ["revoke", first, "--why", "wrong weather", "--key", "me.key", "--json"]
        said = json.loads(self.shelf.library(*words).stdout)
        self.assertEqual(said, {"revoked": [first], "signed_copies": [copy], "made_from_them": [child]})
        self.assert_none_is_given_out(first, copy, child)

    def test_an_index_of_before_is_read_with_the_contents_of_its_blobs(self):
        shelf = self.shelf
        first, copy, child = self.signed_copies()
        shelf.library("revoke", first, "--why", "wrong weather", "--key", "me.key")
        shelf.as_it_was_written_before()
        self.assertNotIn('"content"', (shelf.folder / "library" / "index").read_text())
        self.assert_none_is_given_out(first, copy, child)
        (shelf.folder / "library" / "blobs" / f"{first}.blob").unlink()
        self.assertEqual([w["digest"] for w in shelf.found()], sorted([copy, child], key=self.added, reverse=True))
        self.refused("wrong weather", "get", first, "-o", "no.blob", "--keys", "me.pub")

    def added(self, digest):
        index = json.loads((self.shelf.folder / "library" / "index").read_text().partition("\n")[2])
        return index["weights"][digest]["added"], digest

    def test_weights_of_a_campaign_come_from_blobs_that_its_arguments_name_and_from_jobs_without_blobs(self):
        shelf = self.shelf
        (first,) = shelf.add("a.blob")
        jobs = shelf.folder / "runs" / "jobs"
        one, log, two = "1" * 24, "2" * 24, "3" * 24
        for key, blob, command in (
            (one, "b.blob", ["pretrain", "--from=" + str(shelf.folder / "a.blob")]),
            (log, None, ["simulate", "--weights", f"../{one}/w.blob"]),
            (two, "c.blob", ["transfer", "--log", f"../{log}/log.csv"]),
        ):
            (jobs / key).mkdir(parents=True)
            (jobs / key / "job.json").write_text(json.dumps({"key": key, "command": command, "name": key}))
            (jobs / key / "stdout").write_text("{}")
            if blob:
                shelf.airside("pretrain", "--plant", "rc", "--days", "2", "--seed", "1" + key[0], "-o", blob)
                (jobs / key / "w.blob").write_bytes((shelf.folder / blob).read_bytes())
        made = shelf.add("runs")
        self.assertEqual(json.loads(shelf.read("lineage", made[1], "--json").stdout)["made_from"], [made[0], first])
        shelf.library("revoke", first, "--why", "wrong weather", "--key", "me.key")
        self.assertEqual(shelf.read("find").returncode, 1)


if __name__ == "__main__":
    unittest.main()
