#!/usr/bin/env python3
"""What happens to a shard whose process is killed, or whose disk loses power.

With --long: 100 rounds of kill -9, ten power cuts. Each has its control: the same
test with the protection taken away, which must find a loss.
"""

import os
import random
import subprocess
import sys
import unittest

from support import disks, harness, store_probe

LONG = "--long" in sys.argv
SEED = int(os.environ.get("VOX_SEED") or random.randrange(1 << 30))


class Kill(harness.SystemTest):
    def setUp(self):
        super().setUp()
        self.rng = random.Random(SEED)

    def test_kill_9_loses_nothing_acknowledged_and_applies_nothing_twice(self):
        wrong = store_probe.kill_rounds(self.folder, 100 if LONG else 10, self.rng)
        self.assertEqual(wrong, "", f"VOX_SEED={SEED}")

    def test_control_a_writer_that_acknowledges_too_early_is_found_out(self):
        wrong = store_probe.kill_rounds(self.folder, 5, self.rng, "--ack-ahead", "2")
        self.assertIn("was acknowledged", wrong, f"VOX_SEED={SEED}")


class Reading(harness.SystemTest):
    READS = 3000

    def read(self, probe):
        """Reads so many times; how many appends were told of meanwhile."""
        appends = 0
        for _ in range(self.READS):
            probe.stdin.write("\n")
            probe.stdin.flush()
            while (line := probe.stdout.readline()) != "R\n":
                self.assertEqual(line, "A\n")
                appends += 1
        return appends

    def test_reading_does_not_wait_for_a_write_whose_disk_stands_still(self):
        if disks.missing():
            self.skipTest("no disk that can stand still: " + disks.missing())
        disk = disks.FailingDisk(self.folder)
        self.addCleanup(disk.down)
        disk.up()
        probe = subprocess.Popen([store_probe.PROBE, "read-beside", disk.mount / "model"],
                                 stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(probe.communicate)
        self.addCleanup(probe.kill)
        while self.read(probe) == 0:  # The control: meanwhile a disk at work takes appends.
            pass
        disk.stand_still()
        while self.read(probe) > 0:  # Those under way may have had their sync.
            pass
        disk.go_on()
        self.assertEqual(probe.stdout.readline(), "A\n")


@unittest.skipUnless(LONG, "--long only")
class PowerCut(harness.SystemTest):
    def setUp(self):
        super().setUp()
        if disks.missing():
            self.skipTest("no disk whose power can be cut: " + disks.missing())
        self.disk = disks.VolatileDisk(self.folder)
        self.addCleanup(self.disk.down)
        self.rng = random.Random(SEED)

    def cuts(self, rounds, *options):
        """Cuts the power so many times. Returns what the first loss was, in words."""
        acknowledged = -1
        for _ in range(rounds):
            self.disk.up()
            writer = store_probe.Writer(self.disk.mount / "model", *options)
            writer.read_until(acknowledged + self.rng.randint(5, 80))
            self.disk.cut()
            writer.kill()
            acknowledged = max(acknowledged, writer.acknowledged)
            self.disk.down()
            self.disk.up()
            wrong = store_probe.verify(self.disk.mount / "model", acknowledged)
            self.disk.down()
            if wrong:
                return wrong
        return ""

    def test_ten_power_cuts_lose_nothing_acknowledged(self):
        self.assertEqual(self.cuts(10), "", f"VOX_SEED={SEED}")

    def test_control_without_syncing_a_power_cut_loses(self):
        self.assertNotEqual(self.cuts(3, "--no-sync"), "", f"VOX_SEED={SEED}")


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
