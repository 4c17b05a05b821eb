"""Blobs of a campaign's folder, with what its jobs say of them and the weights that they were made from."""

import hashlib
import json
import re
from pathlib import Path

from airside_campaign.complaint import BadInput

KEY = re.compile(r"(?<![0-9a-f])[0-9a-f]{24}(?![0-9a-f])")
BLOB = re.compile(r"(?:--?[\w-]+=)?(.*\.blob)")


def of_campaign(folder):
    """(file, what is known of it, digests of what it was made from) of each blob of the finished jobs."""
    jobs = {}
    for record in sorted((folder / "jobs").glob("*/job.json")):
        job = json.loads(record.read_text(encoding="utf-8"))
        jobs[job["key"]] = (job, record.parent, sorted(record.parent.glob("**/*.blob")))
    if not any(blobs for _, _, blobs in jobs.values()):
        raise BadInput(
            folder, "no finished job with a blob", "a folder that `airside campaign` left", "run the campaign"
        )
    own = {key: {blob: _digest(blob) for blob in blobs} for key, (_, _, blobs) in jobs.items()}
    given = {key: _given(job) for key, (job, _, _) in jobs.items()}
    needs = {key: [k for k in KEY.findall(" ".join(job["command"])) if k in jobs] for key, (job, _, _) in jobs.items()}
    out = []
    for key in _in_order(needs):
        job, place, blobs = jobs[key]
        made_from = _made_from(key, needs, own, given)
        out += [(blob, _facts(job, place), made_from) for blob in blobs]
    return out


def _in_order(needs):
    """Each key after those that it needs."""
    done = {}

    def visit(key):
        if key not in done:
            for other in needs[key]:
                visit(other)
            done[key] = True

    for key in needs:
        visit(key)
    return done


def _made_from(key, needs, own, given):
    """Of the jobs that it needs those with blobs, else what they were made from: a log between two trainings hides
    nothing."""
    found = list(given[key])
    for other in needs[key]:
        found += own[other].values() or _made_from(other, needs, own, given)
    return list(dict.fromkeys(found))


def _given(job):
    """Digests of the blobs that its arguments name: as its record has them, else of the files as they are now."""
    known = job.get("inputs", {})
    digests = [digest for path, digest in known.items() if path.endswith(".blob")]
    for word in () if known else job["command"]:
        match = BLOB.fullmatch(word)
        if match and Path(match[1]).is_absolute() and Path(match[1]).is_file():
            digests.append(_digest(match[1]))
    return digests


def _digest(path):
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise BadInput(path, error.strerror.lower(), "a weight blob", "check the path and its rights") from error


def _facts(job, place):
    entry = {"command": "airside " + " ".join(job["command"]), "room": _option(job["command"], "--room")}
    try:
        said = json.loads((place / "stdout").read_text(encoding="utf-8"))
        entry["figures"] = {k: v for k, v in said.items() if isinstance(v, (int, float)) and not isinstance(v, bool)}
    except (OSError, ValueError, AttributeError):
        pass
    return entry


def _option(command, name):
    return command[command.index(name) + 1] if name in command[:-1] else None
