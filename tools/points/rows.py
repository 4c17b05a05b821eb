"""From the rows of a list to the rows of points.csv."""

import re
from dataclasses import dataclass, field

from complaint import BadInput, complaint, quoted
from fields import (CONVERSIONS, ORDERS, Wrong, parse_address, parse_function, parse_number, parse_scale,
                    protocol_address, style_of)
from guesses import guessed_columns
from mapping import plain
from roles import ROLES, SENTINEL, STAND_INS, WRITTEN, split_name

COLUMNS = ("name", "unit", "fc", "addr", "type", "byte_order", "word_order", "scale", "offset", "min", "max", "max_rate",
           "stale_s", "sentinel", "write_policy", "fc_write", "default", "readback")
BACNET_COLUMNS = ("name", "unit", "protocol", "object", "scale", "offset", "min", "max", "max_rate", "stale_s")
HELD = {"int16": (-32768, 32767), "uint16": (0, 65535), "int32": (-2**31, 2**31 - 1), "uint32": (0, 2**32 - 1),
        "float32": (-3e38, 3e38)}
INTEGERS = ("int16", "uint16", "int32", "uint32")
WIDE = ("int32", "uint32", "float32")
HIGHEST_INSTANCE = 4194302
COMMANDABLE = ("analog-output", "analog-value")


@dataclass
class Source:
    """A row of the list that has a name."""
    number: int
    cells: list
    name: str
    description: str
    ours: str = ""
    has_place: bool = True  # a register or an object


@dataclass
class Result:
    text: str = ""
    points: dict = field(default_factory=dict)  # our name -> row number in the list
    left_out: list = field(default_factory=list)  # (place, the vendor's name, what to do)
    notes: list = field(default_factory=list)
    counts: dict = field(default_factory=dict)
    protocol: str = "modbus"


