#!/usr/bin/env python3
"""A tile store's resident memory stays within 1.5 times its budget, and its tiles are the same.

With --long: 100 000 tiles with 256 MiB.
"""

import subprocess
import sys

from support import harness, store_probe

from service_set import default_bin_dir

LONG = "--long" in sys.argv
TILES, BUDGET_MB = (100_000, 256) if LONG else (6_000, 64)
UNLIMITED_MB = 1 << 14


class Memory(harness.SystemTest):
    def test_many_tiles_fit_a_small_budget_and_are_those_of_an_unlimited_run(self):
        bounded = store_probe.fill(self.folder / "bounded", TILES, BUDGET_MB)
        unlimited = store_probe.fill(self.folder / "unlimited", TILES, UNLIMITED_MB)
        self.assertEqual(bounded["hash"], unlimited["hash"])
        self.assertLessEqual(float(bounded["peak_mib"]), 1.5 * BUDGET_MB)
        # The control: so many tiles do not fit by themselves.
        self.assertGreater(float(unlimited["peak_mib"]), 1.5 * BUDGET_MB)

    def test_a_budget_that_cannot_be_kept_is_refused(self):
        done = subprocess.run([default_bin_dir() / "voxatlas-tilestore", "--data-dir", self.folder,
                               "--cache-mb", "63"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("at least 64 MiB", done.stderr)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
