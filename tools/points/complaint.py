"""The one shape of a complaint about a list: where, what was found, what was expected, what to do."""

MOST_LISTED = 20


class BadInput(Exception):
    """One or several complaints; nothing was written."""

    def __init__(self, complaints):
        self.complaints = complaints
        lines = complaints[:MOST_LISTED]
        if len(complaints) > MOST_LISTED:
            lines = [*lines, f"and {len(complaints) - MOST_LISTED} more"]
        super().__init__("\n".join(lines))


def complaint(place, found, expected, remedy):
    return f"{place}: found {found}; expected {expected}; {remedy}"


def refuse(place, found, expected, remedy):
    raise BadInput([complaint(place, found, expected, remedy)])


def quoted(text):
    """A cell as a complaint says it."""
    text = str(text)
    return f'"{text[:50]}{"..." if len(text) > 50 else ""}"' if text else "an empty cell"
