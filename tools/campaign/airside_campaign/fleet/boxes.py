"""All boxes of a fleet together, and the phases that they go through in a push."""

from concurrent.futures import ThreadPoolExecutor

from airside_campaign.fleet.box import NoAnswer, Refused, reach
from airside_campaign.fleet.record import WAITING

BAD = ("rolled back", "refused", "replaced")
SILENT = ("no answer",)
PHASES = (*WAITING, "kept", *BAD, *SILENT, "undone")


class Boxes:
    """All boxes of a fleet, asked several at a time."""

    def __init__(self, fleet, program):
        self.fleet = fleet
        self.by_name = {name: reach(box, program) for name, box in fleet.boxes.items()}

    def each(self, names, do):
        """name -> what do(box) gave, or the NoAnswer or Refused that it raised."""

        def guarded(name):
            try:
                return do(self.by_name[name])
            except (NoAnswer, Refused) as error:
                return error

        names = list(names)
        with ThreadPoolExecutor(max(1, min(self.fleet.at_once, len(names)))) as pool:
            return dict(zip(names, pool.map(guarded, names)))

    def seen(self, names):
        return self.each(names, lambda box: box.seen())
