"""Bad input, said so that its owner can correct it."""


class BadInput(Exception):
    """Place, what was found, what was expected and what to do."""

    def __init__(self, place, found, expected, remedy):
        super().__init__(f"{place}: found {found}; expected {expected}; {remedy}")
