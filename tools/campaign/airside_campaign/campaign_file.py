"""campaign.toml: what is to be run, with every value that its jobs go over. Format: docs/campaigns.md."""

import difflib
import fnmatch
import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.toml_file import read_toml

PLACE = re.compile(r"\{([A-Za-z_]\w*)\}")
OWN_PLACES = ("out", "dir")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
CAMPAIGN_KEYS = {"out", "timeout_min", "retries", "cpus"}
JOB_KEYS = {"name", "run", "over", "after", "inputs", "figures", "cpus", "timeout_min"}
MOST_JOBS = 1_000_000


@dataclass
class Job:
    """One run of the program. `run` holds {out} and the places of `after` still; all other places are filled in."""

    entry: int
    name: str
    run: list
    values: dict
    after: dict = field(default_factory=dict)  # place -> names of the jobs whose folders it is; several by a pattern
    inputs: list = field(default_factory=list)  # files that no argument names
    cpus: float = 1
    timeout_min: float = 60
    reads: dict = field(default_factory=dict)  # path -> digest, of all files that are known to be read


@dataclass
class Campaign:
    path: Path
    out: Path
    retries: int
    jobs: list  # of Job, each after those that it needs
    figures: dict  # entry -> names of the figures that the report shows; empty: the first ones


def read_campaign(path):
    """All jobs of the file. Raises BadInput with the file, the entry and the key."""
    path = Path(path)
    content = read_toml(path, "a campaign file", "airside campaign --example prints one")
    return _Reader(path, content).campaign()


