"""A library of weight blobs with a signed index: who trained what, on what, how good it is, what it was made from."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.from_campaign import of_campaign
from airside_campaign.library import MAX_BLOB_BYTES, Library, now_text
from airside_campaign.lineage import Family
from airside_campaign.trusted_keys import read_secret, read_trusted

EPILOG = """\
  airside keygen -o me                                   once: me.key signs the index, me.pub is for readers
  airside library add room301.blob --key me.key          or a folder that `airside campaign` left
  airside library find --topology 5vav-5fcu-2power
  airside library get 3f2a91c0 -o room301.blob
Exit codes: 0 done; 1 bad input, or nothing found; 2 bad command line."""


def parser():
    p = argparse.ArgumentParser(
        prog="airside library", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG
    )
    p.add_argument("--program", default="airside", help=argparse.SUPPRESS)
    actions = p.add_subparsers(dest="action", required=True, metavar="ACTION")

    def action(name, text, writes=False, digests=None):
        a = actions.add_parser(name, help=text, description=text)
        a.add_argument(
            "--library",
            default=os.environ.get("AIRSIDE_LIBRARY", "library"),
            metavar="ADDRESS",
            help="folder, or what fsspec knows, such as s3://bucket/weights (default: $AIRSIDE_LIBRARY, else ./library)",
        )
        a.add_argument(
            "--keys",
            metavar="PLACE",
            help="public keys that are believed: a .pub file, or a folder of them (default: $AIRSIDE_LIBRARY_KEYS, else "
            "the .pub beside --key, else ./keys)",
        )
        a.add_argument(
            "--at-least",
            type=int,
            default=0,
            metavar="SERIAL",
            help="refuse an index that is older: somebody put it back",
        )
        a.add_argument("--json", action="store_true", help="print one JSON object and nothing else on standard output")
        if writes:
            a.add_argument("--key", required=True, help="secret key that signs the index (airside keygen)")
        if digests:
            a.add_argument("digests", nargs=digests, metavar="DIGEST", help="the first 8 or more digits")
        return a

    add = action("add", "add blobs, or all that a campaign's folder has, with what is known of them", writes=True)
    add.add_argument("sources", nargs="+", metavar="FILE", help="*.blob, or a folder that `airside campaign` left")
    add.add_argument("--room", help="whose room or which building")
    add.add_argument("--twin", help="what it was trained on, such as a model's name")
    add.add_argument("--data", metavar="FROM..TO", help="the days that it has learned from, 2021-07-01..2021-07-31")
    add.add_argument("--by", help="who trained it (default: the key's name)")
    add.add_argument("--parent", action="append", default=[], metavar="DIGEST", help="weights that it was made from")
    add.add_argument("--effect", action="append", default=[], metavar="NAME", help="an effect that the twin has")
    add.add_argument("--figure", action="append", default=[], metavar="NAME=NUMBER", help="how good it was")
    find = action("find", "list weights, newest first; those that are revoked, or made from such, only with --all")
    find.add_argument("--topology", help="such as 5vav-5fcu-2power")
    find.add_argument("--room", help="part of the room's name")
    find.add_argument("--effect", help="an effect that the twin must have")
    find.add_argument("--all", action="store_true", help="revoked ones too")
    action("show", "all that is known of weights", digests=1)
    action("lineage", "what weights were made from, and what was made from them", digests=1)
    revoke = action("revoke", "mark weights as not to be used, and with them all that was made from them", True, "+")
    revoke.add_argument("--why", required=True, help="in words, for whoever asks later")
    get = action("get", "write a blob to a file; one that is revoked only with --revoked", digests=1)
    get.add_argument("-o", "--out", required=True, help="the file")
    get.add_argument("--revoked", action="store_true", help="though it is revoked, to look into")
    action("check", "read every blob and compare it with the index")
    return p


def trusted_of(arguments):
    place = arguments.keys or os.environ.get("AIRSIDE_LIBRARY_KEYS")
    if place is None and getattr(arguments, "key", None):
        beside = Path(arguments.key).with_suffix(".pub")
        place = beside if beside.is_file() else None
    place = Path(place or "keys")
    if not place.exists():
        raise BadInput(place, "no such file or folder", "the public keys that are believed", "give them with --keys")
    return read_trusted(place)


def inspected(program, path):
    """What the program itself reads in a blob."""
    if Path(path).stat().st_size > MAX_BLOB_BYTES:
        raise BadInput(path, f"{Path(path).stat().st_size} bytes", "a weight blob", "give a file of airside pretrain")
    done = subprocess.run(
        [program, "blob", "inspect", "--json", str(path)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BadInput(path, done.stderr.strip() or "no weights", "a weight blob", "give a file of airside pretrain")
    facts = json.loads(done.stdout)
    head = facts["header"]
    entry = {
        "topology": head["topology"],
        "learned_until": head["created"],
        "cycle_min": head["cycle_min"],
        "provenance": facts.get("provenance", ""),
    }
    if head.get("key", "unsigned") != "unsigned":
        entry["signed_by"], entry["security_counter"] = head["key"], head["security_counter"]
    return entry


def of_arguments(arguments, key_name):
    figures = {}
    for text in arguments.figure:
        name, _, number = text.partition("=")
        try:
            figures[name] = float(number)
        except ValueError:
            raise BadInput("--figure", text, "NAME=NUMBER", "such as --figure dae_degc=0.045") from None
    entry = {
        "room": arguments.room,
        "twin": arguments.twin,
        "by": arguments.by or key_name,
        "effects": arguments.effect,
    }
    if arguments.data:
        begin, dots, end = arguments.data.partition("..")
        if not dots or not begin or not end:
            raise BadInput("--data", arguments.data, "FROM..TO", "such as --data 2021-07-01..2021-07-31")
        entry["data"] = {"from": begin, "to": end}
    if figures:
        entry["figures"] = figures
    return {name: value for name, value in entry.items() if value}


def blob_of(program, path, said, made_from):
    """The file, its bytes, what is known of it, and digests of what it was made from."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BadInput(path, error.strerror.lower(), "a weight blob", "check the path and its rights") from error
    return path, data, {**inspected(program, path), **said}, made_from


