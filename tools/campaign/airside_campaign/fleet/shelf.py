"""Weights of a library, and whether it has revoked those that are to be pushed."""

import os
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.fleet.weights import bytes_of_file
from airside_campaign.library import Library
from airside_campaign.lineage import Family, content_of
from airside_campaign.trusted_keys import read_trusted


def library_at(place, arguments):
    """Raises BadInput."""
    keys = Path(arguments.library_keys or os.environ.get("AIRSIDE_LIBRARY_KEYS") or "keys")
    if not keys.exists():
        raise BadInput(keys, "no such file or folder", "the public keys of the library", "give --library-keys")
    return Library(place, read_trusted(keys), arguments.at_least)


def of_library(place, arguments):
    """Bytes and name of --blob or --from-library. Raises BadInput for revoked weights, under whichever signature."""
    library = library_at(place, arguments)
    index = library.read()
    if arguments.from_library:
        digest = library.find_one(index, arguments.from_library)
        data, name = library.blob(index, digest), digest[:12]
    else:
        data, name = bytes_of_file(arguments.blob), arguments.blob
    refuse(library, index, data, name)
    return data, name


def refuse_revoked(place, arguments, data, name):
    """Raises BadInput for weights that the index, as it is now, has revoked."""
    library = library_at(place, arguments)
    refuse(library, library.read(), data, name)


def refuse(library, index, data, name):
    """Raises BadInput for revoked weights, also where the content of revoked ones is not known any more."""
    family, content = Family(index), content_of(data)
    for digest, entry in index["weights"].items():
        bad = family.why_not(digest)
        if bad and entry.get("content", "") == content:
            raise BadInput(name, bad, "weights that may be used", "choose others")
        if bad and "content" not in entry:
            library.blob(index, digest)  # says what is wrong with the blob that cannot be compared
