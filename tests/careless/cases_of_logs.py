"""Logs, weather and models, as spreadsheets, browsers and copies leave them."""

from desk import Case, cell, nothing, recode, rows, write, zipped

FIT = "airside transfer --log log.csv -o x.blob"
DRAW = "airside report log.csv -o rep"
WEATHER = "airside pretrain --plant rc --weather log.epw --days 2 --updates 1 -o x.blob"
MODEL = "airside check --twin m.epJSON"
PAGE = "<!DOCTYPE html>\n<html><head><title>Sign in</title></head></html>\n"
POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32\nsize 1234\n"


def german(text):
    return text.replace(",", ";").replace(".", ",")


def american(number, cells):
    if number == 1:
        return cells
    date, clock = cells[0].split("T")
    year, month, day = date.split("-")
    return [f"{int(month)}/{int(day)}/{year} {clock[:5]}", *cells[1:]]


def serial(number, cells):
    return cells if number == 1 else [f"{44378 + (number - 2) * 6 / 1440:.5f}", *cells[1:]]


def zone(number, cells):
    return cells if number == 1 else [cells[0] + "+08:00", *cells[1:]]


def fahrenheit(number, cells):
    return cells if number == 1 else [cells[0], *(f"{float(c) * 1.8 + 32:.1f}" for c in cells[1:6]), *cells[6:]]


LOGS = [
    Case("SavedWithMarkAndCarriageReturns", recode("log.csv", lambda t: b"\xef\xbb\xbf" + t.replace("\n", "\r\n").encode()),
         DRAW, leaves=("rep",)),
    Case("LastLineWithoutItsEnd", recode("log.csv", lambda t: t[:-1]), DRAW, leaves=("rep",)),
    Case("Semicolons", recode("log.csv", lambda t: t.replace(",", ";")), FIT,
         ("log.csv:1", "separated by `;`", "`,`", "export with comma")),
    Case("SemicolonsAndDecimalCommas", recode("log.csv", german), FIT,
         ("log.csv:1", "separated by `;`", "`,`", "point as decimal mark")),
    Case("DecimalCommaInACell", cell("log.csv", 3, 1, "25,31"), FIT,
         ("log.csv:3", "46 fields", "45", "decimal commas")),
    Case("Tabs", recode("log.csv", lambda t: t.replace(",", "\t")), FIT,
         ("log.csv:1", "separated by tabs", "`,`", "export with comma")),
    Case("UnicodeTextOfASpreadsheet", recode("log.csv", lambda t: t.replace(",", "\t").encode("utf-16")), FIT,
         ("log.csv:1", "UTF-16", "UTF-8", "CSV UTF-8")),
    Case("WorkbookRenamed", write("log.csv", b"PK\x03\x04\x14\x00\x06\x00\x08\x00" + bytes(64)), FIT,
         ("log.csv:1", "a workbook", "a CSV log", "export the sheet")),
    Case("Zipped", zipped("log.csv"), FIT, ("log.csv:1", "gzip", "a CSV log", "unpack")),
    Case("SignInPageInsteadOfTheFile", write("log.csv", PAGE), FIT,
         ("log.csv:1", "a web page", "a CSV log", "download the file itself")),
    Case("AmericanDates", rows("log.csv", american), FIT,
         ("log.csv:2: time", "8/1/2021", "2021-07-01T00:06:00", "ISO dates")),
    Case("DatesAsNumbers", rows("log.csv", serial), FIT,
         ("log.csv:2: time", "44378", "2021-07-01T00:06:00", "ISO dates")),
    Case("TimesWithAZone", rows("log.csv", zone), FIT,
         ("log.csv:2: time", "+08:00", "2021-07-01T00:06:00", "without a zone")),
    Case("Fahrenheit", rows("log.csv", fahrenheit), FIT,
         ("log.csv:2: room_temp_1_degc", "76.9", "0 to 50 degc", "Fahrenheit")),
    Case("SecondLineOfUnits", recode("log.csv", lambda t: t.replace("\n", "\n-" + ",degC" * t.split("\n")[0].count(",") + "\n", 1)), FIT,
         ("log.csv:2: time", "`-`", "2021-07-01T00:06:00", "ISO dates")),
    Case("UnitInACell", cell("log.csv", 4, 1, "25.3 °C"), FIT,
         ("log.csv:4: room_temp_1_degc", "25.3 °C", "a number such as 25.3", "correct the field")),
    Case("NewestFirst", recode("log.csv", lambda t: "\n".join([t.split("\n")[0], *t.split("\n")[-2:0:-1]]) + "\n"), FIT,
         ("log.csv:3: time", "earlier than", "grow", "sort the rows")),
    Case("DownloadCutInALine", recode("log.csv", lambda t: "\n".join(t.split("\n")[:242])[:-40]), DRAW,
         ("log.csv:242", "fields", "45", "cut off")),
    Case("NotUtf8", recode("log.csv", lambda t: t.replace("outdoor_temp_degc", "outdoor_°C").encode("latin-1")), FIT,
         ("log.csv:1: outdoor_temp_degc", "no such column", "outdoor_temp_degc", "rename the column")),
    Case("EmptyFolder", lambda f: (f / "logs").mkdir(), "airside report logs -o rep",
         ("logs", "without *.csv", "log files", "the directory")),
    Case("TitleAboveTheHeader", recode("log.csv", lambda t: "Trend export AHU 3\n\n" + t), FIT,
         ("log.csv:1", "Trend export", "starts with `time`", "lines above the header")),
    Case("RowsOfCommasAtTheEnd", recode("log.csv", lambda t: t + "," * t.split("\n")[0].count(",") + "\n"), FIT,
         ("log.csv:482: time", "nothing", "2021-07-01T00:06:00", "rows without a time")),
    Case("WithoutReadRight", lambda f: (f / "log.csv").chmod(0), FIT,
         ("log.csv", "no file that can be read", "a CSV log", "permissions")),
]

