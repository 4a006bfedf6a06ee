#!/usr/bin/env python3
"""A full disk, for real: the store stops accepting, says so, loses nothing, and goes on with room."""

import ctypes
import json
import os
import subprocess
import unittest

from support import harness

from service_set import ServiceSet, default_bin_dir

SCANS = 40
DISK_MIB = 192
CLONE_NEWNS = 0x00020000


def own_mounts():
    """What this process mounts from now on, nobody else sees, and it goes with the process."""
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNS) != 0:
        raise unittest.SkipTest("no mount namespace: " + os.strerror(ctypes.get_errno()))
    subprocess.run(["mount", "--make-rprivate", "/"], check=True)


@unittest.skipUnless(os.geteuid() == 0, "mounting a small disk takes root")
class FullDisk(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        own_mounts()
        cls.drive = harness.temporary_folder(cls)
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(SCANS), "--out", cls.drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)
        with ServiceSet(harness.temporary_folder(cls), renders=0) as services:
            cls.undisturbed = cls.publish_and_hash(services)

    @classmethod
    def publish_and_hash(cls, services):
        services.run("publish", cls.drive, "--poses", "poses.txt", quiet=True)
        return cls.hashes(services)

    @staticmethod
    def hashes(services):
        file = services.data_dir / "hashes.txt"
        services.run("stat", "--hashes", file, quiet=True)
        return sorted(file.read_text().splitlines())

    def setUp(self):
        super().setUp()
        self.disk = self.folder / "disk"
        self.disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_MIB}m", "tmpfs", self.disk],
                       check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", self.disk], check=True)

    def fill_disk(self):
        with open(self.disk / "ballast", "wb", buffering=0) as ballast:
            try:
                while True:
                    ballast.write(bytes(1 << 12))
            except OSError as full:
                self.assertEqual(full.errno, 28)

    def begin(self, services, *arguments):
        process = services.begin(*arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def test_a_full_disk_is_said_and_waited_for_and_nothing_is_lost(self):
        with ServiceSet(self.disk, renders=0, store_options=["--journal-mb", 1]) as services:
            watch = self.begin(services, "watch", "status", "--json")
            self.fill_disk()
            publish = self.begin(services, "publish", self.drive, "--poses", "poses.txt")
            for line in watch.stdout:
                status = json.loads(line)
                self.assertIsNone(publish.poll(), "the publish ended before the disk was full")
                if status["service"] == "tilestore" and "no room" in status["state"]:
                    break
            services.check_alive()
            (self.disk / "ballast").unlink()
            _, err = publish.communicate()
            self.assertEqual(publish.returncode, 0, err)
            self.assertEqual(self.hashes(services), self.undisturbed)
        subprocess.run([default_bin_dir() / "voxatlas", "store", "verify", "--data-dir", self.disk],
                       check=True, stdin=subprocess.DEVNULL)


if __name__ == "__main__":
    harness.main()
