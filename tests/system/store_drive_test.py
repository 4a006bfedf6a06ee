#!/usr/bin/env python3
"""A model of 100 000 tiles, driven through the real services, killed with -9 on the way.

Cities of the simulated drive lie side by side; every tenth is published while the tile store is
killed and started again. The figures are printed. With --tiles N: as many.
"""

import itertools
import json
import re
import subprocess
import sys
import time

from support import harness

from demo import peak_memory
from service_set import ServiceSet, default_bin_dir

TILES = 100_000
SCANS = 100  # A city: some 1 200 tiles.
BUDGET_MB = 256
UNLIMITED_MB = 16384
KILL_EVERY = 10


def city(number):
    """Its middle, 1.5 km from its neighbours': farther than rays reach."""
    return ["--simulate", SCANS, "--speed", 50, "--source", f"city-{number}", "--place",
            f"48.1489,{11.568 + 0.02 * number:.3f},560"]


class Drive(harness.SystemTest):
    def hashes(self, services):
        file = self.folder / "hashes"
        services.run("stat", "--hashes", file, quiet=True)
        return set(file.read_text().splitlines())

    def kill_in_the_middle(self, services, number):
        """Publishes a city. Half-way the tile store is killed. Returns its peak and a recovery."""
        store = services.find("tilestore")
        watch = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
        self.addCleanup(watch.communicate)
        self.addCleanup(watch.kill)
        told = (status["counters"] for status in map(json.loads, watch.stdout)
                if status["service"] == "tilestore" and status["ready"])
        before = next(told)
        publish = services.begin("publish", *city(number), "--hz", 50, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        self.addCleanup(publish.communicate)
        self.addCleanup(publish.kill)
        next(now for now in told if now["scans_applied"] >= before["scans_applied"] + SCANS / 2)
        self.assertIsNone(publish.poll(), "the publish was over before the kill")
        peak = peak_memory(store)
        store.kill()
        began = time.monotonic()
        store.start(services.ended)
        next(now for now in told if now["epoch"] > before["epoch"])
        recovery = time.monotonic() - began
        watch.kill()
        _, err = publish.communicate()
        self.assertEqual(publish.returncode, 0, err)
        return peak, recovery

    def drive(self, services):
        """Publishes cities until there are enough tiles. Returns those with a kill, and all hashes.
        """
        killed, peaks, recoveries, first = [], [], [], None
        for number in itertools.count():
            if number % KILL_EVERY == KILL_EVERY // 2 or number == 1:
                peak, recovery = self.kill_in_the_middle(services, number)
                killed.append(number)
                peaks.append(peak)
                recoveries.append(recovery)
            else:
                services.run("publish", *city(number), quiet=True)
            first = first or len(self.hashes(services))
            hashes = self.hashes(services) if (number + 1) * first >= TILES else []
            if len(hashes) >= TILES:
                break
            print(f"city {number}", flush=True)
        peaks.append(peak_memory(services.find("tilestore")))
        print(f"cities {number + 1}, killed in {killed}\n"
              f"peak MiB {[round(peak / 2**20) for peak in peaks]}\n"
              f"recovery s {[round(seconds, 2) for seconds in recoveries]}")
        self.assertLessEqual(max(peaks), 1.5 * BUDGET_MB * 2**20)
        return killed, hashes

    def store(self, command, *arguments):
        began = time.monotonic()
        done = subprocess.run([default_bin_dir() / "voxatlas", "store", command, *arguments,
                               "--data-dir", self.folder / "model"], check=True, text=True,
                              capture_output=True, stdin=subprocess.DEVNULL)
        print(f"{command}, {time.monotonic() - began:.1f} s: {done.stdout.strip()}")

    def test_a_hundred_thousand_tiles_survive_kills_and_are_the_undisturbed_ones(self):
        began = time.monotonic()
        with ServiceSet(self.folder / "model", renders=0, compressors=0,
                        store_options=["--cache-mb", BUDGET_MB]) as services:
            killed, everything = self.drive(services)
            print(f"built and hashed in {time.monotonic() - began:.0f} s")
            log = services.find("tilestore").log_path.read_text()
            print("\n".join(re.findall(r".*recovered.*", log)))
        self.store("verify")
        self.store("stat")
        with ServiceSet(self.folder / "undisturbed", renders=0, compressors=0,
                        store_options=["--cache-mb", UNLIMITED_MB]) as services:
            for number in killed:
                services.run("publish", *city(number), quiet=True)
            some = self.hashes(services)
            print(f"undisturbed and unlimited: {len(some)} tiles of {len(killed)} cities, "
                  f"{len(some - everything)} differ", flush=True)
        self.assertLessEqual(some, everything)  # Each tile in the same version, with the same hash.
        self.assertGreater(len(some), 3 * SCANS)


if __name__ == "__main__":
    if "--tiles" in sys.argv:
        at = sys.argv.index("--tiles")
        TILES = int(sys.argv[at + 1])
        del sys.argv[at:at + 2]
    harness.main()
