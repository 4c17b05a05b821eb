"""What a row's object may be: `DEVICE:TYPE:INSTANCE[:PROPERTY]`, by the rules of hal/points/bacnet_row.cpp."""

from dataclasses import dataclass

from airside_bacnet.input_error import cell_text

HELD_BY_GATEWAY = "gateway"
HIGHEST_INSTANCE = 4194302  # 4194303 means "any"
PRESENT_VALUE = "present-value"
OF_LOOP = ("setpoint", "controlled-variable-value")
PROPERTIES = (PRESENT_VALUE, "relinquish-default", *OF_LOOP)
NUMBERS = ("analog-output", "analog-value", "integer-value", "positive-integer-value", "large-analog-value")
STATES = ("binary-output", "binary-value", "multi-state-output", "multi-state-value")
TYPES = ("analog-input", "analog-output", "analog-value", "binary-input", "binary-output", "binary-value",
         "multi-state-input", "multi-state-output", "multi-state-value", "accumulator", "integer-value",
         "positive-integer-value", "large-analog-value", "loop")
SYNTAX = "DEVICE:TYPE:INSTANCE, such as 1201:analog-input:3, or gateway"
WRITTEN = ("setpoint", "heartbeat")


@dataclass(frozen=True)
class ObjectName:
    device: int
    type: str
    instance: int
    prop: str = PRESENT_VALUE

    @property
    def identifier(self):
        """As bacpypes3 reads it."""
        return f"{self.type},{self.instance}"

    @property
    def text(self):
        return f"{self.device}:{self.type}:{self.instance}:{self.prop}"

    @property
    def short_text(self):
        return self.text.removesuffix(":" + PRESENT_VALUE)

    @property
    def is_whole(self):
        return self.type not in NUMBERS[:2] and self.type not in ("analog-input", "large-analog-value", "loop")


def is_instance(text):
    return text.isascii() and text.isdigit() and str(int(text)) == text and int(text) <= HIGHEST_INSTANCE


def parse_object(name, cell, complain):
    """The object of point `name`, None for what the gateway itself holds. complain(found, expected, remedy) raises."""
    if name == "map_fingerprint" and cell != HELD_BY_GATEWAY:
        complain(cell_text(cell), "gateway, which shows the fingerprint of the map that it has read", "write gateway")
    if cell == HELD_BY_GATEWAY:
        if name in ("heartbeat", "map_fingerprint"):
            return None
        complain(f'"gateway" for {name}', "an object of a device", f"write {SYNTAX}")
    parts = cell.split(":")
    if not 3 <= len(parts) <= 4:
        complain(cell_text(cell), SYNTAX, "`airside-bacnet --discover` lists the objects of a device in this form")
    device, kind, instance = parts[:3]
    wrong = [part for part in (device, instance) if not is_instance(part)]
    if wrong:
        complain(f"{cell_text(wrong[0])} in {cell_text(cell)}", f"an instance number from 0 to {HIGHEST_INSTANCE}",
                 "give device and object by their instance numbers")
    if kind not in TYPES:
        complain(f"{cell_text(kind)} in {cell_text(cell)}", f"one of {', '.join(TYPES)}",
                 "use one of these types, in lower case")
    prop = parts[3] if len(parts) == 4 else PRESENT_VALUE
    if prop not in PROPERTIES or (prop in OF_LOOP and kind != "loop"):
        complain(f"{cell_text(prop)} in {cell_text(cell)}", f"one of {', '.join(PROPERTIES)}; the last two of a loop",
                 "leave the property out for present-value")
    if name in WRITTEN:
        fitting = NUMBERS if name == "setpoint" else (*NUMBERS, *STATES)
        if prop != PRESENT_VALUE or kind not in fitting:
            complain(cell_text(cell), f"the present-value of one of {', '.join(fitting)}, since {name} is written",
                     "name the object that holds the setpoint" if name == "setpoint"
                     else "name an object that the AHU watches, or write gateway")
    return ObjectName(int(device), kind, int(instance), prop)
