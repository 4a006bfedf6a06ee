#!/usr/bin/env python3
"""A tile store's resident memory stays within 1.5 times its budget, and its tiles are the same.

Once a shard alone with more tiles than fit, once the process itself while scans carve free space at
10 cm. With --long: 100 000 tiles with 256 MiB, and 40 scans.
"""

import subprocess
import sys

from support import harness, store_probe

from demo import peak_memory
from service_set import ServiceSet, default_bin_dir

LONG = "--long" in sys.argv
TILES, BUDGET_MB = (100_000, 256) if LONG else (8_000, 128)
CARVING_SCANS, CARVING_MB = (40 if LONG else 4), 128
UNLIMITED_MB = 1 << 14


class Memory(harness.SystemTest):
    def test_many_tiles_fit_a_small_budget_and_are_those_of_an_unlimited_run(self):
        bounded = store_probe.fill(self.folder / "bounded", TILES, BUDGET_MB)
        unlimited = store_probe.fill(self.folder / "unlimited", TILES, UNLIMITED_MB)
        self.assertEqual(bounded["hash"], unlimited["hash"])
        self.assertLessEqual(float(bounded["peak_mib"]), 1.5 * BUDGET_MB)
        # The control: so many tiles do not fit by themselves.
        self.assertGreater(float(unlimited["peak_mib"]), 1.5 * BUDGET_MB)

    def test_the_process_keeps_its_budget_while_scans_carve(self):
        with ServiceSet(self.folder / "carved", store_options=["--cache-mb", CARVING_MB,
                                                               "--free-depth", "7"]) as services:
            services.run("publish", "--simulate", CARVING_SCANS)
            store = next(s for s in services.services if s.kind == "tilestore")
            self.assertLessEqual(peak_memory(store) / (1 << 20), 1.5 * CARVING_MB)

    def test_a_budget_that_cannot_be_kept_is_refused(self):
        done = subprocess.run([default_bin_dir() / "voxatlas-tilestore", "--data-dir", self.folder,
                               "--cache-mb", "127"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("at least 128 MiB", done.stderr)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