def add(arguments, library):
    secret, key_name = read_secret(arguments.key)
    given = of_arguments(arguments, key_name)
    added = []
    with library.change(secret, begin=True) as index:
        parents = [library.find_one(index, p) for p in arguments.parent]
        sources = []
        for source in map(Path, arguments.sources):
            sources += of_campaign(source) if source.is_dir() else [(source, {}, [])]
        read = [blob_of(arguments.program, *source) for source in sources]
        for path, data, entry, made_from in read:  # all are sound: nothing is written before
            figures = {**entry.get("figures", {}), **given.get("figures", {})}
            digest = library.put(index, data, {**entry, **given, "figures": figures, "parents": parents + made_from})
            added.append({"digest": digest, "file": str(path)})
    if arguments.json:
        print(json.dumps({"added": added}))
    else:
        for one in added:
            print(f"{one['digest'][:12]}  {one['file']}")
    return 0


def line_of(digest, family):
    entry = family.weights[digest]
    figures = "  ".join(f"{name} {value:.4g}" for name, value in sorted(entry.get("figures", {}).items())[:3])
    bad = family.why_not(digest)
    return (
        f"{digest[:12]}  {entry.get('topology', '?'):18}  {entry.get('room', '-'):14}  {entry['added'][:10]}  {figures}"
        + (f"  [{bad}]" if bad else "")
    ).rstrip()


def find(arguments, library):
    index = library.read()
    family = Family(index)
    found = []
    for digest, entry in index["weights"].items():
        if arguments.topology and entry.get("topology") != arguments.topology:
            continue
        if arguments.room and arguments.room.lower() not in entry.get("room", "").lower():
            continue
        if arguments.effect and arguments.effect not in entry.get("effects", []):
            continue
        if not arguments.all and family.why_not(digest):
            continue
        found.append((entry["added"], digest))
    found.sort(reverse=True)
    if arguments.json:
        rows = [{"digest": d, **index["weights"][d], "why_not": family.why_not(d)} for _, d in found]
        print(json.dumps({"serial": index["serial"], "weights": rows}))
    else:
        for _, digest in found:
            print(line_of(digest, family))
        if not found:
            print(f"nothing like that among {len(index['weights'])} weights", file=sys.stderr)
    return 0 if found else 1


