"""The one shape of a complaint about input, as hal/text/input_error.hpp has it."""


class InputError(Exception):
    def __init__(self, place, found, expected, remedy):
        super().__init__(f"{place}: found {found}; expected {expected}; {remedy}")
        self.place, self.found, self.expected, self.remedy = place, found, expected, remedy


def cell_text(text):
    return f'"{text[:60]}"' if text else "an empty cell"
