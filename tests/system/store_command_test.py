#!/usr/bin/env python3
"""`voxatlas store` on a real model: refused while it runs, the same hashes whatever is done to it."""

import json
import subprocess

from support import harness

from service_set import ServiceSet, default_bin_dir

SCANS = 6


class StoreCommand(harness.SystemTest):
    def store(self, command, *arguments, data_dir=None, code=0):
        done = subprocess.run(
            [default_bin_dir() / "voxatlas", "store", command, *map(str, arguments), "--data-dir",
             data_dir or self.model], capture_output=True, text=True, check=False,
            stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout if code == 0 else done.stderr

    def hashes(self, data_dir=None):
        file = self.folder / "hashes"
        self.store("stat", "--hashes", file, data_dir=data_dir)
        return sorted(file.read_text().splitlines())

    def setUp(self):
        super().setUp()
        self.model = self.folder / "model"

    def run_set(self, stores, work):
        with ServiceSet(self.model, stores=stores, renders=0) as services:
            work(services)
            file = self.folder / "online"
            services.run("stat", "--hashes", file, quiet=True)
            return sorted(file.read_text().splitlines())

    def publish(self, services):
        services.run("publish", "--simulate", SCANS, quiet=True)

    def test_a_models_life(self):
        def publish_and_try(services):
            self.publish(services)
            for command in ("verify", "stat", "compact"):
                self.assertIn("stop the set of services first", self.store(command, code=1))

        online = self.run_set(2, publish_and_try)
        self.assertEqual(self.hashes(), online)
        marks = self.folder / "marks"
        self.store("stat", "--marks", marks)
        rows = [line.split(" ", 3) for line in marks.read_text().splitlines()]
        self.assertEqual([row[:2] for row in rows], [["0", str(SCANS - 1)], ["1", str(SCANS - 1)]])
        self.assertEqual(rows[0][2:], rows[1][2:])
        self.assertIn("shard 1: sound", self.store("verify"))

        copy = self.folder / "copy"
        self.store("checkpoint", copy)
        self.store("compact")
        self.store("reshard", 3)
        self.assertEqual(self.hashes(), online)
        shards = [json.loads(line) for line in self.store("stat", "--json").splitlines()]
        self.assertEqual(sum(shard["tiles"] for shard in shards), len(online))
        self.assertEqual(len(shards), 3)

        # The marks came along: what was published before is not added again.
        self.assertEqual(self.run_set(3, self.publish), online)
        self.assertEqual(self.hashes(copy), online)
        self.assertIn("count twice", self.store("merge", copy, code=1))


if __name__ == "__main__":
    harness.main()
