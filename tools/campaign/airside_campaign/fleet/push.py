"""Weights to a fleet, wave by wave: each box once, and no further wave where trials end badly."""

import time
from pathlib import Path

from airside_campaign.complaint import BadInput
from airside_campaign.fleet.box import Later, Refused, unfit
from airside_campaign.fleet.boxes import BAD, SILENT, Boxes
from airside_campaign.fleet.record import WAITING, now_text
from airside_campaign.fleet.weights import try_on_site

ROWS_UNTIL_TAKEN = 3  # rows after which a box that has not taken the weights will not


class Halt(Exception):
    """Why no further box gets the weights."""


class Push:
    """`progress`: called with this after each look at the boxes. `check_again`: raises BadInput where the weights may
    not go out any more; called before each wave, since waves lie days apart."""

    def __init__(self, fleet, weights, program, record, progress=None, check_again=None):
        self.fleet, self.weights, self.program, self.record = fleet, weights, program, record
        self.boxes = Boxes(fleet, program)
        self.progress = progress or (lambda push: None)
        self.check_again = check_again or (lambda: None)
        self.unfit = {}  # box -> why nothing was sent to it
        self.rows = {}  # box -> times of the rows that were seen after it was sent to
        self.wave, self.planned = 0, {}  # wave -> how many boxes it is for
        self.silent, self.passed_over = [], set()  # of the boxes asked in this wave

    def of(self, name):
        return self.record.state["boxes"].get(name, {})

    def phase(self, name):
        return self.of(name).get("phase")

    def named(self, *phases):
        return [name for name in self.fleet.boxes if self.phase(name) in phases]

    def is_open(self, name):
        return self.phase(name) is None

    def check(self):
        """Everything for which the push is refused before its first box. Raises BadInput."""
        if self.record.state.get("undone"):
            raise BadInput(
                self.record.path,
                f"weights that were taken back at {self.record.state['undone']}",
                "others",
                "sign anew",
            )
        for name in self.record.state["boxes"]:
            if name not in self.fleet.boxes:
                raise BadInput(
                    f"{self.fleet.path}: boxes",
                    f"no {name}, which this push has reached",
                    "the boxes of its begin",
                    "add it",
                )
        names = [name for name in self.fleet.boxes if self.is_open(name)]
        for name in names:
            box = self.fleet.boxes[name]
            place = f"{self.fleet.path}: group.{box.group}: {name}"
            for key in ("site", "ca", "access"):
                if key in box.ways and not Path(box.ways[key]).is_file():
                    raise BadInput(
                        f"{place}: {key}", f"no file {box.ways[key]}", "a file", "correct the path, or remove the box"
                    )
            if "site" in box.ways and not self.record.state["boxes"]:  # else the push itself tells
                try_on_site(self.program, self.weights.path, self.weights.name, box.ways["site"], place)
        seen = self.boxes.seen(names)
        for name, said in seen.items():
            box = self.fleet.boxes[name]
            if not isinstance(said, Exception) and said.topology != box.topology:
                raise BadInput(
                    f"{self.fleet.path}: group.{box.group}: {name}",
                    f"a box of {said.topology}",
                    box.topology,
                    f'write topology = "{said.topology}", or put the box into another group',
                )
        return seen

    def plan(self, seen):
        """Wave by wave the boxes that would get the weights now, if each trial went well. Sends nothing."""
        for name, said in seen.items():
            why = str(said) if isinstance(said, Exception) else unfit(said, self.weights.crc)
            if why:
                self.unfit[name] = why
        planned = set(self.record.state["boxes"])
        waves = []
        for wave in range(len(self.fleet.waves)):
            chosen = []
            for group, names in self.fleet.groups.items():
                need = self.fleet.target(wave, group) - sum(name in planned for name in names)
                chosen += [n for n in names if n not in planned and n not in self.unfit][: max(0, need)]
            planned.update(chosen)
            waves.append(chosen)
        return waves

    def run(self):
        """All waves. Raises Halt; what was done is in the record."""
        self.record.state.pop("halted", None)
        self.look_again(self.named(*SILENT))
        self.look(self.named(*WAITING))
        try:
            for wave in range(len(self.fleet.waves)):
                self.wave = wave
                self.send_wave()
                self.wait()
            self.look_at_kept()
            self.judge()
        except Halt as error:
            self.record.state["halted"] = {"wave": self.wave + 1, "why": str(error), "at": now_text()}
            self.record.set({}, [{"event": "halted", "wave": self.wave + 1, "why": str(error)}])
            raise

    def needs(self):
        """Group -> how many of its boxes the wave still needs. A group of which no box has kept the weights has no
        canary, and waits."""
        for group, names in self.fleet.groups.items():
            if self.wave == 0 or any(self.phase(name) == "kept" for name in names):
                yield group, max(0, self.fleet.target(self.wave, group) - sum(not self.is_open(n) for n in names))

    def chunk(self, asked):
        """The next boxes of the wave that were not asked yet, as many as are asked at once."""
        chosen = []
        for group, need in self.needs():
            chosen += [n for n in self.fleet.groups[group] if self.is_open(n) and n not in asked][:need]
        return chosen[: self.fleet.at_once]

    def where(self, wave):
        return f"wave {wave + 1} of {len(self.fleet.waves)}"

    def before_wave(self):
        """What may have changed in the days since the wave before: weights that were revoked, boxes that went back."""
        self.look_at_kept()
        needed = sum(need for _, need in self.needs())
        self.planned[self.wave] = len(self.of_wave(self.wave)) + needed
        self.judge()
        if not needed:
            return
        try:
            self.check_again()
        except BadInput as error:
            raise Halt(f"{self.where(self.wave)}: revoked meanwhile, or not to be checked any more: {error}") from error

    def look_at_kept(self):
        changes = {}
        for name, said in self.boxes.seen(self.named("kept")).items():
            if isinstance(said, Exception):
                continue  # its trial went well; who is silent now may be asked by `airside fleet status`
            if said.crc != self.weights.crc:
                changes[name] = {"phase": "replaced", "why": f"weights {said.crc} were pushed after these were kept"}
            elif said.weights == "rolled back":
                changes[name] = {"phase": "rolled back", "why": "after they were kept"}
        if changes:
            self.record.set(changes, [{"event": c["phase"], "box": n, "why": c["why"]} for n, c in changes.items()])

    def send_wave(self):
        asked, self.silent, self.passed_over = set(), [], set()
        self.before_wave()
        while names := self.chunk(asked):
            asked.update(names)
            fit = {}
            for name, said in self.boxes.seen(names).items():
                self.unfit.pop(name, None)
                if isinstance(said, Exception):
                    self.unfit[name] = str(said)
                    self.silent.append(name)
                    self.passed_over.add(name)
                elif said.crc == self.weights.crc and said.weights != "none":
                    self.adopt(name, said)
                elif why := unfit(said, self.weights.crc):
                    self.unfit[name] = why
                    self.passed_over.add(name)
                else:
                    fit[name] = said
            self.judge()
            self.send(fit)
            self.judge()
        if self.wave == 0 and self.planned[0] and not self.of_wave(0):
            raise Halt(f"{self.where(0)}: no box is fit for it")

    def of_wave(self, wave):
        return [name for name in self.fleet.boxes if self.of(name).get("wave") == wave + 1]

    def not_replaced(self):
        """Boxes that gave no answer when the wave came to them, as far as their group has no others in their place."""
        found = []
        for group, need in self.needs():
            names = self.fleet.groups[group]
            others = sum(self.is_open(name) and name not in self.passed_over for name in names)
            found += [name for name in names if name in self.silent][: max(0, need - others)]
        return found

    def adopt(self, name, seen):
        """A box that has these weights, from a push whose state is lost or by hand."""
        phase = {"on trial": "on trial", "confirmed": "kept", "rolled back": "rolled back"}[seen.weights]
        change = {"phase": phase, "wave": self.wave + 1, "sent_at": time.time(), "why": "it had them already"}
        self.record.set({name: change}, [{"event": "found", "box": name, "as": phase}])

    def send(self, fit):
        """To boxes that are fit now. What is meant is on the disk first: who goes on knows what may have arrived."""
        if not fit:
            return
        meant = {}
        for name, seen in fit.items():
            wave = self.of(name).get("wave", self.wave + 1)
            meant[name] = {"phase": "sending", "wave": wave, "sent_at": time.time(), "refusal": seen.refusal}
            self.rows[name] = {seen.time}
        self.record.set(meant, [{"event": "sending", "box": name, "wave": meant[name]["wave"]} for name in fit])
        changes, events = {}, []
        for name, failed in self.boxes.each(fit, lambda box: box.push(self.weights.path)).items():
            if isinstance(failed, Later):
                changes[name], self.unfit[name] = None, str(failed)
                self.passed_over.add(name)
                events.append({"event": "put off", "box": name, "why": str(failed)})
            elif isinstance(failed, Refused):
                changes[name] = {"phase": "refused", "why": str(failed)}
                events.append({"event": "refused", "box": name, "why": str(failed)})
            elif failed is not None:  # it may have arrived: its status will tell
                changes[name] = {"error": str(failed)}
            else:
                changes[name] = {"phase": "sent"}
                events.append({"event": "sent", "box": name})
        self.record.set(changes, events)

    def wait(self):
        """Until the trials of all boxes that have been sent to are over."""
        while True:
            self.look(self.named(*WAITING))
            self.judge()
            self.progress(self)
            if not self.named(*WAITING):
                return
            time.sleep(self.fleet.poll_s)

    def look(self, names):
        """Asks boxes and notes what has changed."""
        changes, events, again = {}, [], {}
        for name, said in self.boxes.seen(names).items():
            change = self.change_of(name, said, again)
            if not change or change["phase"] == self.phase(name):
                continue
            if change["phase"] not in WAITING:
                change["ended_at"] = time.time()
            changes[name] = change
            events.append({"event": change["phase"], "box": name, "why": change.get("why", "")})
        if changes:
            self.record.set(changes, events)
        self.send(again)

    def look_again(self, names):
        """Boxes that gave no answer in time. One that runs and never had the weights is sent to in its turn."""
        changes = {}
        for name, said in self.boxes.seen(names).items():
            if isinstance(said, Exception):
                continue
            if said.crc == self.weights.crc or self.of(name).get("taken"):
                changes[name] = {"phase": "on trial", "sent_at": time.time()}  # as far as is known; look() knows more
            elif said.condition in ("running", "alarm"):
                changes[name] = None
        if changes:
            self.record.set(changes, [{"event": "asked again", "box": name} for name in changes])

    def change_of(self, name, said, again):
        """What a look at a box changes. `again`: boxes that were not reached before a push was killed."""
        box = self.of(name)
        is_over = time.time() - box["sent_at"] >= self.fleet.trial_limit_s
        late = {"phase": "no answer", "why": box.get("error", "the trial was not over in time")} if is_over else {}
        if isinstance(said, Exception):
            return late and late | {"why": str(said)}
        if said.crc == self.weights.crc:
            if said.weights == "confirmed":
                return {"phase": "kept", "why": ""}
            if said.weights == "rolled back":
                return {"phase": "rolled back", "why": "while they were on trial"}
            return late or {"phase": "on trial", "taken": True}
        if box.get("taken"):
            return {"phase": "replaced", "why": f"weights {said.crc} were pushed meanwhile"}
        waits = said.refusal.startswith("state invalid")  # the box tries again with each row
        if said.refusal and said.refusal != box.get("refusal", "") and not waits:
            return {"phase": "refused", "why": said.refusal}
        rows = self.rows.setdefault(name, {said.time})
        if said.condition in ("running", "alarm"):
            rows.add(said.time)
        if len(rows) <= ROWS_UNTIL_TAKEN or waits:
            return late
        if box["phase"] == "sending" and "error" not in box and not unfit(said, self.weights.crc):
            again[name] = said
            return {}
        return {"phase": "refused", "why": box.get("error") or said.refusal or "it was not taken"}

    def judge(self):
        """Raises Halt where more of a wave so far went wrong than may; a box may roll back long after its own wave."""
        for wave, planned in self.planned.items():
            names = self.of_wave(wave)
            bad = [name for name in names if self.phase(name) in BAD]
            silent = [name for name in names if self.phase(name) in SILENT]
            silent += self.not_replaced() if wave == self.wave else []
            for wrong, limit, what in (
                (bad, self.fleet.rolled_back_limit, "rolled back or refused"),
                (silent, self.fleet.no_answer_limit, "give no answer"),
            ):
                size = max(1, planned)
                if len(wrong) > limit * size + 1e-9:
                    raise Halt(f"{self.where(wave)}: {len(wrong)} of {size} boxes {what}, more than {100 * limit:g} %")

    def at_wave(self):
        """The wave whose trials go on, from 1; a push that goes on finds them before it comes to that wave."""
        return max([self.wave + 1] + [self.of(name)["wave"] for name in self.named(*WAITING)])

    def left_s(self):
        """About how long it will take, and at most, s. A trial lasts a day; what has ended says how long it took."""
        now = time.time()
        boxes = self.record.state["boxes"].values()
        took = [b["ended_at"] - b["sent_at"] for b in boxes if b.get("phase") == "kept" and "ended_at" in b]
        trial = max(took, default=86400)
        sent = [self.of(name)["sent_at"] for name in self.named(*WAITING)]
        begun = now - max(sent) if sent else None
        later = 0
        for wave in range(self.at_wave(), len(self.fleet.waves)):
            before = {g: self.fleet.target(wave - 1, g) for g in self.fleet.groups}
            later += any(self.fleet.target(wave, g) > before[g] for g in self.fleet.groups)
        about, most = later * trial, later * self.fleet.trial_limit_s
        if begun is not None:
            about += max(0, trial - begun)
            most += max(0, self.fleet.trial_limit_s - begun)
        return about, most