WEATHER_AND_MODELS = [
    Case("WeatherWithCarriageReturns", recode("log.epw", lambda t: t.replace("\n", "\r\n").encode()), WEATHER,
         leaves=("x.blob",)),
    Case("WeatherIsAPointer", write("log.epw", POINTER), WEATHER, ("log.epw:1", "Git LFS", "EPW", "git lfs pull")),
    Case("WeatherIsADesignDay", write("log.epw", "! The following Location and design day data\nSite:Location,\n"), WEATHER,
         ("log.epw:1: LOCATION", "! The following", "LOCATION,city", "EPW file")),
    Case("WeatherIsZipped", zipped("log.epw"), WEATHER, ("log.epw:1", "gzip", "EPW", "unpack")),
    Case("WeatherIsALog", nothing, WEATHER.replace("log.epw", "log.csv"),
         ("log.csv:1: LOCATION", "time,room_temp_1", "LOCATION,city", "EPW file")),
    Case("WeatherWithDecimalCommas", recode("log.epw", german), WEATHER,
         ("log.epw:1: LOCATION", "separated by `;`", "`,`", "fetch the file again")),
    Case("ModelIsAPointer", write("m.epJSON", POINTER), MODEL, ("m.epJSON:1", "Git LFS", "JSON", "git lfs pull")),
    Case("ModelIsAnIdfRenamed", write("m.epJSON", "! a comment\nVersion,25.2;\n"), MODEL,
         ("m.epJSON", "an IDF", "epJSON", "--convert-only")),
    Case("ModelCutShort", recode("m.epJSON", lambda t: t[:len(t) // 2]), MODEL,
         ("m.epJSON:", "not JSON", "JSON object", "it ends early")),
    Case("ModelWithACommaTooMany", recode("m.epJSON", lambda t: t.rstrip().rstrip("}").rstrip() + ",\n}\n"), MODEL,
         ("m.epJSON:", "unexpected", "JSON object", "correct the syntax")),
    Case("MapNamesNoColumn", write("map.toml", "[signals]\nroom_temp_1 = \"Zone 1 Temp\"\n"),
         "airside gap --map map.toml --measured log.csv --no-reference -o g",
         ("map.toml: model.file", "nothing", "a text", "add file =")),
    Case("ReferenceIsTheLogItself", nothing,
         "airside gap --plant rc --room 301 --measured log.csv --reference log.csv -o g",
         ("log.csv", "within the reference period", "before or after", "--reference-days")),
]
