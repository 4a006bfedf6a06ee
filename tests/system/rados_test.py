#!/usr/bin/env python3
"""The tile store's contract, and the demo, on a real Ceph cluster: a monitor and three OSDs on loopback."""

import os
import pathlib
import subprocess
import unittest

from support import ceph, harness

CONTRACT = pathlib.Path(os.environ["VOX_BIN_DIR"]) / "rados_contract"


@unittest.skipUnless(CONTRACT.exists(), "built without librados (scripts/setup --rados)")
class Rados(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        if ceph.missing():
            raise unittest.SkipTest("no cluster: " + ceph.missing())
        cls.cluster = ceph.Cluster(harness.temporary_folder(cls))
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()

    def test_the_contract_holds(self):
        done = subprocess.run([CONTRACT], check=False, capture_output=True, text=True,
                              env={**os.environ, "VOX_RADOS_CONF": str(self.cluster.conf),
                                   "VOX_RADOS_POOL": ceph.POOL})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_demo_makes_the_same_model_in_a_cluster(self):
        hashes = []
        for name, store in (("cluster", ["--store", self.cluster.store("demo")]), ("folder", [])):
            out = self.folder / name
            done = subprocess.run([harness.ROOT / "scripts" / "demo", "--scans", "5", "--out", out,
                                   *store], check=False, capture_output=True, text=True,
                                  stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            hashes.append((out / "hashes_after_restart.txt").read_text())
        self.assertGreater(len(hashes[0].splitlines()), 10)
        self.assertEqual(*hashes)


if __name__ == "__main__":
    harness.main()
