"""Arguments of the wrong type are refused here, in the words of every other complaint."""

from __future__ import annotations

import datetime
import operator
import os
from typing import Any

import numpy as np

from ._errors import InputError

MOST_SEED = 2**63 - 1


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Takes what is an integer to Python, numpy's too."""
    expected = f"a whole number from {least} to {most}"
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(name, repr(value), expected, "write it without quotes and point") from None
    if isinstance(value, (bool, np.bool_)):
        raise InputError(name, repr(value), expected, "write a number")
    if not least <= number <= most:
        raise InputError(name, str(number), expected, "choose another")
    return number


def text(name: str, value: Any, example: str) -> str:
    if not isinstance(value, str):
        raise InputError(name, repr(value), f'a text such as "{example}"', "put it in quotes")
    return value


def text_or_none(name: str, value: Any, example: str) -> str | None:
    return None if value is None else text(name, value, example)


def flag(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(name, repr(value), "True or False", "write one of the two")
    return bool(value)


def path(name: str, value: Any) -> str:
    found = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if not isinstance(found, str):
        raise InputError(name, repr(value), "a path: a text or a pathlib.Path", "put it in quotes")
    return found


def path_or_none(name: str, value: Any) -> str | None:
    return None if value is None else path(name, value)


def site(value: Any) -> str | None:
    """Of a folder its site.toml."""
    found = path_or_none("site", value)
    return os.path.join(found, "site.toml") if found is not None and os.path.isdir(found) else found


def room(value: Any) -> str:
    """Name of a built-in room, as a number too, or a room file."""
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
        return str(value)
    if not isinstance(value, (str, os.PathLike)):
        raise InputError("room", repr(value), 'a room such as "301-real", or a room file', "put it in quotes")
    return path("room", value)


def day(name: str, value: Any) -> str:
    if isinstance(value, datetime.date) and not isinstance(value, datetime.datetime):
        return value.isoformat()
    return text(name, value, "2021-08-01")
