#!/usr/bin/env python3
"""The main job in small: scripts/demo's own way, over a short simulated drive."""

import json
import os
import subprocess
import sys

from support import harness

from service_set import ServiceSet

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class Pipeline(harness.SystemTest):
    def demo(self, *options):
        out = self.folder / "out"
        done = subprocess.run(
            [sys.executable, "-B", harness.SCRIPTS / "lib" / "demo.py", "--scans", "3", "--size",
             "320x180", "--cache-mb", "128", "--out", out, "--json", self.folder / "figures.json",
             *options], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return out, json.loads((self.folder / "figures.json").read_text())

    def check(self, out, figures):
        self.assertEqual(figures["lost"], [])
        self.assertEqual(figures["published"]["scans"], 3)
        self.assertGreater(figures["model"]["occupied_voxels"], 10_000)
        for view in ("street", "oblique"):
            picture = (out / f"{view}.png").read_bytes()
            self.assertTrue(picture.startswith(PNG_SIGNATURE))
            self.assertEqual(picture[16:24], (320).to_bytes(4, "big") + (180).to_bytes(4, "big"))

    def test_scans_come_in_and_pictures_out_and_nothing_is_lost(self):
        self.check(*self.demo())

    def test_two_stores_and_two_ingests_do_the_same(self):
        self.check(*self.demo("--stores", "2", "--ingest", "2"))

    def test_pictures_come_before_the_store_that_before_ingest_and_compressing_is_last(self):
        with ServiceSet(self.folder / "model") as services:
            nice = {}
            for service in services.services:
                pid = service.process.pid
                self.assertEqual(os.getsid(pid), os.getsid(0))  # Else autogroups decide.
                self.assertEqual(os.getpgid(pid), pid)  # Ctrl-C is for who started the set.
                for thread in os.listdir(f"/proc/{pid}/task"):
                    nice.setdefault(service.kind, set()).add(
                        os.getpriority(os.PRIO_PROCESS, int(thread)))
        own = os.getpriority(os.PRIO_PROCESS, 0)
        for kind, lower in (("render", 0), ("tilestore", 4), ("ingest", 7), ("compress", 19)):
            self.assertEqual(nice[kind], {min(own + lower, 19)}, kind)


if __name__ == "__main__":
    harness.main()