def show(arguments, library):
    index = library.read()
    digest = library.find_one(index, arguments.digests[0])
    entry = {"digest": digest, **index["weights"][digest], "why_not": Family(index).why_not(digest)}
    print(json.dumps(entry) if arguments.json else json.dumps(entry, indent=1, ensure_ascii=False))
    return 0


def lineage(arguments, library):
    index = library.read()
    digest = library.find_one(index, arguments.digests[0])
    family = Family(index)
    before, after, copies = family.parents(digest), family.children(digest), family.same(digest)[1:]
    if arguments.json:
        print(json.dumps({"digest": digest, "made_from": before, "made_of_it": after, "signed_copies": copies}))
        return 0
    for title, digests in (
        ("made from", before),
        ("these weights", [digest]),
        ("the same under another signature", copies),
        ("made of them", after),
    ):
        print(f"{title}:" + ("" if digests else " nothing"))
        for at in digests:
            print("  " + line_of(at, family))
    return 0


def revoke(arguments, library):
    secret, key_name = read_secret(arguments.key)
    with library.change(secret) as index:
        digests = [library.find_one(index, d) for d in arguments.digests]
        for digest in digests:
            index["weights"][digest].setdefault("revoked", {"why": arguments.why, "by": key_name, "at": now_text()})
        family = Family(index)
        copies = sorted({c for d in digests for c in family.same(d)} - set(digests))
        hit = sorted({c for d in digests for c in family.children(d)} - {*digests, *copies})
    if arguments.json:
        print(json.dumps({"revoked": digests, "signed_copies": copies, "made_from_them": hit}))
        return 0
    for digest in digests:
        print(f"{digest[:12]} is revoked")
    for digest in copies:
        print(f"{digest[:12]} is the same under another signature, and is not given out either")
    for digest in hit:
        print(f"{digest[:12]} was made from it, and is not given out either")
    if any(index["weights"][d].get("signed_by") for d in [*digests, *copies, *hit]):
        print("boxes that have them keep them: push others, or airside rollback", file=sys.stderr)
    return 0


def get(arguments, library):
    index = library.read()
    digest = library.find_one(index, arguments.digests[0])
    bad = Family(index).why_not(digest)
    if bad and not arguments.revoked:
        raise BadInput(digest[:12], bad, "weights that may be used", "choose others, or --revoked to look into these")
    data = library.blob(index, digest)
    out = Path(arguments.out)
    try:
        with tempfile.NamedTemporaryFile(dir=out.parent, prefix=f".{out.name}.", delete=False) as staged:
            staged.write(data)
        os.chmod(staged.name, 0o644)
        os.replace(staged.name, out)
    except OSError as error:
        raise BadInput(out, error.strerror.lower(), "a file that can be written", "check the folder") from error
    print(json.dumps({"digest": digest, "file": str(out)}) if arguments.json else f"{digest[:12]} is in {out}")
    return 0


def check(arguments, library):
    index = library.read()
    wrong = []
    for digest in sorted(index["weights"]):
        try:
            library.blob(index, digest)
        except BadInput as error:
            wrong.append(str(error))
    if arguments.json:
        print(json.dumps({"serial": index["serial"], "weights": len(index["weights"]), "wrong": wrong}))
    else:
        for text in wrong:
            print(text, file=sys.stderr)
        print(f"{len(index['weights'])} weights, {len(wrong)} not in order; index {index['serial']}")
    return 1 if wrong else 0


ACTIONS = {
    "add": add,
    "find": find,
    "show": show,
    "lineage": lineage,
    "revoke": revoke,
    "get": get,
    "check": check,
}


def main(words=None):
    arguments = parser().parse_args(words)
    try:
        library = Library(arguments.library, trusted_of(arguments), arguments.at_least)
        return ACTIONS[arguments.action](arguments, library)
    except BadInput as error:
        print(f"airside library: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
