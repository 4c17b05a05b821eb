"""Site files, point maps and answers."""

from desk import Case, both, edit, nothing, recode, rows, write

CHECK = "airside check site/site.toml"
SITE, POINTS = "site/site.toml", "site/points.csv"
NEW = "airside init new --answers answers.toml"

SITES = [
    Case("CarriageReturnsAndTabs", recode(SITE, lambda t: t.replace("\n", "\r\n").replace(" = ", "\t=\t").encode()), CHECK),
    Case("WithByteOrderMark", recode(SITE, lambda t: b"\xef\xbb\xbf" + t.encode()), CHECK),
    Case("DecimalComma", edit(SITE, "= 25.25", "= 25,25"), CHECK,
         ("site.toml:10:", "not TOML", "key = value", "decimal mark as a point")),
    Case("CurlyQuotes", edit(SITE, '"07:00"', "“07:00”"), CHECK,
         ("site.toml:12:", "not TOML", "key = value", "straight double quotes")),
    Case("WithoutQuotes", edit(SITE, '"5vav-5fcu-2power"', "5vav-5fcu-2power"), CHECK,
         ("site.toml:6:", "not TOML", "key = value", "double quotes")),
    Case("NumberInQuotes", edit(SITE, "port = 502", 'port = "502"'), CHECK,
         ("modbus.port", "the text \"502\"", "1 to 65535", "without quotes")),
    Case("SectionTwice", recode(SITE, lambda t: t + "\n[target]\nroom_temp_degc = 24\n"), CHECK,
         ("site.toml:", "target", "key = value", "twice")),
    Case("KeyTwice", edit(SITE, "port = 502", "port = 502\nport = 1502"), CHECK,
         ("site.toml:41:", "port", "key = value", "twice")),
    Case("KeyInTheWrongSection", edit(SITE, "[target]", "[target]\nmin_degc = 20.0"), CHECK,
         ("target.min_degc", "unknown key", "room_temp_degc", "move it below [setpoint]")),
    Case("KeyWithCapital", edit(SITE, "port = 502", "Port = 502"), CHECK,
         ("modbus.Port", "unknown key", "port", "did you mean `port`")),
    Case("Notepad", recode(SITE, lambda t: t.encode("utf-16")), CHECK, ("site.toml:1", "UTF-16", "TOML", "UTF-8")),
    Case("NotUtf8", recode(SITE, lambda t: t.replace("degC", "°C", 1).encode("latin-1")), CHECK,
         ("site.toml:10:", "utf-8", "key = value", "save the file as UTF-8")),
    Case("AddressOfABrowser", edit(SITE, '"127.0.0.1"', '"http://192.168.1.5/"'), CHECK,
         ("modbus.host", "http://", "192.168.1.20", "leave scheme")),
    Case("AddressWithPort", edit(SITE, '"127.0.0.1"', '"192.168.1.5:502"'), CHECK,
         ("modbus.host", "192.168.1.5:502", "192.168.1.20", "the port goes to port")),
    Case("WindowsPath", edit(SITE, '"points.csv"', '"C:\\points\\ahu.csv"'), CHECK,
         ("site.toml:47:", "escape", "key = value", "with / instead")),
    Case("LimitsExchanged", both(edit(SITE, "min_degc = 20.0", "min_degc = 26.0"), edit(SITE, "max_degc = 26.0", "max_degc = 20.0")),
         CHECK, ("setpoint.max_degc", "20", "min_degc below max_degc", "exchange")),
    Case("HourWithoutMinutes", edit(SITE, '"07:00"', '"7"'), CHECK,
         ("target.work_start", "\"7\"", "00:00 to 24:00", "07:00")),
    Case("HourOfAnAmerican", edit(SITE, '"19:00"', '"7:00 pm"'), CHECK,
         ("target.work_end", "7:00 pm", "00:00 to 24:00", "hours and minutes")),
    Case("MergeConflict", edit(SITE, "[target]", "<<<<<<< HEAD\n[target]"), CHECK,
         ("site.toml:9:", "<", "key = value", "settle the merge")),
    Case("YesForTrue", edit(SITE, "weekday_only = false", "weekday_only = yes"), CHECK,
         ("site.toml:14:", "not TOML", "key = value", "true or false")),
    Case("PointMapGiven", nothing, "airside check site/points.csv",
         ("points.csv:5:", "not TOML", "key = value", "site's .toml file")),
    Case("BlobGiven", nothing, "airside check a.blob", ("a.blob:1", "not text", "a site file", "site's .toml file")),
    Case("PointMapOfAnotherSite", lambda f: (f / POINTS).write_bytes((f / "small/points.csv").read_bytes()), CHECK,
         ("points.csv", "room_temp_4", "a row", "add the row")),
    Case("FolderForTheLogIsAFile", write("site/log", "x"), "airside doctor site/site.toml",
         ("site/log", "is no folder", "MISSING", "mv site/log"), free=True),
]


