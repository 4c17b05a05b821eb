"""Our names and what a point of each is; and which of them a vendor's name means."""

import re

from mapping import words_of

SENTINEL = {"int16": "0x8000", "uint16": "0xFFFF"}


class Role:
    """Limits are those that `airside init` writes; `step`: the coarsest credible step of a value."""

    def __init__(self, unit, least, most, rate="", counted="", is_state=False, step=None, stale="1200"):
        self.unit, self.least, self.most, self.rate, self.counted = unit, least, most, rate, counted
        self.is_state, self.step, self.stale = is_state, step, stale


ROLES = {
    "room_temp": Role("degc", 5, 45, "1.0", "vavs", step=1),
    "fcu_temp": Role("degc", 5, 45, "1.0", "fcus", step=1),
    "vav_on": Role("", 0, 1, "", "vavs", is_state=True),
    "fcu_on": Role("", 0, 1, "", "fcus", is_state=True),
    "power": Role("kw", 0, 500, "", "powers"),
    "mau_temp": Role("degc", -20, 60, "5.0", step=1),
    "outdoor_temp": Role("degc", -40, 60, "2.0", step=1),
    "rain": Role("", 0, 1, is_state=True),
    "supply_temp": Role("degc", -10, 60, "10.0", step=1),
    "damper": Role("", 0, 1, "", "vavs", step=0.2),
    "zone_setpoint": Role("degc", 5, 45, "", "vavs", step=1),
    "zone_heating_setpoint": Role("degc", 5, 45, "", "vavs", step=1),
    "occupied": Role("", 0, 1, is_state=True),
    "supply_flow": Role("m3/s", 0, 1000),
    "ahu_on": Role("", 0, 1, is_state=True),
    "setpoint": Role("degc", 8, 32, step=1, stale=""),
    "heartbeat": Role("", 0, 65535, is_state=True, stale=""),
    "device_heartbeat": Role("", 0, 65535, is_state=True, stale=""),
}
WRITTEN = ("setpoint", "heartbeat")
# Of these a site needs a row or a stand-in each (docs/formats.md); the number is one that suits most sites.
STAND_INS = {"fcu_temp": 25, "vav_on": 1, "fcu_on": 0, "power": 4, "mau_temp": 18, "outdoor_temp": 28, "rain": 0}


def split_name(name):
    """(`room_temp`, 3, "b") of room_temp_3b; None for a name that is not ours."""
    found = re.fullmatch(r"([a-z_]+?)(?:_([1-9]\d*)([a-h]?))?", name)
    if not found or found[1] not in ROLES:
        return None
    stem, place, sensor = found[1], found[2], found[3] or ""
    if bool(ROLES[stem].counted) != bool(place) or (sensor and stem != "room_temp"):
        return None
    return stem, int(place) if place else 0, sensor


def compiled(pattern, mapping):
    """A pattern of [roles] as a regular expression on words."""
    expression = ""
    for token in pattern.split():
        optional = token.endswith("?")
        token = token.rstrip("?")
        if token == "*":
            expression += r"(?:\S+ )*?"
            continue
        if token == "{n}":
            part = r"(?P<n>\d+)"
        elif token == "#":
            part = r"\d+"
        else:
            part = "|".join(re.escape(mapping.in_our_words(word)) for word in token.split("|"))
        expression += f"(?:(?:{part}) )" + ("?" if optional else "")
    return re.compile(expression)


class Namer:
    """Finds the role of a vendor's point."""

    def __init__(self, mapping):
        self.mapping = mapping
        self.patterns = [(role, compiled(pattern, mapping)) for role, patterns in mapping.roles.items() for pattern in patterns]
        self.exact = {words_of(name): ours for name, ours in mapping.names.items()}
        self.used = set()

    def roles_of(self, name, description):
        """Names of ours that fit: none, one or several; None where the mapping leaves the point out."""
        if words_of(name) in self.exact:
            self.used.add(words_of(name))
            ours = self.exact[words_of(name)]
            return [ours] if ours else None
        for text in (name, description):
            found = self._fitting(text)
            if found:
                return found
        return []

    def _fitting(self, text):
        words = self.mapping.in_our_words(text) + " "
        found = []
        for role, pattern in self.patterns:
            match = pattern.fullmatch(words)
            if not match:
                continue
            place = match.groupdict().get("n")
            ours = role.replace("{n}", place or "1")
            if ours not in found:
                found.append(ours)
        return found
