"""What a point of each kind is believed to be: limits, rate and age as tools/points/import_points writes them."""

import re

# Name in the map, N the place: (min, max, max_rate, stale_s).
USUAL = {
    "room_temp_N": (5, 45, "1.0", "1200"),
    "fcu_temp_N": (5, 45, "1.0", "1200"),
    "mau_temp": (-20, 60, "5.0", "1200"),
    "outdoor_temp": (-40, 60, "2.0", "1200"),
    "supply_temp": (-10, 60, "10.0", "1200"),
    "setpoint": (8, 32, "", ""),
    "heartbeat": (0, 65535, "", ""),
}
STALE_S = "1200"  # of every other point
# In this order: a fan coil is in a room, and its air is supplied too.
KINDS = (
    ("fcu_temp_N", r"\b(?:fcu|fan ?coil)\b|gebläsekonvektor|風機盤管"),
    ("mau_temp", r"\b(?:mau|pau|doas|make ?up|fresh air|primary air)\b"),
    ("outdoor_temp", r"\b(?:outdoor|outside|oat|oa|ambient)\b|außen|aussen|室外|外氣"),
    ("room_temp_N", r"\b(?:room|zone|space|rm|zn|znt|zt|vav)\b|\braum|室內|室溫|房間"),
    ("supply_temp", r"\b(?:supply|discharge|sat|dat|sa|da)\b|\bzuluft|送風"),
)
HEARTBEAT = r"\b(?:heart ?beat|watch ?dog|keep ?alive|life (?:counter|bit|sign))\b|lebenszeichen|心跳"


def _words(text):
    """`VAV-03/RmTmp` -> `vav rm tmp`."""
    return re.sub(r"[\W_\d]+", " ", re.sub(r"([a-z])([A-Z])", r"\1 \2", text)).lower().strip()


def is_heartbeat(name, description):
    return any(re.search(HEARTBEAT, _words(text)) for text in (name, description))


def kind_of_temperature(name, description, commandable):
    """A name of USUAL, empty where neither name nor description shows it. Of temperatures the setpoint is commanded."""
    if commandable:
        return "setpoint"
    return next((kind for text in (name, description) for kind, words in KINDS if re.search(words, _words(text))), "")
