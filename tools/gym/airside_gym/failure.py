"""The one exception of this package."""


class AirsideError(RuntimeError):
    """Bad input, or a program or bus that failed; the message says what was found, what was expected and what to do."""


def refused(where, found, expected, remedy):
    """AirsideError in the words of the program's own complaints."""
    return AirsideError(f"{where}: found {found}; expected {expected}; {remedy}")
