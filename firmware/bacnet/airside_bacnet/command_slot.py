"""One commanded object: what stands in its priority array at our priority, as far as we know, and how it comes out."""

import asyncio

from airside_bacnet.client import NotAnswered, Refused
from airside_bacnet.notify import say

SETTLE_S = (0.0, 0.1, 0.3, 0.6)  # devices may show a command later than they acknowledge it


class CommandSlot:
    """Nothing is shown or written before the slot was emptied once: a gateway that crashed may have left a value."""

    def __init__(self, client, device, name, priority):
        self.client, self.device, self.name, self.priority = client, device, name, priority
        self.may_hold = True
        self.emptied_once = False
        self.commandable = None
        self.written_at = None
        self._said = ""
        self._lock = asyncio.Lock()

    def _say_once(self, text):
        if text != self._said:
            say(text)
        self._said = text

    async def hand_back(self):
        """Writes Null at our priority. Whether the device has acknowledged it."""
        async with self._lock:
            return await self._hand_back()

    async def _hand_back(self):
        if not self.may_hold:
            return True
        try:
            if self.device.address is None and not await self.client.find(self.device):
                self._say_once(f"{self.name.short_text}: device {self.device.instance} is not found; trying again")
                return False
            if self.commandable is None:
                self.commandable = await self.client.is_commandable(self.device, self.name, self.priority)
                if not self.commandable:
                    say(f"{self.name.short_text} has no priority array, so that nobody could give it back: it is never "
                        "written; name a commandable object in the point map")
            if self.commandable:
                await self.client.relinquish(self.device, self.name, self.priority)
                say(f"{self.name.short_text}: priority {self.priority} relinquished")
        except NotAnswered as error:
            self._say_once(f"{self.name.short_text}: {self.device.name}: {error}; its priority {self.priority} is "
                           "still to be relinquished")
            return False
        except Refused as refused:
            self._say_once(f"{self.name.short_text}: {self.device.name} refuses to relinquish priority {self.priority} "
                           f"({refused}); trying again")
            return False
        self._said = ""
        self.may_hold = False
        self.emptied_once = True
        self.written_at = None
        return True

    async def write(self, value, now):
        """Raises NotAnswered or Refused."""
        async with self._lock:
            if not self.emptied_once:
                raise NotAnswered("its priority was not emptied yet")
            if not self.commandable:
                raise Refused("not commandable")
            self.may_hold = True  # also where the answer is lost
            self.written_at = now
            await self.client.command(self.device, self.name, value, self.priority)
            for wait_s in SETTLE_S:
                await asyncio.sleep(wait_s)
                shown = (await self.client.read(self.device, [self.name]))[self.name]
                if not shown.is_good or abs(shown.value - value) <= 1e-4 * max(1.0, abs(value)):
                    return
