#!/usr/bin/env python3
"""A full disk and a failing one, for real: the store stops accepting, says so, loses nothing, and
goes on once the disk is well."""

import ctypes
import json
import os
import subprocess
import unittest

from support import disks, harness

from service_set import ServiceSet, default_bin_dir

SCANS = 40
DISK_MIB = 192
CLONE_NEWNS = 0x00020000


def own_mounts():
    """What this process mounts from now on, nobody else sees, and it goes with the process."""
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNS) != 0:
        raise unittest.SkipTest("no mount namespace: " + os.strerror(ctypes.get_errno()))
    private = subprocess.run(["mount", "--make-rprivate", "/"], capture_output=True, text=True)
    if private.returncode != 0:  # In a chroot, whose root is no mount.
        raise unittest.SkipTest("mounts cannot be kept private: " + private.stderr.strip())


@unittest.skipUnless(os.geteuid() == 0, "mounting a disk takes root")
class DiskFault(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        own_mounts()
        cls.drive = harness.temporary_folder(cls)
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(SCANS), "--out", cls.drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)
        with ServiceSet(harness.temporary_folder(cls), renders=0) as services:
            services.run("publish", cls.drive, "--poses", "poses.txt", quiet=True)
            cls.undisturbed = cls.hashes(services)

    @staticmethod
    def hashes(services):
        file = services.data_dir / "hashes.txt"
        services.run("stat", "--hashes", file, quiet=True)
        return sorted(file.read_text().splitlines())

    def begin(self, services, *arguments):
        process = services.begin(*arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def publish_through(self, folder, fault, words, end, before=0):
        """Publishes into `folder`. After `before` scans there is a fault, until the store says so."""
        with ServiceSet(folder, renders=0, store_options=["--journal-mb", 1]) as services:
            watch = self.begin(services, "watch", "status", "--json")
            stores = (status for status in map(json.loads, watch.stdout)
                      if status["service"] == "tilestore")
            # Paced, so that the fault finds it under way.
            publish = self.begin(services, "publish", self.drive, "--poses", "poses.txt", "--hz", 20)
            if before > 0:
                next(s for s in stores if s["counters"].get("scans_applied", 0) >= before)
            fault()
            for status in stores:
                services.check_alive()
                self.assertIsNone(publish.poll(), "the publish ended before the fault")
                if words in status["state"]:
                    break
            self.assertFalse(status["ready"])
            services.check_alive()
            end()
            _, err = publish.communicate()
            self.assertEqual(publish.returncode, 0, err)
            self.assertEqual(self.hashes(services), self.undisturbed)
        subprocess.run([default_bin_dir() / "voxatlas", "store", "verify", "--data-dir", folder],
                       check=True, stdin=subprocess.DEVNULL)

    def test_a_full_disk_is_said_and_waited_for_and_nothing_is_lost(self):
        disk = self.folder / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_MIB}m", "tmpfs", disk],
                       check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", disk], check=True)

        def fill():
            with open(disk / "ballast", "wb", buffering=0) as ballast:
                try:
                    while True:
                        ballast.write(bytes(1 << 12))
                except OSError as full:
                    self.assertEqual(full.errno, 28)

        self.publish_through(disk, fill, "no room on disk", (disk / "ballast").unlink)

    def test_a_disk_that_refuses_writes_is_said_and_waited_for_and_nothing_is_lost(self):
        if disks.missing():
            self.skipTest("no disk that can fail: " + disks.missing())
        disk = disks.FailingDisk(self.folder)
        self.addCleanup(disk.down)
        disk.up()
        self.publish_through(disk.mount / "model", disk.fail, "the disk fails", disk.mend, before=5)


if __name__ == "__main__":
    harness.main()
