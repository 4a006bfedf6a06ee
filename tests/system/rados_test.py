#!/usr/bin/env python3
"""The tile store's contract on a real Ceph cluster: one monitor and three OSDs on loopback."""

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


if __name__ == "__main__":
    harness.main()
