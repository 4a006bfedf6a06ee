#!/usr/bin/env python3
"""An enemy on the bus during a publish: random bytes and hostile counts on every channel."""

import pathlib
import signal
import subprocess
import sys

from support import harness
from support.publishing import PublishTest, tile_hashes

from service_set import ServiceSet, default_bin_dir

MOST_RESIDENT_MB = 1200  # Of one service: a count that is believed costs gigabytes.


def peak_resident_mb(service):
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text(encoding="ascii")
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


class Hostile(PublishTest):
    SCANS = 40
    SET = {"stores": 2, "renders": 1}

    def test_an_enemy_on_every_channel_changes_nothing(self):
        with ServiceSet(self.folder, **self.SET) as services:
            enemy = subprocess.Popen(
                [default_bin_dir() / "bus_hostile", services.bus.url, "2", "1", "1"],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
            self.addCleanup(enemy.wait)
            self.addCleanup(enemy.kill)
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertIsNone(enemy.poll(), "the enemy gave up first")
            self.assertEqual(tile_hashes(services), self.undisturbed)
            enemy.send_signal(signal.SIGTERM)
            said, _ = enemy.communicate()
            print(said, file=sys.stderr)
            counts = dict(zip(said.split()[::2], map(int, said.split()[1::2])))
            for kind in ("noise", "fingerprinted", "stamped", "sound"):
                self.assertGreater(counts[kind], 100, said)
            services.check_alive()
            for service in services.services:
                self.assertLess(peak_resident_mb(service), MOST_RESIDENT_MB, service.name)
            self.assertTrue(any("dropped" in service.log_path.read_text()
                                for service in services.services))


if __name__ == "__main__":
    harness.main()
