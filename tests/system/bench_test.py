#!/usr/bin/env python3
"""The benches of the bus run, print what they promise, and lose nothing.

With --long: at full length, on 20 M rays. How fast it was is printed, not judged: a machine that is
busy with other tests is slow. The ratio to OctoMap in the same run is judged.
"""

import os
import pathlib
import subprocess
import sys
import unittest

from support import harness

from service_set import default_bin_dir

LONG = "--long" in sys.argv
BENCHES = pathlib.Path(__file__).resolve().parent.parent / "bench"
BUS_LINES = {"udpm_default_MBps", "udpm_large_MBps", "udpm_drop5_MBps", "hub_MBps",
             "udpm_default_8_MBps", "udpm_large_receive_buffer"}
SLOW_MS = 5
LEAST_VS_OCTOMAP = 20


@unittest.skipUnless(harness.multicast_here() and os.geteuid() == 0,
                     "no network namespace of its own: no multicast, no nftables")
class Bench(harness.SystemTest):
    def figures(self, *command):
        """The lines `name value unit` of a bench."""
        done = subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, text=True,
                              capture_output=True, check=False)
        print(done.stdout, done.stderr, file=sys.stderr)
        self.assertEqual(done.returncode, 0)
        return {name: float(value) for name, value, _ in map(str.split, done.stdout.splitlines())}

    def test_streams_lose_nothing_over_any_buffer_a_hub_and_a_bus_that_loses_datagrams(self):
        found = self.figures(default_bin_dir() / "bench_bus", "--megabytes", 2000 if LONG else 40)
        for name in BUS_LINES:
            self.assertGreater(found[name], 0, name)
        for name in ("udpm_default_resent", "udpm_large_resent", "hub_resent",
                     "udpm_slow_chunks_resent"):
            self.assertEqual(found[name], 0, name)  # A clean bus loses nothing at all.
        # Until the consumer knows of all eight, each may send what one alone may.
        self.assertLessEqual(found["udpm_default_8_chunks_resent"], 8 * 4)
        self.assertGreater(found["udpm_drop5_resent"], 1)
        self.assertGreaterEqual(found["udpm_slow_ms_per_message"], SLOW_MS)
        self.assertLess(found["udpm_slow_producer_grew"], 4)

    def test_scans_become_durable_and_none_is_lost(self):
        how = [] if LONG else ["--million-rays", 0.1, "--only", "free80"]
        found = self.figures(sys.executable, "-B", BENCHES / "endtoend_bench.py", *how)
        self.assertEqual(found["lost_scans"], 0)
        self.assertGreater(found["free80_rays_per_s"], 0)
        for channel in ("CHUNK_INGEST_0", "CHUNK_STORE_0", "ACK", "TILE_UPDATE", "STATUS"):
            self.assertGreater(found[f"free80_{channel}_bytes_per_ray"], 0)
        for process in ("tilestore_0", "ingest_0", "publish"):
            self.assertGreater(found[f"free80_{process}_cpu"], 0)
        if LONG:
            self.assertGreater(found["carve10_vs_octomap_inprocess"], LEAST_VS_OCTOMAP)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