class Importer:
    def __init__(self, table, heading, mapping, namer, options):
        self.table, self.heading, self.mapping, self.namer, self.options = table, heading, mapping, namer, options
        self.complaints, self.result = [], Result(notes=list(table.notes))
        self.style = ""
        self.unused_is_said = False
        self.unscaled, self.unordered = [], []  # rows whose scale, names whose order nobody gave
        place = heading.places.get("address")
        self.is_hexadecimal = place is not None and "hex" in plain(heading.cells[place]).split()

    # ---- Cells

    def cell(self, source, key):
        place = self.heading.places.get(key)
        return source.cells[place] if place is not None and place < len(source.cells) else ""

    def address_text(self, source):
        text = self.cell(source, "address")
        return "0x" + text if self.is_hexadecimal and re.fullmatch(r"[0-9A-Fa-f]{1,4}", text) else text

    def complain(self, source, key, found, expected, remedy):
        place = self.heading.places.get(key)
        where = (self.table.row_place(source.number) if place is None else
                 self.table.place(source.number, place, self.heading.cells[place]))
        self.complaints.append(complaint(where, found, expected, remedy))

    def checked(self, source, key, read, *arguments):
        """read(cell, ...); None after a complaint."""
        try:
            return read(*arguments)
        except Wrong as wrong:
            self.complain(source, key, wrong.found, wrong.expected, wrong.remedy)
            return None

    # ---- Names

    def sources(self):
        found = []
        for number, cells in self.table.rows:
            if number <= self.heading.number:
                continue
            source = Source(number, cells, "", "")
            source.name, source.description = self.cell(source, "name"), self.cell(source, "description")
            where = [self.cell(source, key) for key in ("address", "object", "instance")]
            if not source.name and not any(where):
                continue  # a title between blocks
            if not source.name:
                self.complain(source, "name", "an empty cell", "the point's name", "fill it in, or remove the row")
                continue
            source.has_place = any(where)
            found.append(source)
        if not found and not self.complaints:
            raise BadInput([complaint(self.table.row_place(self.heading.number), "a heading and no point below it",
                                      "a row a point with a name and a register or object", "export the list again")])
        return found

    def name_points(self, sources):
        """Gives each row its name of ours; lists what has none or several."""
        mapped = []
        self.namer.learn_boxes([source.name for source in sources])
        for source in sources:
            ours = self.namer.roles_of(source.name, source.description)
            if ours is None:
                continue
            if not source.has_place:
                self.take_without_place(source, ours)
            elif not ours:
                self.leave_out(source, self.why_not_used(source))
            elif len(ours) > 1:
                self.complain(source, "name", f"{quoted(source.name)}, which fits {' and '.join(ours)}", "one name of ours",
                              f'say which, in [names] of a file for --map: {toml_key(source.name)} = "{ours[0]}"')
            elif split_name(ours[0]) is None:
                self.complain(source, "name", f"{quoted(ours[0])} as our name of {quoted(source.name)}",
                              "a name of docs/formats.md, such as room_temp_1 or supply_temp", "correct the mapping")
            else:
                source.ours = ours[0]
                mapped.append(source)
        for words, name in self.namer.exact.items():
            if words not in self.namer.used:
                self.complaints.append(complaint(f"{self.mapping.file}: [names]", f"{quoted(words)} = {quoted(name)}",
                                                 "the name of a point in the list", "correct the name, or remove the line"))
        return mapped

    def take_without_place(self, source, ours):
        """A row with a name of ours is never dropped; one with more than a name is listed; others are titles."""
        if ours:
            key = next((k for k in ("address", "instance", "object") if k in self.heading.places), "address")
            self.complain(source, key,
                          f"an empty cell for {quoted(source.name)}, which is taken for {' and '.join(ours)}",
                          "its register or object", "fill it in, or leave the point out, in [names] of a file for "
                          f'--map: {toml_key(source.name)} = ""')
        elif any(cell for cell in source.cells if cell not in (source.name, source.description)):
            self.leave_out(source, "not used: it has no register and no object")

    def leave_out(self, source, why):
        self.result.left_out.append((self.table.row_place(source.number), source.name, why))

    def why_not_used(self, source):
        building = self.namer.of_the_building(source.name, source.description)
        said = f', read as "{self.namer.reading(source.name)}"'
        if building:
            said += (f": it carries the number of a box ({self.namer.box_of(source.name)}), and {building[0]} has no "
                     "such number")
        return (f"not used{said}; if it is one of ours, add to [names] of a file for --map: {toml_key(source.name)} = "
                '"...", or a pattern to [roles]')

    def renumber(self, mapped):
        """VAV-301, VAV-302 become places 1, 2, alike for all kinds of one count."""
        for counted, title in (("vavs", "VAV box"), ("fcus", "fan coil unit"), ("powers", "power meter")):
            rows = [s for s in mapped if ROLES[split_name(s.ours)[0]].counted == counted]
            numbers = sorted({split_name(s.ours)[1] for s in rows})
            if numbers == list(range(1, len(numbers) + 1)) or self.mapping.list.get("numbers") == "as-written":
                continue
            place = {number: i + 1 for i, number in enumerate(numbers)}
            for s in rows:
                stem, number, sensor = split_name(s.ours)
                s.ours = f"{stem}_{place[number]}{sensor}"
            self.result.notes.append(f"{title} " + ", ".join(f"{n} is place {place[n]}" for n in numbers))

    def refuse_twice(self, mapped):
        first = {}
        for source in mapped:
            other = first.setdefault(source.ours, source)
            if other is not source:
                self.complain(source, "name", f"{quoted(source.name)} as {source.ours}, as {quoted(other.name)} in row "
                              f"{other.number} is already", "one point for each name of ours",
                              f'leave one out, in [names] of a file for --map: {toml_key(source.name)} = ""')

    # ---- Registers

    def is_bacnet(self, source):
        return bool(self.cell(source, "object") or (self.cell(source, "object_type") and self.cell(source, "instance")))

    def choose_protocol(self, mapped):
        """The protocol of all rows, or that of --protocol."""
        bacnet = [s for s in mapped if self.is_bacnet(s)]
        modbus = [s for s in mapped if self.cell(s, "address") and not self.is_bacnet(s)]
        wanted = self.options.protocol
        if wanted is None:
            if bacnet and modbus:
                self.complain(modbus[0], "address", f"a register in a list with BACnet objects (row {bacnet[0].number})",
                              "one protocol for all points", "give --protocol modbus or --protocol bacnet")
            elif bacnet and all(self.cell(s, "address") for s in bacnet) and "address" in self.heading.places:
                self.complain(bacnet[0], "address", "a register and a BACnet object in each row", "the protocol to use",
                              "give --protocol modbus or --protocol bacnet")
            wanted = "bacnet" if bacnet else "modbus"
        self.result.protocol = wanted
        used = [s for s in mapped if (self.is_bacnet(s) if wanted == "bacnet" else self.cell(s, "address"))]
        for source in (s for s in mapped if s not in used):
            if source in bacnet or source in modbus:
                self.leave_out(source, f"not used: --protocol {wanted}, and it has none of that")
            else:
                self.complain(source, "object_type", "an empty cell" if "object_type" in self.heading.places else
                              "no column of the object type", f"the type of the object of {source.ours}", "fill it in")
        return used

    def find_style(self, sources):
        self.style = self.options.addresses or self.mapping.list.get("addresses", "")
        if self.style:
            return
        addresses = []
        for source in sources:
            try:
                addresses.append(parse_address(self.address_text(source)))
            except Wrong:
                pass  # said where the row is used
        place = self.heading.places["address"]
        try:
            self.style = style_of(addresses, self.heading.cells[place])
        except Wrong as wrong:
            where = self.table.place(self.heading.number, place, self.heading.cells[place])
            raise BadInput([complaint(where, wrong.found, wrong.expected, wrong.remedy)]) from None
        self.result.notes.append({"modicon": "registers are Modicon numbers (40001 is holding register 0)",
                                  "zero-based": "registers count from 0", "one-based": "registers count from 1"}[self.style])

    def modbus_row(self, source):
        """Cells of points.csv; None after a complaint."""
        stem = split_name(source.ours)[0]
        role = ROLES[stem]
        before = len(self.complaints)
        text = self.cell(source, "function")
        function = (self.checked(source, "function", parse_function, text, self.mapping) if text else
                    self.mapping.list.get("function"))
        address = self.checked(source, "address", parse_address, self.address_text(source))
        place = address and self.checked(source, "address", protocol_address, address, self.style, function)
        if len(self.complaints) > before or not place:
            return None
        kind = self.type_of(source, place[0], address)
        scaled = self.scaling(source, role, kind)
        if kind is None or scaled is None:
            return None
        order = self.order_of(source, kind)
        write = self.write_cells(source, stem, place[0], kind)
        limits = self.limits(source, role, kind, *scaled)
        if len(self.complaints) > before:
            return None
        is_bit = kind in ("coil", "discrete")
        return {"name": source.ours, "unit": role.unit, "fc": place[0], "addr": place[1], "type": kind,
                "byte_order": "" if is_bit else order[0], "word_order": "" if is_bit else order[1],
                "scale": "" if is_bit else number(scaled[0]), "offset": "" if is_bit else number(scaled[1]),
                "min": number(limits[0]), "max": number(limits[1]), "max_rate": role.rate, "stale_s": role.stale,
                "sentinel": SENTINEL.get(kind, "") if "heartbeat" not in stem else "", **write}

    def type_of(self, source, function, address):
        if function in (1, 2):
            return "coil" if function == 1 else "discrete"
        text = self.cell(source, "type")
        kind = self.mapping.word("types", text) if text else self.mapping.list.get("type")
        if kind is None or kind == "bit":
            found = quoted(text) + (", a bit, for a register" if kind else "")
            self.complain(source, "type", found if text else "no data type", "one of " +
                          ", ".join(HELD) + (" (or words for them: " + self.mapping.accepted("types") + ")" if text and not kind else ""),
                          "correct the cell, or add the word to [types] of a file for --map" if text else
                          'add a column Data type, or type = "int16" in [list] of a file for --map')
            return None
        if address.last is not None and (address.last > address.number) != (kind in WIDE):
            self.complain(source, "type", f"{kind} in the registers {address.number} to {address.last}",
                          "two registers for a 32-bit type, one for a 16-bit type", "correct register or type")
            return None
        return kind

    def order_of(self, source, kind):
        text = self.cell(source, "order")
        key = self.mapping.word("orders", text) if text else self.mapping.list.get("order", "ABCD")
        if kind in WIDE and not text and "order" not in self.mapping.list:
            self.unordered.append(source.ours)
        if key is None:
            self.complain(source, "order", quoted(text), "one of " + self.mapping.accepted("orders"),
                          "write ABCD, CDAB, BADC or DCBA, or add the word to [orders] of a file for --map")
            return ("big", "big")
        order = ORDERS[key]
        return order if kind in WIDE else (order[0], "big")

    def scaling(self, source, role, kind):
        """(scale, constant) that make our unit of the raw number."""
        text = self.cell(source, "scale")
        is_given = bool(text) or "scale" in self.mapping.list
        scale = (self.checked(source, "scale", parse_scale, text, self.table.decimal) if text else
                 float(self.mapping.list.get("scale", 1)))
        text = self.cell(source, "offset")
        constant = self.checked(source, "offset", parse_number, text, self.table.decimal) if text else 0.0
        unit_text = self.cell(source, "unit")
        unit = self.mapping.word("units", unit_text)
        if unit is None:
            self.complain(source, "unit", quoted(unit_text), f"a unit of {source.ours}: {self.units_for(role)}",
                          "correct the cell, or add it to [units] of a file for --map")
            return None
        if unit == "none" and role.unit:
            unit = {"degc": "degc", "kw": "kw", "m3/s": "m3s"}[role.unit]
            self.result.notes.append(f"{source.ours}: no unit in the list, taken as {role.unit}")
        ours, factor, shift = CONVERSIONS[unit]
        if ours != role.unit or (unit == "percent" and role.is_state):
            self.complain(source, "unit", quoted(unit_text), f"a unit of {source.ours}: {self.units_for(role)}",
                          "correct the cell, or the mapping of the point")
            return None
        if not is_given and not role.is_state and kind in INTEGERS:
            self.unscaled.append((source, kind))
            return None
        if scale is None or constant is None:
            return None
        scale, constant = scale * factor, constant * factor + shift
        if role.is_state and (scale != 1 or constant != 0):
            self.complain(source, "scale", f"{scale:g} and {constant:g} for a state", "1 and 0", "clear scale and offset")
            return None
        if role.step and kind != "float32" and abs(scale) > role.step:
            self.complain(source, "scale", f"{quoted(self.cell(source, 'scale'))}, a step of {scale:.4g} {role.unit or 'of a whole'}",
                          f"a factor that makes the value of the raw number, with a step of at most {role.step:g}",
                          "where the register holds ten times the value write 0.1 or /10" + ("" if role.unit else "; or % as its unit"))
            return None
        return scale, constant

    @staticmethod
    def units_for(role):
        return ", ".join(name for name, (ours, _, _) in CONVERSIONS.items()
                         if ours == role.unit and not (role.is_state and name == "percent")) + (" or an empty cell" if role.unit else "")

    def limits(self, source, role, kind, scale, constant):
        """The role's limits, as far as the register reaches."""
        if kind in ("coil", "discrete"):
            return role.least, role.most
        ends = sorted(raw * scale + constant for raw in HELD[kind])
        least, most = max(role.least, ends[0]), min(role.most, ends[1])
        if least >= most:
            self.complain(source, "scale", f"{kind} with scale {scale:g}, which holds {ends[0]:g} to {ends[1]:g} {role.unit}",
                          f"values of {role.least:g} to {role.most:g}", "correct scale, unit or type")
        elif (least, most) != (role.least, role.most):
            least, most = inside(least, 1), inside(most, -1)
            self.result.notes.append(f"{source.ours}: {kind} with scale {scale:g} holds {least:g} to {most:g} {role.unit} only")
        return least, most

    def write_cells(self, source, stem, function, kind):
        empty = {"write_policy": "", "fc_write": "", "default": "", "readback": ""}
        if stem not in WRITTEN:
            return empty
        access = self.cell(source, "access")
        if access and self.mapping.word("access", access) is None:
            self.complain(source, "access", quoted(access), "one of " + self.mapping.accepted("access"), "write RW or R")
            return empty
        if function not in (1, 3) or (access and self.mapping.word("access", access) == "read"):
            self.complain(source, "access" if access else "function", f"{source.ours}, which can only be read",
                          "a register that can be written (holding, RW)", "ask for the register that is written")
            return empty
        policy = "on-change" if stem == "setpoint" else "refresh"
        return {"write_policy": policy, "fc_write": 5 if function == 1 else 16 if kind in WIDE else 6, "default": "",
                "readback": "self"}

    # ---- Objects

    def bacnet_row(self, source):
        stem = split_name(source.ours)[0]
        role = ROLES[stem]
        kind, instance, device = self.object_of(source)
        scaled = self.scaling(source, role, "float32")
        if kind is None or scaled is None:
            return None
        if stem in WRITTEN and kind not in COMMANDABLE and not (stem == "heartbeat" and kind.startswith(("binary", "multi"))
                                                                 and not kind.endswith("input")):
            self.complain(source, "object_type", f"{kind} for {source.ours}", "an object that can be commanded: " +
                          ", ".join(COMMANDABLE), "name the object that holds the setpoint")
            return None
        return {"name": source.ours, "unit": role.unit, "protocol": "bacnet", "object": f"{device}:{kind}:{instance}",
                "scale": number(scaled[0]), "offset": number(scaled[1]), "min": number(role.least), "max": number(role.most),
                "max_rate": role.rate, "stale_s": role.stale}

    def object_of(self, source):
        """(type, instance, device); type None after a complaint."""
        none = (None, None, None)
        device, kind_text, instance = self.cell(source, "device"), self.cell(source, "object_type"), self.cell(source, "instance")
        key = "object_type"
        if self.cell(source, "object"):
            key = "object"
            found = re.fullmatch(r"(?:(\d+)[:./ ])?\s*([A-Za-z][A-Za-z \-_]*?)[\s:,.\-_]*(\d+)", self.cell(source, "object"))
            if not found:
                self.complain(source, key, quoted(self.cell(source, "object")), "an object such as AI:3 or 1201:analog-input:3",
                              "correct the cell, or give columns Object type and Instance")
                return none
            device, kind_text, instance = found[1] or device, found[2], found[3]
        kind = self.mapping.word("object_types", kind_text)
        if kind is None:
            self.complain(source, key, quoted(kind_text), "one of " + self.mapping.accepted("object_types"),
                          "correct the cell, or add the word to [object_types] of a file for --map")
            return none
        device = str(device or self.options.device or self.mapping.list.get("device", ""))
        for what, text, remedy in (("instance", instance, "correct the cell"),
                                   ("device", device, "give --device, such as --device 1201, or a column Device instance")):
            if not text.isdecimal() or int(text) > HIGHEST_INSTANCE:
                self.complain(source, what if what in self.heading.places else key, f"{quoted(text)} as the {what}'s number",
                              f"0 to {HIGHEST_INSTANCE}", remedy)
                return none
        return kind, int(instance), int(device)

    # ---- The whole

    def run(self):
        """Errors: BadInput with every complaint."""
        sources = self.sources()
        mapped = self.name_points(sources)
        self.renumber(mapped)
        self.refuse_twice(mapped)
        used = self.choose_protocol(mapped)
        if self.result.protocol == "modbus" and used:
            self.find_style([s for s in sources if self.cell(s, "address")])
        rows = [(s, self.modbus_row(s) if self.result.protocol == "modbus" else self.bacnet_row(s)) for s in used]
        rows = [(s, row) for s, row in rows if row is not None]
        self.refuse_unscaled()
        self.note_orders()
        self.refuse_shared(rows)
        self.refuse_lacking({row["name"] for _, row in rows})
        if self.complaints:
            raise BadInput(self.complaints)
        self.result.points = {row["name"]: s.number for s, row in rows}
        self.result.text = self.text_of(rows)
        return self.result

    def refuse_unscaled(self):
        """A register of 215 may be 215 or 21.5, where neither list nor mapping says it."""
        explicit = "say scale = 1 in [list] of a file for --map where registers hold the values themselves"
        if "scale" in self.heading.places:
            for source, kind in self.unscaled:
                self.complain(source, "scale", f"an empty cell for {source.ours}, {kind}", "a factor such as 0.1",
                              f"fill it in, 1 where the register holds the value itself; or {explicit}")
        elif self.unscaled:
            columns = guessed_columns(self.table, self.heading, self.mapping)
            named = [text for text, keys in columns if "scale" in keys] or ["its heading"]
            shown = listed([f"{source.ours} ({kind})" for source, kind in self.unscaled])
            self.complaints.append(complaint(
                self.table.row_place(self.heading.number), f"no column of the scale, for {shown}",
                "the factor that makes the value of the raw number",
                f"name the column in [columns] of a file for --map: scale = [{', '.join(map(toml_key, named))}]; or "
                f"{explicit}"))

    def note_orders(self):
        if self.unordered:
            self.result.notes.append(f"{listed(self.unordered)}: no order of bytes in the list, taken as ABCD (big end "
                                     "first); airside probe shows whether another fits, order in [list] of a file for "
                                     "--map says it")

    def refuse_shared(self, rows):
        holders = {}
        for source, row in rows:
            if self.result.protocol == "bacnet":
                taken = [row["object"]]
            else:
                taken = [(row["fc"], row["addr"] + i) for i in range(2 if row["type"] in WIDE else 1)]
            for place in taken:
                other = holders.setdefault(place, source)
                if other is source:
                    continue
                text = place if self.result.protocol == "bacnet" else f"function {place[0]}, register {place[1]} counted from 0"
                self.complain(source, "object" if self.result.protocol == "bacnet" else "address",
                              f"{text}, which {quoted(other.name)} in row {other.number} has too", "each once",
                              "correct one of the two registers, or a type of 32 bits that should have 16")
                break

    def refuse_lacking(self, names):
        """What every site needs; with --site also what that site needs."""
        stems = {split_name(name)[0] for name in names}
        rooms = {split_name(n)[1] for n in names if n.startswith("room_temp")}
        self.result.counts = counts = {
            "vavs": max(rooms, default=0), "powers": sum(n.startswith("power_") for n in names),
            "fcus": max((split_name(n)[1] for n in names if n.startswith("fcu_")), default=0)}
        if self.complaints:
            return  # a row that is refused is not missing
        for stem, example in (("room_temp", "room_temp_1"), ("setpoint", "setpoint")):
            if stem not in stems:
                self.complaints.append(complaint(
                    self.table.path, f"no point that is taken for {example}", "room temperatures and the setpoint of the supply "
                    "air at least", self.ways_to_name(stem, example)))
        site = self.options.site_facts
        if not site:
            return
        kinds = [("room_temp", site.counts["vavs"]), ("vav_on", site.counts["vavs"]), ("fcu_temp", site.counts["fcus"]),
                 ("fcu_on", site.counts["fcus"]), ("power", site.counts["powers"]), ("mau_temp", 0), ("outdoor_temp", 0),
                 ("rain", 0)]
        for stem, count in kinds:
            wanted = [f"{stem}_{i}" for i in range(1, count + 1)] if ROLES[stem].counted else [stem]
            have = {re.sub(r"[a-h]$", "", n) if n.startswith("room_temp") else n for n in names}
            stand_ins = [n for n in wanted if n in site.stand_ins or stem in site.stand_ins]
            lacking = [n for n in wanted if n not in have and n not in stand_ins]
            if stem == "room_temp" and not rooms:
                continue  # said above; the topology may well be right
            both = [n for n in wanted if n in have and n in stand_ins]
            if lacking:
                named = "name the points in [names] or by a pattern in [roles] of a file for --map"
                remedy = (f"{named}, or, where the AHU has only {len(rooms)}, correct topology in the site file"
                          if stem == "room_temp" else
                          f"add `{stem} = {STAND_INS[stem]}` or the like to [stand_in] of the site file, or {named}")
                self.complaints.append(complaint(self.table.path, "no " + ", ".join(lacking), f"what {site.path} needs",
                                                 remedy + self.unused()))
            if both:
                self.complaints.append(complaint(site.path, f"a stand-in for {', '.join(both)}, which the list has",
                                                 "a row or a stand-in", "remove the line from [stand_in]"))
        for name in sorted(names):
            stem, place, _ = split_name(name)
            if ROLES[stem].counted and place > site.counts[ROLES[stem].counted]:
                self.complaints.append(complaint(f"{self.table.path}: {name}", f"place {place}", f"at most "
                                                 f"{site.counts[ROLES[stem].counted]} in {site.path}",
                                                 "correct topology in the site file, or leave the point out in [names]"))

    def unused(self):
        """The first names that were not used, once: one of them may be what is missing."""
        if self.unused_is_said or not self.result.left_out:
            return ""
        self.unused_is_said = True
        return "; not used: " + listed([f'{name} (read as "{self.namer.reading(name)}")'
                                        for _, name, _ in self.result.left_out])

    def ways_to_name(self, stem, example):
        pattern = self.namer.pattern_like(stem, [name for _, name, _ in self.result.left_out])
        return (f'name it in [names] of a file for --map: "the vendor\'s name" = "{example}"; or all of a kind by a '
                f"pattern in [roles] there{', such as ' + pattern if pattern else ''}; none of these fits: " +
                ", ".join(map(toml_key, self.namer.patterns_for(stem))) + self.unused())

    def text_of(self, rows):
        is_bacnet = self.result.protocol == "bacnet"
        columns = BACNET_COLUMNS if is_bacnet else COLUMNS
        order = {stem: i for i, stem in enumerate(ROLES)}
        rows = sorted(rows, key=lambda pair: (order[split_name(pair[1]["name"])[0]], split_name(pair[1]["name"])[1:]))
        lines = [f"# From {self.table.path.rsplit('/', 1)[-1]}" + (f", sheet {self.table.sheet}" if self.table.sheet else "") +
                 " by tools/points/import_points. physical = raw * scale + offset" +
                 ("." if is_bacnet else "; addr counts from 0."), ",".join(columns)]
        for source, row in rows:
            lines.append(f"# {row['name']}: row {source.number}, {source.name}")
            lines.append(",".join(csv_cell(row[column]) for column in columns))
        if is_bacnet:
            held = [] if any(row["name"] == "heartbeat" for _, row in rows) else [("heartbeat", 65535)]
            for name, most in [*held, ("map_fingerprint", 4294967295)]:
                cells = {"name": name, "protocol": "bacnet", "object": "gateway", "min": 0, "max": most}
                lines.append(",".join(csv_cell(cells.get(column, "")) for column in columns))
        return "\n".join(lines) + "\n"


def listed(texts):
    """The first of them, and how many more."""
    return ", ".join(texts[:8]) + (f" and {len(texts) - 8} more" if len(texts) > 8 else "")


def inside(value, direction):
    """The next float32-safe number towards the middle, with few digits."""
    rounded = float(f"{value:.6g}")
    if (rounded - value) * direction < 0:
        rounded += direction * abs(value) * 1e-5
    return float(f"{rounded:.7g}")


def number(value):
    return f"{value:.10g}"


def csv_cell(value):
    text = str(value)
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"') else text


def toml_key(name):
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