class _Reader:
    def __init__(self, path, content):
        self.path, self.content = path, content
        self.folder = path.resolve().parent

    def refuse(self, key, found, expected, remedy):
        raise BadInput(f"{self.path}: {key}", found, expected, remedy)

    def only(self, table, known, where):
        for key in table:
            if key in known:
                continue
            near = difflib.get_close_matches(key, known, 1)
            self.refuse(
                f"{where}{key}",
                "an unknown key",
                "one of " + ", ".join(sorted(known)),
                f"write {near[0]}" if near else "remove it",
            )

    def number(self, table, key, where, default, low, high, whole=False):
        value = table.get(key, default)
        right = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool)
        if not right or not low <= value <= high:
            kind = "a whole number" if whole else "a number"
            self.refuse(
                f"{where}{key}",
                repr(value),
                f"{kind} from {low} to {high}",
                f"correct it, or leave it out for {default}",
            )
        return value

    def campaign(self):
        self.only(self.content, {"campaign", "job"}, "")
        head = self.content.get("campaign", {})
        if not isinstance(head, dict):
            self.refuse("campaign", repr(head), "a table [campaign]", "write [campaign]")
        self.only(head, CAMPAIGN_KEYS, "campaign.")
        for key, default, low, high in (("cpus", 1, 0.1, 64), ("timeout_min", 60, 0.01, 100_000)):
            self.number(head, key, "campaign.", default, low, high)
        entries = self.content.get("job", [])
        if not isinstance(entries, list) or not entries:
            self.refuse("job", "none", "at least one [[job]] with run = [...]", "add one")
        out = head.get("out", self.path.stem + "-runs")
        if not isinstance(out, str) or not out:
            self.refuse("campaign.out", repr(out), "a folder's name", "correct it")
        jobs, figures = [], {}
        for i, entry in enumerate(entries):
            jobs += self.entry(i, entry, head)
            figures[i] = self.texts(entry, "figures", f"job {i + 1}: ")
            if len(jobs) > MOST_JOBS:
                self.refuse(f"job {i + 1}: over", f"more than {MOST_JOBS} jobs together", "fewer", "split the campaign")
        return Campaign(
            self.path,
            self.folder / out,
            self.number(head, "retries", "campaign.", 2, 0, 20, True),
            self.ordered(jobs),
            figures,
        )

    def texts(self, table, key, where, needed=False):
        value = table.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value) or (needed and not value):
            self.refuse(where + key, repr(value), "a list of texts", 'write it as ["simulate", "--room", "{room}"]')
        return value

    def entry(self, i, entry, head):
        where = f"job {i + 1}: "
        if not isinstance(entry, dict):
            self.refuse(where, repr(entry), "a table", "write [[job]]")
        self.only(entry, JOB_KEYS, where)
        run = self.texts(entry, "run", where, needed=True)
        over = entry.get("over", {})
        if not isinstance(over, dict):
            self.refuse(where + "over", repr(over), "a table of lists", 'write over = {room = ["301", "401"]}')
        for key, values in over.items():
            if key in OWN_PLACES:
                self.refuse(f"{where}over.{key}", "a name that is taken", "another name", f"{{{key}}} is a folder")
            if not isinstance(values, list) or not values:
                self.refuse(f"{where}over.{key}", repr(values), "a list with at least one value", "write [1, 2, 3]")
            if not all(isinstance(v, (str, int, float)) and not isinstance(v, bool) for v in values):
                self.refuse(f"{where}over.{key}", repr(values), "texts or numbers", "write each as a text")
            if len(set(map(str, values))) < len(values):
                self.refuse(f"{where}over.{key}", "a value twice", "each value once", "remove one")
        name = entry.get("name", "-".join([run[0], *("{" + key + "}" for key in over)]))
        after = entry.get("after", {})
        if isinstance(after, str):
            after = {"after": after}
        if not isinstance(after, dict) or not all(isinstance(v, str) for v in after.values()):
            self.refuse(
                where + "after", repr(after), "a job's name, or a table of names", 'write after = "train-{room}"'
            )
        cpus = self.number(entry, "cpus", where, head.get("cpus", 1), 0.1, 64)
        timeout = self.number(entry, "timeout_min", where, head.get("timeout_min", 60), 0.01, 100_000)
        jobs = []
        for values in itertools.product(*over.values()):
            known = dict(zip(over, values)) | {"dir": str(self.folder)}

            def fill(text, key, kept=()):
                return self.filled(text, known, kept, where + key)

            if not isinstance(name, str):
                self.refuse(where + "name", repr(name), "a text", "correct it")
            job_name = fill(name, "name")
            if not NAME.fullmatch(job_name):
                self.refuse(where + "name", repr(job_name), "letters, digits, dots and dashes", "correct it")
            kept = ("out", *after)
            job = Job(
                i,
                job_name,
                [fill(word, "run", kept) for word in run],
                dict(zip(over, values)),
                {place: [fill(other, f"after.{place}")] for place, other in after.items()},
                [fill(word, "inputs") for word in self.texts(entry, "inputs", where)],
                cpus,
                timeout,
            )
            for path in job.inputs:
                if not (self.folder / path).exists():
                    self.refuse(where + "inputs", f"{path}, which is not there", "a file or a folder", "check the path")
            jobs.append(job)
        self.all_used(over, after, run + entry.get("inputs", []), where)
        return jobs

    def all_used(self, over, after, words, where):
        """A key that no job takes would count the same work several times, as seeds that agree to the last digit."""
        used = {place for word in words for place in PLACE.findall(word)}
        used |= {key for place, name in after.items() if place in used for key in PLACE.findall(name)}
        for key in over:
            if key not in used:
                self.refuse(
                    f"{where}over.{key}",
                    "a key that run does not use",
                    f"{{{key}}} in run, in inputs, or in a name of after",
                    f'write it there, such as "--{key}", "{{{key}}}", or remove it',
                )

    def filled(self, text, known, kept, where):
        def one(match):
            place = match[1]
            if place in kept:
                return match[0]
            if place not in known:
                self.refuse(
                    where,
                    match[0],
                    "one of " + ", ".join("{%s}" % k for k in [*known, *kept]),
                    f"give {place} in over, or correct the name",
                )
            return str(known[place])

        return PLACE.sub(one, text)

    def matching(self, job, place, wanted, by_name):
        """Names of the jobs that `wanted` is: one, or all that a pattern with * fits, in the order of the file."""
        if "*" in wanted:
            names = [name for name in by_name if name != job.name and fnmatch.fnmatchcase(name, wanted)]
        else:
            names = [wanted] if wanted in by_name else []
        if not names:
            near = difflib.get_close_matches(wanted, by_name, 1)
            self.refuse(
                f"job {job.entry + 1}: after.{place}",
                f"{wanted}, which no job is",
                "a job's name, or a pattern with *",
                f"perhaps {near[0]}" if near else "correct it",
            )
        return names

    def ordered(self, jobs):
        """Each after those that it needs."""
        by_name = {}
        for job in jobs:
            if job.name in by_name:
                self.refuse(
                    f"job {job.entry + 1}: name",
                    f"{job.name} twice",
                    "a name for each job",
                    "put every key of over into the name",
                )
            by_name[job.name] = job
        for job in jobs:
            job.after = {place: self.matching(job, place, names[0], by_name) for place, names in job.after.items()}
            for word in job.run:
                many = [p for p in PLACE.findall(word) if len(job.after.get(p, ())) > 1]
                if len(many) > 1:
                    self.refuse(
                        f"job {job.entry + 1}: run",
                        f"{word}, with two places of several jobs",
                        "one such place in a word",
                        "write two words",
                    )
        order, state = [], {}

        def needs_of(job):
            return itertools.chain.from_iterable(job.after.values())

        def visit(first):
            stack = [(first, needs_of(first))]
            state[first.name] = 1
            while stack:
                job, needs = stack[-1]
                for other in needs:
                    if state.get(other) == 1:
                        self.refuse(
                            f"job {job.entry + 1}: after",
                            f"{job.name} and {other} wait for each other",
                            "an order without a circle",
                            "remove one of the two",
                        )
                    if other not in state:
                        state[other] = 1
                        stack.append((by_name[other], needs_of(by_name[other])))
                        break
                else:
                    stack.pop()
                    state[job.name] = 2
                    order.append(job)

        for job in jobs:
            if job.name not in state:
                visit(job)
        return order
