"""The weights of a push, and everything for which they are refused before the first box sees them."""

import hashlib
import json
import os
import re
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.fleet.box import ran

MAX_BLOB_BYTES = 1 << 20  # the longest blob has some 275 kB


@dataclass(frozen=True)
class Weights:
    path: Path  # of a copy that nobody changes meanwhile
    name: str  # as it was given
    digest: str  # SHA-256 of the bytes
    crc: str  # as a box's status names them
    topology: str
    key: str
    provenance: str


def _crc_table():
    table = []
    for at in range(256):
        for _ in range(8):
            at = at >> 1 ^ (0x82F63B78 if at & 1 else 0)
        table.append(at)
    return table


CRC_TABLE = _crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def place_of(arguments):
    return arguments.library or os.environ.get("AIRSIDE_LIBRARY")


def bytes_of(arguments):
    """What is to be pushed, and its name. Raises BadInput, also for what the library has revoked."""
    place = place_of(arguments)
    if place is not None:
        from airside_campaign.fleet.shelf import of_library  # its packages take longer to load than all of this

        return of_library(place, arguments)
    if arguments.from_library:
        raise BadInput("--library", "nothing", "where the library is", "give --library or set $AIRSIDE_LIBRARY")
    return bytes_of_file(arguments.blob), arguments.blob


def bytes_of_file(path):
    try:
        size = Path(path).stat().st_size
        if size > MAX_BLOB_BYTES:
            raise BadInput(path, f"{size} bytes", "a signed weight blob", "give another file")
        return Path(path).read_bytes()
    except OSError as error:
        raise BadInput(path, error.strerror.lower(), "a signed weight blob", "check the path and its rights") from error


def read_weights(arguments, fleet, program, folder):
    """A copy in `folder`, checked against each topology and cycle of the fleet. Raises BadInput."""
    data, name = bytes_of(arguments)
    path = Path(folder) / "fleet.blob"
    path.write_bytes(data)
    done = subprocess.run(
        [program, "blob", "inspect", "--json", str(path)], capture_output=True, text=True, check=False
    )
    try:
        facts = json.loads(done.stdout)
        head = facts["header"]
    except (ValueError, KeyError) as error:
        raise no_blob(done.stderr, path, name) from error
    if head["key"] == "unsigned":
        raise BadInput(
            name, "an unsigned blob", "a signed one, since boxes take no other", f"airside sign {name} --key YOUR.key"
        )
    if not fleet.keys.exists():
        raise BadInput(
            f"{fleet.path}: fleet.keys",
            f"no {fleet.keys}",
            "the public keys that the boxes believe",
            "copy a box's keys folder (it is beside its site.toml) or the NAME.pub of `airside keygen` there",
        )
    try_on_kinds(program, path, name, fleet, folder)
    return Weights(
        path=path,
        name=str(name),
        digest=hashlib.sha256(data).hexdigest(),
        crc=f"{crc32c(data):08x}",
        topology=head["topology"],
        key=head["key"],
        provenance=facts.get("provenance", ""),
    )


def check_again(arguments, fleet, program, weights, folder):
    """Reads the library's index and the keys anew. Raises BadInput where the weights may not go out any more."""
    place = place_of(arguments)
    if place is not None:
        from airside_campaign.fleet.shelf import refuse_revoked

        refuse_revoked(place, arguments, weights.path.read_bytes(), weights.name)
    try_on_kinds(program, weights.path, weights.name, fleet, folder)


def try_on_kinds(program, path, name, fleet, folder):
    """Raises BadInput for weights that any kind of box in the fleet would refuse."""
    for topology, cycle in sorted({(box.topology, box.cycle_min) for box in fleet.boxes.values()}):
        try_on_site(program, path, name, trial_site(folder, topology, cycle, fleet.keys), fleet.path)


def no_blob(said, path, name):
    """The program's complaint of the copy at `path`, as one of the user's file."""
    text = (said.strip().splitlines() or [""])[-1].removeprefix("airside: ").replace(str(path), str(name))
    parts = re.fullmatch(r"(.+?): found (.+); expected (.+?); (.+)", text)
    if parts:
        return BadInput(*parts.groups())
    return BadInput(name, text or "no weights", "a signed weight blob", "give a file that `airside sign` wrote")


def trial_site(folder, topology, cycle_min, keys):
    """A site file as the boxes of a group have it, for the program's own checks."""
    path = Path(folder) / f"{topology}-{cycle_min}.toml"
    keys = keys.resolve()
    if keys.is_file():  # one key: a folder with a copy
        place = Path(folder) / "keys"
        place.mkdir(exist_ok=True)
        (place / "one.pub").write_bytes(keys.read_bytes())
        keys = place
    path.write_text(
        f'[site]\nname = "fleet"\ntopology = "{topology}"\nscope = "every site of a fleet"\n'
        f"[controller]\ncycle_min = {cycle_min}\n[weights]\nkeys = {json.dumps(str(keys), ensure_ascii=False)}\n"
        '[inbox]\ndir = "inbox"\n',
        encoding="utf-8",
    )
    return path


def try_on_site(program, blob, name, site, place):
    """Pushes into an empty folder, checked against a site: key, signature, topology, units, cycle, scope."""
    with tempfile.TemporaryDirectory(prefix="airside-fleet-") as inbox:
        _, code, said = ran([str(program), "push", str(blob), inbox, "--site", str(site)])
    if code != 0:
        said = said.removeprefix("airside: ").replace(str(blob), str(name))
        raise BadInput(
            place, f"weights that its boxes would refuse ({said})", "weights for every box", "nothing is sent"
        )
