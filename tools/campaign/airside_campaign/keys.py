"""Content addresses: a job's key is the digest of the program, its arguments and every file that they name, with the
keys of the jobs that it needs in the place of their folders. The same work has the same key anywhere."""

import hashlib
import json
import re
from pathlib import Path

from airside_campaign.complaint import BadInput


class Digests:
    """Of files and folders, each read once."""

    def __init__(self):
        self._known = {}

    def of(self, path):
        path = Path(path)
        if path not in self._known:
            self._known[path] = self._folder(path) if path.is_dir() else _file(path)
        return self._known[path]

    def _folder(self, path):
        parts = [[str(p.relative_to(path)), self.of(p)] for p in sorted(path.rglob("*")) if p.is_file()]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _file(path):
    try:
        with open(path, "rb") as content:
            return hashlib.file_digest(content, "sha256").hexdigest()
    except OSError as error:
        raise BadInput(
            path, error.strerror.lower(), "a file that can be read", "check the path and its rights"
        ) from error


def add_keys(campaign, program, digests=None):
    """Gives each job its key, and the folders of others as paths beside its own: they are the same on each machine."""
    digests = digests or Digests()
    of_program = digests.of(program)
    keys = {}
    for job in campaign.jobs:
        folder = campaign.path.resolve().parent
        files = [digests.of(folder / path) for path in job.inputs]
        words = []
        run = []
        for word in job.run:
            path = folder / word
            named = (
                not word.startswith("-")
                and len(word) < 4096
                and "\0" not in word
                and path.exists()
                and word not in ("", ".")
            )
            if named:
                words.append("file:" + digests.of(path))
                run.append(str(path))
                continue
            for places in _places_of(word, job, keys):
                words.append(_with(word, places))
                run.append(_with(word, {place: "../" + key for place, key in places.items()} | {"out": "."}))
        whole = {
            "program": of_program,
            "run": words,
            "inputs": files,
            "after": {place: _one_or_all(keys, names) for place, names in sorted(job.after.items())},
        }
        job.key = hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:24]
        job.command = run
        keys[job.name] = job.key
    return of_program


def _one_or_all(keys, names):
    return keys[names[0]] if len(names) == 1 else [keys[name] for name in names]


def _places_of(word, job, keys):
    """{place: key} for each word that this one becomes: one, or one for each job of its place that has several."""
    several = [place for place in re.findall(r"\{(\w+)\}", word) if len(job.after.get(place, ())) > 1]
    one = {place: keys[names[0]] for place, names in job.after.items()}
    if not several:
        return [one]
    return [one | {several[0]: keys[name]} for name in job.after[several[0]]]


def _with(word, places):
    return re.sub(r"\{(\w+)\}", lambda m: places.get(m[1], m[0]), word)
