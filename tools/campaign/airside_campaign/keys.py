"""Content addresses: a job's key is the digest of the program and what it uses, its arguments and every file that they
name, with the keys of the jobs that it needs in the place of their folders. The same work has the same key anywhere."""

import hashlib
import json
import re
import tomllib

from airside_campaign.complaint import BadInput
from airside_campaign.uses import digest_of, used_by

OPTION = re.compile(r"(--?[A-Za-z][\w-]*=)(.*)", re.DOTALL)  # --site=x.toml


class Inputs:
    """Files and folders that a job reads, with their digests."""

    def __init__(self, folder):
        self.folder, self.digests = folder, {}

    def add(self, path):
        """Its digest, with those of the files that it names itself where it is TOML."""
        path = self.folder / path
        digests = [self._one(path)]
        if path.suffix == ".toml" and path.is_file():
            digests += [self._one(other) for other in files_named_in(path)]
        return "+".join(digests)

    def _one(self, path):
        try:
            self.digests[str(path)] = digest_of(str(path))
        except OSError as error:
            raise BadInput(
                error.filename or path, error.strerror.lower(), "a file that can be read", "check its path and rights"
            ) from error
        return self.digests[str(path)]


def is_named(folder, word):
    """Whether an argument is a file or folder."""
    if word in ("", ".") or word.startswith("-") or len(word) >= 4096 or "\0" in word:
        return False
    try:
        return (folder / word).exists()
    except OSError:
        return False


def files_named_in(toml):
    """Files beside a TOML file, or from there on, that texts in it name, and those that they name; a site file has its
    points, its weights."""
    found, waiting = [], [toml]
    for file in waiting:  # it grows meanwhile
        for text in _texts_in(file):
            other = file.parent / text
            if is_named(file.parent, text) and other.is_file() and other not in found and other != toml:
                found.append(other)
                waiting += [other] if other.suffix == ".toml" else []
    return found


def _texts_in(file):
    try:
        waiting = [tomllib.loads(file.read_text(encoding="utf-8"))]
    except (OSError, ValueError):
        return  # the program says what is wrong with it
    for value in waiting:
        if isinstance(value, str):
            yield value
        elif isinstance(value, (dict, list)):
            waiting += value.values() if isinstance(value, dict) else value


def add_keys(campaign, program):
    """Gives each job its key, what it reads, and the folders of others as paths beside its own: they are the same on
    each machine. Returns what the program uses."""
    try:
        used = used_by(str(program))
    except OSError as error:
        raise BadInput(error.filename, error.strerror.lower(), "a file that can be read", "check its rights") from error
    folder, keys = campaign.path.resolve().parent, {}
    for job in campaign.jobs:
        inputs = Inputs(folder)
        files = [inputs.add(path) for path in job.inputs]
        words, job.command = _words_of(job, inputs, keys)
        whole = {
            "uses": used,
            "run": words,
            "inputs": files,
            "after": {place: _one_or_all(keys, names) for place, names in sorted(job.after.items())},
        }
        job.key = hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:24]
        job.reads = inputs.digests
        keys[job.name] = job.key
    return used


def _words_of(job, inputs, keys):
    """Arguments as the key has them, with the content of files, and as the program gets them."""
    words, run = [], []
    for word in job.run:
        option, value = _split(word)
        if is_named(inputs.folder, value):
            words.append(f"{option}file:{inputs.add(value)}")
            run.append(f"{option}{inputs.folder / value}")
            continue
        for places in _places_of(word, job, keys):
            words.append(_with(word, places))
            run.append(_with(word, {place: "../" + key for place, key in places.items()} | {"out": "."}))
    return words, run


def _split(word):
    match = OPTION.fullmatch(word)
    return match.groups() if match else ("", word)


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
