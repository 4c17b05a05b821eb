"""Bad input, said so that its owner can correct it."""

import difflib


class BadInput(Exception):
    """Place, what was found, what was expected and what to do."""

    def __init__(self, place, found, expected, remedy):
        super().__init__(f"{place}: found {found}; expected {expected}; {remedy}")


def nearest(name, known):
    """The known name that was probably meant, or None: a close one, else the shortest that begins with it."""
    close = difflib.get_close_matches(name, known, 1)
    return close[0] if close else min((k for k in known if k.startswith(name)), key=len, default=None)
