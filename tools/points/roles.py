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


# A list may be of several AHUs, fans or floors.
NOT_BOXES = {"ahu", "makeup", "fan", "sf", "rtu", "building", "bldg", "floor", "level"}


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


def box_words(mapping):
    """What stands before the number of a box or room: the word before {n} with which a pattern of one begins."""
    words = {"tu", "atu"}  # terminal units, which no pattern of the defaults names
    for role, patterns in mapping.roles.items():
        known = ROLES.get(role.removesuffix("_{n}"))
        if known and known.counted in ("vavs", "fcus"):
            found = [re.match(r"(?:\* )?([^\s*#]+) \{n\}", pattern) for pattern in patterns]
            words |= {mapping.in_our_words(word) for match in found if match
                      for word in match[1].rstrip("?").split("|")}
    return words


def numbered_words(readings):
    """Words that the list itself numbers: `kl` of KL-01.RmTmp and KL-02.RmTmp, but not `ai` of AI-01.SAT and AI-02.OAT."""
    numbers = {}
    for reading in readings:
        for found in re.finditer(r"([^\W\d]+) (\d+)\b", reading):
            rest = reading[:found.start(2)] + reading[found.end(2):]
            numbers.setdefault((found[1], rest), set()).add(found[2])
    return {word for (word, _), found in numbers.items() if len(found) > 1 and word not in NOT_BOXES}


class Namer:
    """Finds the role of a vendor's point."""

    def __init__(self, mapping):
        self.mapping = mapping
        self.groups = [[(role, compiled(pattern, mapping)) for role, patterns in mapping.roles.items()
                        if (role in mapping.own_roles) == is_own for pattern in patterns] for is_own in (True, False)]
        self.box_words = box_words(mapping)
        self.learn_boxes([])
        self.exact = {words_of(name): ours for name, ours in mapping.names.items()}
        self.used = set()

    def roles_of(self, name, description):
        """Names of ours that fit: none, one or several; None where the mapping leaves the point out."""
        if words_of(name) in self.exact:
            self.used.add(words_of(name))
            ours = self.exact[words_of(name)]
            return [ours] if ours else None
        return self._fitting_both(name, description, bool(self.box_of(name)))

    def _fitting_both(self, name, description, is_of_box):
        """One's own patterns before the defaults, the name before the description."""
        for patterns in self.groups:
            for text in (name, description):
                found = self._fitting(patterns, text, is_of_box)
                if found:
                    return found
        return []

    def learn_boxes(self, names):
        """From all names of the list, before the first is asked for."""
        words = self.box_words | numbered_words([self.reading(name) for name in names])
        self.box = re.compile(rf"\b(?:{'|'.join(map(re.escape, sorted(words)))}) \d+\b")

    def of_the_building(self, name, description):
        """Names of ours that would fit, did the name not carry the number of a box."""
        return self._fitting_both(name, description, False) if self.box_of(name) else []

    def box_of(self, text):
        """`vav 1`; empty where the text carries no number of a box."""
        found = self.box.search(self.reading(text))
        return found[0] if found else ""

    def reading(self, text):
        return self.mapping.in_our_words(text)

    def _fitting(self, patterns, text, is_of_box):
        for at_capitals in (True, False):  # RmTmp is `rm tmp`; where no pattern has that, it is `rmtmp`
            words = self.mapping.in_our_words(text, at_capitals) + " "
            found = []
            for role, pattern in patterns:
                match = pattern.fullmatch(words)
                place = match and match.groupdict().get("n")
                if not match or (is_of_box and not place):
                    continue
                ours = role.replace("{n}", place or "1")
                if ours not in found:
                    found.append(ours)
            if found:
                return found
        return []

    def patterns_for(self, stem):
        """Those of [roles] that name a point of this kind."""
        return self.mapping.roles.get(f"{stem}_{{n}}" if ROLES[stem].counted else stem, [])

    def pattern_like(self, stem, names):
        """A line for [roles] made of one of these names, of the one with most words of the kind."""
        wanted = set(re.findall(r"[a-z]+", " ".join(self.patterns_for(stem))))
        readings = [self.reading(name).split() for name in names]
        if ROLES[stem].counted:
            readings = [words for words in readings if any(word.isdecimal() for word in words)]
        if not readings:
            return ""
        words = max(readings, key=lambda words: len(wanted & set(words)))
        if ROLES[stem].counted:
            last = max(i for i, word in enumerate(words) if word.isdecimal())
            words[last] = "{n}"
            words = words[max(0, last - 1):]
        role = f'"{stem}_{{n}}"' if ROLES[stem].counted else stem
        return f'{role} = ["* {" ".join("#" if word.isdecimal() else word for word in words[-4:])}"]'
