"""The one complaint about input, in its four parts."""

from __future__ import annotations

import re

_OPTION = re.compile(r"--([a-z][a-z-]*)")


class InputError(ValueError):
    """Something that was given cannot be used; nothing was changed or half-written.

    Its text is "PLACE: found FOUND; expected EXPECTED; REMEDY", as the programs print it.
    """

    def __init__(self, place: str, found: str, expected: str, remedy: str) -> None:
        super().__init__(f"{place}: found {found}; expected {expected}; {remedy}")
        self.place = place
        """File and line, file and field, or the argument."""
        self.found = found
        """What was found there."""
        self.expected = expected
        """What was expected."""
        self.remedy = remedy
        """What to do."""

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str, str]]:
        return type(self), (self.place, self.found, self.expected, self.remedy)

    @classmethod
    def in_pythons_words(cls, place: str, found: str, expected: str, remedy: str) -> InputError:
        """Of a complaint of the programs: their option --reference-days is the argument reference_days."""

        def argument(option: re.Match[str]) -> str:
            return option[1].replace("-", "_")

        return cls(*(_OPTION.sub(argument, text) for text in (place, found, expected, remedy)))
