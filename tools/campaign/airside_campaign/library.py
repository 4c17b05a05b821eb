"""A library of weights: blobs by their content in a folder or an object store (fsspec), and one signed index that says
where each comes from. Nothing is believed that no trusted key has signed, and no blob whose bytes are not the
index's."""

import datetime
import hashlib
import json
import os
import re
import time
from contextlib import contextmanager

import fsspec

from airside_campaign.complaint import BadInput
from airside_campaign.lineage import content_of
from airside_campaign.one_job import sync
from airside_campaign.trusted_keys import id_of, is_signed, sign

KIND, FORMAT = "airside weight library", 1
MAX_BLOB_BYTES = 1 << 20  # the longest blob has some 275 kB
INDEX, LOCK = "index", "lock"
HEAD = re.compile(r"airside-library-1 ([0-9a-f]{16}) ([0-9a-f]{128})")
DIGEST = re.compile(r"[0-9a-f]{8,64}")


def now_text():
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


class Library:
    """`url`: a path, or what fsspec knows, such as s3://bucket/weights. `trusted`: public keys by their id. `at_least`:
    serial number of the oldest index that is taken; one that was put back has a valid signature too."""

    def __init__(self, url, trusted, at_least=0):
        self.url = url
        self.trusted = trusted
        self.at_least = at_least
        try:
            self.files, self.root = fsspec.core.url_to_fs(url)
        except (ValueError, ImportError) as error:
            raise BadInput(
                url, str(error), "a folder, or an address that fsspec knows", "check it, or install what it names"
            ) from error

    def _path(self, *names):
        return "/".join([self.root.rstrip("/"), *names])

    def _read(self, *names):
        try:
            with self.files.open(self._path(*names), "rb") as file:
                return file.read()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise BadInput(
                self._path(*names), str(error).lower(), "a file that can be read", "check the address and your rights"
            ) from error

    def _write(self, data, *names):
        """Whole or not at all: renamed into place where the store can, one upload where it cannot."""
        final = self._path(*names)
        staged = f"{final}.{hashlib.sha256(data).hexdigest()[:8]}.new"
        is_local = "file" in self.files.protocol
        try:
            self.files.makedirs(final.rsplit("/", 1)[0], exist_ok=True)
            with self.files.open(staged if is_local else final, "wb") as file:
                file.write(data)
                if is_local:
                    file.flush()
                    os.fsync(file.fileno())
            if is_local:
                self.files.mv(staged, final)
                sync(final.rsplit("/", 1)[0])
        except OSError as error:
            if is_local and self.files.exists(staged):
                self.files.rm(staged)
            raise BadInput(
                final,
                str(error).lower(),
                "room and rights to write",
                "make room or correct the rights; nothing changed",
            ) from error

    def read(self):
        """The index as it was signed last. Raises BadInput where there is none: at a wrong address nothing is
        revoked."""
        raw = self._read(INDEX)
        place = self._path(INDEX)
        if raw is None:
            raise BadInput(
                place,
                "no index",
                "the index of a library" + (f", {self.at_least} or later" if self.at_least else ""),
                "check the address; `airside library add` begins a library",
            )
        head, _, text = raw.decode("utf-8", errors="replace").partition("\n")
        match = HEAD.fullmatch(head)
        if not match:
            raise BadInput(place, "something else", "an index that `airside library add` wrote", "check the address")
        key = self.trusted.get(match[1])
        if key is None:
            raise BadInput(
                place,
                f"an index signed by {match[1]}",
                "one of the trusted keys",
                "give that key with --keys, if you trust it",
            )
        if not is_signed(key.key, text, match[2]):
            raise BadInput(
                place,
                "another text than was signed",
                "the index as it was written",
                "restore it from a copy of the library",
            )
        index = json.loads(text)
        if index.get("format") != FORMAT:
            raise BadInput(place, f"format {index.get('format')}", f"format {FORMAT}", "use the airside that wrote it")
        if index["serial"] < self.at_least:
            raise BadInput(
                place, f"index {index['serial']}", f"{self.at_least} or later", "ask who has put an older one back"
            )
        if any("revoked" in entry for entry in index["weights"].values()):
            self._add_contents(index)
        return index

    def _add_contents(self, index):
        """To entries of indexes that were written before they had `content`; where the blob is gone there is none."""
        for digest, entry in index["weights"].items():
            if "content" not in entry:
                try:
                    entry["content"] = content_of(self.blob(index, digest))
                except BadInput:
                    pass

    def _is_new(self):
        """Whether nothing was ever added. Raises BadInput for blobs whose index is gone, with all that it revoked."""
        if self._read(INDEX) is not None or self.at_least:
            return False
        if self.files.exists(self._path("blobs")):
            raise BadInput(
                self._path(INDEX),
                "no index, though there are blobs",
                "the index that names them",
                "restore it from a copy; if there never was one, remove blobs and add them again",
            )
        return True

    @contextmanager
    def change(self, secret, begin=False):
        """Yields the index to be changed; signs and writes it at the end, unless nothing was changed. `begin`: where
        there is none, with an empty one. One writer at a time: whoever finds the lock waits a minute. On an object
        store two that begin at once are only noticed, not kept apart: the second is refused."""
        key = id_of(bytes(secret.verify_key))
        if key not in self.trusted:
            raise BadInput(
                "--key",
                f"{key}, which is none of the trusted keys",
                "a key whose index can be read afterwards",
                "give another key, or its .pub with --keys",
            )
        if not begin:
            self.read()  # before the lock makes a folder at a wrong address
        self._lock()
        try:
            new = begin and self._is_new()
            index = {"kind": KIND, "format": FORMAT, "serial": 0, "weights": {}} if new else self.read()
            self._add_contents(index)
            before, serial = json.dumps(index, sort_keys=True), index["serial"]
            yield index
            if json.dumps(index, sort_keys=True) == before:
                return
            if (0 if new and self._read(INDEX) is None else self.read()["serial"]) != serial:
                raise BadInput(
                    self._path(INDEX),
                    "a change by somebody else meanwhile",
                    "one writer at a time",
                    "run the command again",
                )
            index["serial"] = serial + 1
            index["changed"] = now_text()
            text = json.dumps(index, sort_keys=True, indent=1) + "\n"
            head = f"airside-library-1 {key} {sign(secret, text)}"
            self._write(f"{head}\n{text}".encode(), INDEX)
        finally:
            self._unlock()

    def _lock(self):
        self.files.makedirs(self.root, exist_ok=True)
        path = self._path(LOCK)
        for _ in range(120):
            try:
                with self.files.open(path, "xb") as file:
                    file.write(now_text().encode())
                return
            except (FileExistsError, NotImplementedError, ValueError) as error:
                if not isinstance(error, FileExistsError):
                    return  # a store that cannot create exclusively: the serial number tells
            except OSError as error:
                raise BadInput(path, str(error).lower(), "rights to write", "correct the folder's rights") from error
            time.sleep(0.5)
        raise BadInput(
            path, "a lock for more than a minute", "no other writer", "remove that file if no `airside library` runs"
        )

    def _unlock(self):
        try:
            self.files.rm(self._path(LOCK))
        except OSError:
            pass

    def find_one(self, index, beginning):
        """The full digest of the only weights that begin so."""
        if not DIGEST.fullmatch(beginning):
            raise BadInput("digest", repr(beginning), "8 to 64 hex digits", "airside library find shows them")
        found = [digest for digest in index["weights"] if digest.startswith(beginning)]
        if len(found) != 1:
            raise BadInput(
                "digest",
                f"{len(found)} weights that begin with {beginning}",
                "one",
                "give more digits" if found else "airside library find shows what is there",
            )
        return found[0]

    def blob(self, index, digest):
        """The bytes, as the index knows them."""
        data = self._read("blobs", f"{digest}.blob")
        if data is None:
            raise BadInput(
                self._path("blobs", f"{digest}.blob"),
                "no such file",
                "the blob that the index names",
                "restore or add it again",
            )
        if hashlib.sha256(data).hexdigest() != digest:
            raise BadInput(
                self._path("blobs", f"{digest}.blob"), "other bytes", "those that were added", "restore or add it again"
            )
        return data

    def put(self, index, data, entry):
        """The digest. What is known of the same bytes already is kept, and filled up by what is new."""
        digest = hashlib.sha256(data).hexdigest()
        if self._read("blobs", f"{digest}.blob") != data:
            self._write(data, "blobs", f"{digest}.blob")
        known = index["weights"].setdefault(digest, {"added": now_text(), "bytes": len(data)})
        known["content"] = content_of(data)
        for name, value in entry.items():
            if isinstance(value, dict):
                known.setdefault(name, {}).update(value)
            elif isinstance(value, list):
                known[name] = sorted(set(known.get(name, [])) | set(value))
            elif value not in (None, ""):
                known[name] = value
        return digest
