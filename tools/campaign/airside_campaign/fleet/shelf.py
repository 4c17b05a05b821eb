"""Weights of a library, and whether it has revoked those that are to be pushed."""

import hashlib
import os
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.fleet.weights import bytes_of_file
from airside_campaign.library import Library, why_not
from airside_campaign.trusted_keys import read_trusted

HEADER_BYTES, SIGNATURE_BYTES = 192, 64


def unsigned(data):
    """The bytes without what a signature changes: counter, key, site, digest, signature (docs/formats.md)."""
    if len(data) < HEADER_BYTES + SIGNATURE_BYTES:
        return data
    return data[:40] + data[88:104] + data[136:-SIGNATURE_BYTES]


def of_library(place, arguments):
    """Bytes and name of --blob or --from-library. Raises BadInput for revoked weights, under whichever signature."""
    keys = Path(arguments.library_keys or os.environ.get("AIRSIDE_LIBRARY_KEYS") or "keys")
    if not keys.exists():
        raise BadInput(keys, "no such file or folder", "the public keys of the library", "give --library-keys")
    library = Library(place, read_trusted(keys), arguments.at_least)
    index = library.read()
    if arguments.from_library:
        digest = library.find_one(index, arguments.from_library)
        data, name = library.blob(index, digest), digest[:12]
    else:
        data, name = bytes_of_file(arguments.blob), arguments.blob
    for other in index["weights"]:
        bad = why_not(index, other)
        same = other == hashlib.sha256(data).hexdigest()
        if bad and (same or unsigned(library.blob(index, other)) == unsigned(data)):
            raise BadInput(name, bad, "weights that may be used", "choose others")
    return data, name
