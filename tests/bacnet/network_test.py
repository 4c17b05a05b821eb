"""Broadcasts and routers, in a network of their own: needs `unshare -rn` (user and network namespaces) and `ip`."""

import os
import subprocess
import sys
import unittest

from desk import HERE


class OwnNetwork(unittest.TestCase):
    def test_finds_devices_by_who_is_and_through_a_router(self):
        try:
            can = subprocess.run(["unshare", "-rn", "ip", "link", "set", "lo", "up"], capture_output=True, text=True,
                                 check=False)
            refused = can.stderr.strip() if can.returncode else ""
        except OSError as error:
            refused = str(error)
        if refused:
            self.skipTest(f"no network of its own ({refused}): Who-Is by broadcast and routers were not tested.")
        inside = [sys.executable, "-B", HERE / "run", "--here", os.environ["AIRSIDE_BIN"], "inside_network"]
        done = subprocess.run(["unshare", "-rn", *inside], capture_output=True, text=True, check=False)
        print(done.stdout)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
