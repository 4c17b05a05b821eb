"""From what a BACnet property says to a number that may be believed, or the reason why it may not."""

import math
from dataclasses import dataclass

FAULT, OUT_OF_SERVICE = 1, 3  # bits of status-flags; 0 in alarm, 2 overridden: the value is still what is there


@dataclass(frozen=True)
class Reading:
    value: float  # NaN where `why` says something
    why: str = ""

    @property
    def is_good(self):
        return not self.why


def no_reading(why):
    return Reading(math.nan, why)


def as_number(value):
    """Reals, integers and states; active is 1. None for what is no number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


def judge(properties):
    """`properties`: of one object, property name -> value, or a text that says why there is none."""
    value = properties.get("value")
    if value is None or isinstance(value, str):
        return no_reading(value or "no value")
    number = as_number(value)
    if number is None:
        return no_reading(f"no number ({value})")
    flags = properties.get("status-flags")
    if flags is not None and not isinstance(flags, str):
        if flags[FAULT]:
            reliability = properties.get("reliability")
            return no_reading(f"fault ({reliability})" if reliability is not None and not isinstance(reliability, str)
                              else "fault")
        if flags[OUT_OF_SERVICE]:
            return no_reading("out of service")
    reliability = properties.get("reliability")
    if reliability is not None and not isinstance(reliability, str) and int(reliability) != 0:
        return no_reading(f"reliability {reliability}")
    return Reading(number)
