"""The way back: each box of a push returns to the weights before it."""

import time

from airside_campaign.fleet.boxes import Boxes
from airside_campaign.fleet.record import now_text


def take_back(fleet, program, record, progress=None):
    """Asks each box that has the weights of a push to go back, and waits for it. Returns box -> why it has not."""
    boxes, state = Boxes(fleet, program), record.state
    state.setdefault("undone", now_text())
    # A box that refused them may have taken them late: what it says of itself counts.
    of_push = [name for name, box in state["boxes"].items() if box["phase"] not in ("rolled back", "undone")]
    open_names = [name for name in of_push if name in fleet.boxes]
    unknown = f"{fleet.path} has no such box; add it again, or roll it back there"
    unreachable = {name: unknown for name in of_push if name not in fleet.boxes}
    record.set({}, [{"event": "undo"}])
    until = time.time() + max(3600, 4 * fleet.poll_s)
    asked, missing = set(), {}
    while open_names:
        changes, events, ask, settled = {}, [], [], []
        for name, said in boxes.seen(open_names).items():
            if isinstance(said, Exception):
                missing[name] = str(said)
            elif said.crc == state["crc"] and said.weights in ("on trial", "confirmed"):
                missing[name] = "it has not gone back yet"
                ask += [name] if name not in asked else []
            elif said.crc == state["crc"]:
                changes[name] = {"phase": "undone", "why": f"weights {said.weights}"}
            elif state["boxes"][name]["phase"] in ("refused", "replaced"):
                settled.append(name)  # it has others, as the record says
            elif state["boxes"][name]["phase"] in ("sending", "sent"):
                missing[name] = "it has not taken them yet"  # they may still lie in its inbox
            else:
                changes[name] = {"phase": "undone", "why": f"weights {said.crc} were pushed since"}
        for name, failed in boxes.each(ask, lambda box: box.roll_back()).items() if ask else ():
            if failed is None:
                asked.add(name)
                events.append({"event": "rollback asked", "box": name})
            else:
                missing[name] = str(failed)
        for name, change in changes.items():
            missing.pop(name, None)
            events.append({"event": "undone", "box": name, "why": change["why"]})
        if changes or events:
            record.set(changes, events)
        open_names = [name for name in open_names if name not in changes and name not in settled]
        if progress:
            progress(len(open_names), missing)
        if not open_names or time.time() > until:
            break
        time.sleep(fleet.poll_s)
    return unreachable | {name: missing.get(name, "") for name in open_names}
