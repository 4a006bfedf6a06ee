#!/usr/bin/env python3
"""`voxatlas store` on a real model, running and at rest: the same hashes whatever is done to it."""

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
            stdin=subprocess.DEVNULL, env=self.env)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout if code == 0 else done.stderr

    def hashes(self, data_dir=None):
        file = self.folder / "hashes"
        self.store("stat", "--hashes", file, data_dir=data_dir)
        return sorted(file.read_text().splitlines())

    def setUp(self):
        super().setUp()
        self.model = self.folder / "model"
        self.env = None  # Where the bus is, while a set runs.

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
            self.assertIn("stop the set of services first", self.store("compact", code=1))
            self.assertIn("stop the set of services first", self.store("reshard", 3, code=1))

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


    def test_a_running_model_is_looked_at_and_copied_in_the_middle_of_a_publish(self):
        copy = self.folder / "copy"

        def copy_in_the_middle(services):
            self.env = services.env()
            watch = services.begin("watch", "tiles", stdout=subprocess.PIPE, text=True)
            self.addCleanup(watch.communicate)
            self.addCleanup(watch.kill)
            publish = services.begin("publish", "--simulate", 100, "--hz", 20, stderr=subprocess.PIPE,
                                     stdout=subprocess.PIPE, text=True)
            self.addCleanup(publish.communicate)
            self.addCleanup(publish.kill)
            for _ in range(200):
                watch.stdout.readline()
            watch.kill()
            self.store("checkpoint", copy)
            self.assertIn("shard 1: sound", self.store("verify"))
            shards = [json.loads(line) for line in self.store("stat", "--json").splitlines()]
            self.assertIsNone(publish.poll(), "the publish was over before the copies")
            self.assertGreater(sum(shard["tiles"] for shard in shards), 0)
            self.assertEqual(list(self.model.glob("checkpoint-*")), [])
            self.assertEqual(list(self.model.glob("looked-at-*")), [])
            _, err = publish.communicate()
            self.assertEqual(publish.returncode, 0, err)

        whole = self.run_set(2, copy_in_the_middle)
        self.assertIn("shard 0: sound", self.store("verify", data_dir=copy))
        self.assertNotEqual(self.hashes(copy), whole)
        # It opens as a model that knows where it stands: the rest of the scans makes it whole.
        self.model = copy
        again = self.run_set(2, lambda services: services.run("publish", "--simulate", 100,
                                                              quiet=True))
        self.assertEqual(again, whole)


if __name__ == "__main__":
    harness.main()
