"""Cells of a vendor's list as values: addresses, scales, types, units, orders. Each raises Wrong with what to say."""

import re

from complaint import quoted
from mapping import plain

AREA = {"0": 1, "1": 2, "3": 4, "4": 3}  # leading digit of a Modicon number -> read function
# What a unit becomes: (our unit, factor, constant).
CONVERSIONS = {
    "degc": ("degc", 1.0, 0.0), "degf": ("degc", 5 / 9, -160 / 9), "kelvin": ("degc", 1.0, -273.15),
    "kw": ("kw", 1.0, 0.0), "w": ("kw", 1e-3, 0.0), "percent": ("", 0.01, 0.0), "none": ("", 1.0, 0.0),
    "m3s": ("m3/s", 1.0, 0.0), "ls": ("m3/s", 1e-3, 0.0), "m3h": ("m3/s", 1 / 3600, 0.0),
    "cfm": ("m3/s", 0.0004719474432, 0.0)}
ORDERS = {"ABCD": ("big", "big"), "CDAB": ("big", "little"), "BADC": ("little", "big"), "DCBA": ("little", "little")}


class Wrong(Exception):
    """What was found, expected, and what to do; the caller adds the place."""

    def __init__(self, found, expected, remedy):
        super().__init__(found)
        self.found, self.expected, self.remedy = found, expected, remedy


class Address:
    """A register as the list writes it. `digits`: the decimal number as text, with its leading zeros; empty of the others."""

    def __init__(self, number, digits="", function=None, last=None):
        self.number, self.digits, self.function, self.last = number, digits, function, last

    @property
    def looks_modicon(self):
        return len(self.digits) in (5, 6) and self.digits[0] in AREA and int(self.digits[1:]) > 0


def parse_address(text):
    text = text.strip()
    expected = "a register such as 40001, 30001, 12 or 0x000C"
    plain_number = text.replace(" ", "")
    if re.fullmatch(r"[-+]?\d+[.,]\d+", plain_number):
        raise Wrong(f"{quoted(text)}, which looks like one bit of a register", "a whole register; points.csv reads no bits of one",
                    'leave the point out ("name" = "" in [names]), or ask for a coil or a register of its own')
    hexadecimal = re.fullmatch(r"0[xX]([0-9A-Fa-f]+)|([0-9A-Fa-f]+)[hH]", plain_number)
    if hexadecimal:  # 0x0012 too, which some lists mean as coil 12: a column of the function then says so
        return Address(int(hexadecimal[1] or hexadecimal[2], 16))
    area = re.fullmatch(r"([134])[xX:](\d{1,5})", plain_number)
    if area:
        return Address(int(area[2]), area[1] + area[2].zfill(4))
    prefixed = re.fullmatch(r"(HR|IR|DI|CO|C|%?MW)[:\-_]?(\d+)", plain_number, re.IGNORECASE)
    if prefixed:
        kind = prefixed[1].upper().lstrip("%")
        return Address(int(prefixed[2]), "", {"HR": 3, "MW": 3, "IR": 4, "DI": 2, "CO": 1, "C": 1}[kind])
    span = re.fullmatch(r"(\d+)\s*(?:-|\.\.|\u2013|/)\s*(\d+)", text)
    if span and int(span[2]) in (int(span[1]), int(span[1]) + 1):
        return Address(int(span[1]), span[1], last=int(span[2]))
    if not plain_number.isdecimal():
        raise Wrong(quoted(text), expected, "write one register, the first where there are two")
    return Address(int(plain_number), plain_number)


def style_of(addresses, headings):
    """How the list counts: modicon, zero-based or one-based; raises Wrong where it does not show."""
    text = plain(headings)
    for words, style in ((("0 based", "zero based", "from 0", "base 0", "ab 0", "從0", "從 0"), "zero-based"),
                         (("1 based", "one based", "from 1", "base 1", "ab 1", "從1", "從 1"), "one-based")):
        if any(word in text for word in words):
            return style
    decimals = [a for a in addresses if a.digits]
    large = [a for a in decimals if a.looks_modicon and a.digits[0] != "0"]
    if large and all(a.looks_modicon or a.number < 10000 for a in decimals):
        return "modicon"
    if decimals and all(a.looks_modicon for a in decimals):
        return "modicon"
    if any(not a.digits and a.function is None for a in addresses) or any(a.number == 0 for a in addresses):
        return "zero-based"
    lowest = min((a.number for a in addresses), default=0)
    raise Wrong(f"registers from {lowest} on, which may count from 0 or from 1", "a list that shows it: 40001, 0x0000, a "
                "register 0, or (0-based) in the heading",
                "give --addresses zero-based or --addresses one-based; airside probe shows which one is right")


def protocol_address(address, style, function):
    """(read function, address from 0)."""
    if not address.digits and address.function is None:
        number, own = address.number, None  # hexadecimal: the protocol's own
    elif style == "modicon" and address.looks_modicon:
        number, own = int(address.digits[1:]) - 1, AREA[address.digits[0]]
    elif style == "modicon":
        number, own = address.number - 1, 1  # 00017 as a spreadsheet shows it
    else:
        number, own = address.number - (style == "one-based"), address.function
    if own and function and own != function:
        raise Wrong(f"{address.digits or address.number}, which function {own} reads, beside function {function}",
                    "the two to agree", "correct one of them, or give --addresses if the number is no Modicon number")
    if not (own or function):
        raise Wrong(f"the register {address.number} without a function", "a column of the function, or 40001 and the like",
                    "add a column Function (coil, discrete, holding, input), or function in [list] of a file for --map")
    if not 0 <= number <= 65535:
        raise Wrong(f"the register {address.number}, that is {number} counted from 0", "0 to 65535",
                    "correct the register, or give --addresses")
    return own or function, number


def parse_function(text, mapping):
    known = mapping.word("functions", text)
    if known:
        return int(known)
    code = re.match(r"\W*(?:fc|f|function|code)?\W*0*([1-4])\b", text, re.IGNORECASE)
    if not code:
        raise Wrong(quoted(text), "a reading function: " + mapping.accepted("functions"), "write 1, 2, 3 or 4")
    return int(code[1])


def parse_number(text, decimal):
    """With the decimal sign of the list; a sign of thousands is refused, since it might be the other one."""
    text = text.strip().replace("\u2212", "-")
    if "," in text and "." in text or (("," if decimal == "." else ".") in text):
        raise Wrong(quoted(text), f"a number with a decimal {'point' if decimal == '.' else 'comma'} and no sign of thousands",
                    "write it as 0.1, or give --decimal , or --decimal . for the whole list")
    try:
        value = float(text.replace(",", "."))
        if value in (float("inf"), float("-inf")) or value != value or "_" in text:
            raise ValueError
    except ValueError:
        raise Wrong(quoted(text), "a number such as 0.1", "correct the cell") from None
    return value


def parse_scale(text, decimal):
    """0.1, x0.1, /10, 1/10."""
    text = text.strip()
    divided = re.fullmatch(r"(?:1\s*)?[/:÷]\s*(.+)|div(?:ide)?(?: by)?\s*(.+)", text, re.IGNORECASE)
    value = parse_number((divided[1] or divided[2]) if divided else re.sub(r"^[xX×*]\s*", "", text), decimal)
    if value == 0:
        raise Wrong(quoted(text), "a factor other than 0", "write 1 where there is none")
    return 1 / value if divided else value