def column(name, line, to):
    def change(number, cells):
        header = change.header = cells if cells[0] == "name" else change.header
        if cells[0] == line:
            cells[header.index(name)] = to
        return cells
    change.header = []
    return rows(POINTS, change)


POINT_MAPS = [
    Case("Semicolons", recode(POINTS, lambda t: t.replace(",", ";")), CHECK,
         ("points.csv:5, header", "separated by `;`", "`,`", "export with comma")),
    Case("DecimalCommaShiftsTheRow", column("scale", "room_temp_1", "0,01"), CHECK,
         ("points.csv:6", "19 cells", "18", "decimal marks as points")),
    Case("SignalTwice", edit(POINTS, "room_temp_2,", "room_temp_1,"), CHECK,
         ("points.csv:7, column name", "room_temp_1", "once", "rename")),
    Case("RegisterTwice", column("addr", "room_temp_2", "0"), CHECK,
         ("points.csv:7, column addr", "overlaps room_temp_1", "one point", "correct one")),
    Case("AddressInHex", column("addr", "room_temp_2", "0x40"), CHECK),
    Case("FunctionCodeAsWord", column("fc", "room_temp_2", "holding"), CHECK,
         ("points.csv:7, column fc", "holding", "1, 2, 3, 4", "use one of")),
    Case("ScaleZero", column("scale", "room_temp_1", "0"), CHECK,
         ("points.csv:6, column scale", "\"0\"", "other than 0", "leave it empty")),
    Case("LimitsExchanged", both(column("min", "room_temp_1", "45"), column("max", "room_temp_1", "5")), CHECK,
         ("points.csv:6, column min", "45 with max 5", "not above max", "swap")),
    Case("NumbersFromOne", column("name", "room_temp_1", "room_temp_0"), CHECK,
         ("points.csv", "room_temp_0", "from 1", "number all rows")),
    Case("Workbook", write(POINTS, b"PK\x03\x04\x14\x00\x06\x00\x08\x00" + bytes(64)), CHECK,
         ("points.csv:1", "a workbook", "a point map in CSV", "export the sheet")),
    Case("SetpointReadOnly", column("write_policy", "setpoint", ""), CHECK,
         ("write_policy", "an empty cell", "writable", "fill or clear both")),
]

ANSWERS = [
    Case("CountAsAWord", edit("answers.toml", "vavs = 3", 'vavs = "three"'), NEW,
         ("site.vavs", "\"three\"", "1 to 32", "without quotes")),
    Case("TableMissing", edit("answers.toml", "[site]\n", ""), NEW,
         ("answers.toml:3:1: fcus", "unknown key", "site, room, bus", "move it below [site]")),
    Case("SiteFileGiven", lambda f: (f / "answers.toml").write_bytes((f / SITE).read_bytes()), NEW,
         ("site.scope", "unknown key", "name, vavs", "looks like a site file")),
    Case("FileWhereTheFolderGoes", write("new", "x"), NEW, ("new", "Not a directory", "a folder", "choose another")),
]
