#!/usr/bin/env python3
"""Ctrl-C, wherever it comes, leaves nothing: no process, mount, namespace, route, half a model."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import uuid

from support import harness

from service_set import ServiceSet, default_bin_dir

DEMO = harness.SCRIPTS / "lib" / "demo.py"
MARK = "VOX_INTERRUPT_TEST"
# Words of the demo after which Ctrl-C comes: before the first service, at the beginning and in the
# middle of a publish, between two pictures.
MOMENTS = ["", "ready on", "durable", "drawn"]


def processes_with(mark):
    """Every process that inherited the mark, by its command."""
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (folder / "environ").read_bytes():
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
        except OSError:
            continue  # It ended as we looked.
    return found


def of_the_machine():
    """What a program could leave behind beside files: mounts, and routes of this namespace."""
    routes = subprocess.run(["ip", "route", "show", "table", "all"], capture_output=True,
                            check=True, text=True).stdout
    mounts = pathlib.Path("/proc/self/mounts").read_text(encoding="utf-8")
    return sorted(routes.splitlines()), sorted(mounts.splitlines())


class Interrupt(harness.SystemTest):
    def setUp(self):
        super().setUp()
        self.mark = f"{MARK}={uuid.uuid4()}"
        self.before = of_the_machine()

    def start(self, *command):
        """As a shell starts a job: a process group of its own, which a Ctrl-C reaches as a whole."""
        name, value = self.mark.split("=")
        process = subprocess.Popen(list(map(str, command)), env={**os.environ, name: value},
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   start_new_session=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        return process

    def interrupt_after(self, process, words):
        said = []
        while words and words not in (said or [""])[-1]:
            line = process.stdout.readline()
            self.assertTrue(line, f"ended before {words!r}: {said}")
            said.append(line)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        said += process.communicate()[0].splitlines(keepends=True)
        return "".join(said)

    def assert_nothing_is_left(self, said):
        self.assertEqual(processes_with(self.mark), [], said)
        self.assertEqual(of_the_machine(), self.before, said)

    def test_a_demo_leaves_nothing_wherever_it_is_interrupted(self):
        for moment in MOMENTS:
            with self.subTest(moment):
                out = self.folder / f"out-{moment or 'start'}"
                process = self.start(harness.SCRIPTS / "in_namespace", sys.executable, "-B", DEMO,
                                     "--scans", 12, "--size", "320x180", "--out", out)
                said = self.interrupt_after(process, moment)
                self.assertNotEqual(process.returncode, 0, said)
                self.assertNotIn("Traceback", said if moment else "")
                self.assert_nothing_is_left(said)
                self.assertEqual(list(out.glob("model-*")) if out.exists() else [], [])

    def test_a_rewrite_of_a_model_that_is_interrupted_leaves_the_old_or_the_new_whole(self):
        data = self.folder / "data"
        with ServiceSet(data) as services:
            services.run("publish", "--simulate", 4, quiet=True)
        hashes = self.hashes(data)
        for seen in ("data", "data.partial", "data.partial/shard-1"):
            process = self.start(default_bin_dir() / "voxatlas", "store", "reshard", 2,
                                 "--data-dir", data)
            while not (self.folder / seen).exists() and process.poll() is None:
                continue
            with self.subTest(seen):
                said = self.interrupt_after(process, "")
                self.assert_nothing_is_left(said)
                self.assertEqual(list(self.folder.glob("*.partial")), [], said)
                self.assertEqual(self.hashes(data), hashes, said)
            for kept in self.folder.glob("data.before-reshard"):
                shutil.rmtree(kept)

    def hashes(self, data):
        file = self.folder / "hashes"
        subprocess.run([default_bin_dir() / "voxatlas", "store", "stat", "--data-dir", data,
                        "--hashes", file], check=True, stdout=subprocess.DEVNULL)
        return sorted(file.read_text().splitlines())


if __name__ == "__main__":
    harness.main()
