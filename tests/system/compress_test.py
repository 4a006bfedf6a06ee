#!/usr/bin/env python3
"""Compressors on real models: killed at random nothing is lost and everything gets encoded; a lossy
policy makes versions that live on.

With --long: also one that is stopped in the middle, whose tiles another gets.
"""

import json
import os
import random
import signal
import subprocess
import sys
import unittest

from support import harness

from service_set import ServiceSet, default_bin_dir

LONG = "--long" in sys.argv
SEED = int(os.environ.get("VOX_SEED") or random.randrange(1 << 30))
SCANS, STORES, KILLS = 10, 2, 8
# Tiles of any size, at once, whoever else is busy.
STORE_OPTIONS = ["--rest-seconds", 0, "--rest-bytes", 0]
COMPRESS_OPTIONS = ["--max-load", 1]


def lines_of(folder, command, *arguments):
    done = subprocess.run([default_bin_dir() / "voxatlas", "store", command, "--data-dir", folder,
                           *arguments], check=True, capture_output=True, text=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


class Compress(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        cls.drive = harness.temporary_folder(cls)
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(SCANS), "--out", cls.drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)

    def new_set(self, name, compressors, policy="lossless"):
        return ServiceSet(self.folder / name, stores=STORES, compressors=compressors, renders=0,
                          store_options=STORE_OPTIONS,
                          compress_options=[*COMPRESS_OPTIONS, "--policy", policy])

    def publish(self, services, *options):
        services.run("publish", self.drive, "--poses", "poses.txt", *options, quiet=True)

    def statuses(self, services, service):
        """(index, counters) of each status of one kind of service, for as long as they are read."""
        watch = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
        self.addCleanup(watch.communicate)
        self.addCleanup(watch.kill)
        for line in watch.stdout:
            status = json.loads(line)
            if status["service"] == service:
                yield status["index"], status["counters"]

    def until_all_is_encoded(self, services, between=lambda counters: None):
        """Returns each store's counters once no tile rests, is out, or is still to be written."""
        at_rest = {}
        for shard, counters in self.statuses(services, "tilestore"):
            between(counters)
            open_tiles = (counters["resting_tiles"] + counters["out_to_compress"] +
                          counters["dirty_tiles"] + counters["scans_waiting"])
            if open_tiles == 0:
                at_rest[shard] = counters
            else:
                at_rest.pop(shard, None)
            if len(at_rest) == STORES:
                return list(at_rest.values())
        self.fail("the statuses have ended")

    def hashes(self, services):
        file = self.folder / "hashes"
        services.run("stat", "--hashes", file, quiet=True)
        return sorted(file.read_text().splitlines())

    def stat(self, services):
        return json.loads(services.run("stat", "--json", quiet=True))

    def undisturbed(self):
        with self.new_set("undisturbed", 0) as services:
            self.publish(services)
            return self.hashes(services), self.stat(services)

    def test_compressors_killed_at_random_lose_nothing_and_all_is_encoded_in_the_end(self):
        expected, _ = self.undisturbed()
        rng = random.Random(SEED)
        kills = 0
        with self.new_set("killed", 2) as services:
            publish = services.begin("publish", self.drive, "--poses", "poses.txt",
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(publish.wait)
            self.addCleanup(publish.kill)

            def kill_one(counters):
                nonlocal kills
                if kills == KILLS or counters["handed_to_compress"] == 0:
                    return
                victim = services.find("compress", rng.randrange(2))
                victim.kill()
                victim.start(services.ended)
                kills += 1

            for _, counters in self.statuses(services, "tilestore"):
                kill_one(counters)
                if publish.poll() is not None and kills == KILLS:
                    break
            self.assertEqual(publish.returncode, 0)
            stores = self.until_all_is_encoded(services)
            self.assertGreater(sum(store["encoded_taken"] for store in stores), 0)
            self.assertEqual(sum(store["encoded_wrong"] for store in stores), 0)
            self.assertEqual(self.hashes(services), expected, f"VOX_SEED={SEED}")
        shards = lines_of(self.folder / "killed", "stat", "--json")
        self.assertEqual(sum(shard["fast"] for shard in shards), 0, shards)
        self.assertEqual(sum(shard["dense"] for shard in shards), len(expected), shards)
        raw = lines_of(self.folder / "undisturbed", "stat", "--json")
        size = {name: sum(shard["tile_bytes"] for shard in rows)
                for name, rows in (("dense", shards), ("fast", raw))}
        self.assertLess(size["dense"], 0.8 * size["fast"])

    def test_a_lossy_policy_makes_versions_that_keep_every_voxel_and_live_on(self):
        exact, exact_stat = self.undisturbed()
        with self.new_set("lossy", 1, "lossy:4") as services:
            self.publish(services)
            stores = self.until_all_is_encoded(services)
            self.assertGreater(sum(store["encoded_lossy"] for store in stores), 0)
            coarse, stat = self.hashes(services), self.stat(services)
            self.assertNotEqual(coarse, exact)
            for what in ("tiles", "occupied_voxels", "free_voxels"):
                self.assertEqual(stat[what], exact_stat[what], what)
            for _, counters in self.statuses(services, "compress"):
                if counters["queue"] == 0 and counters["results_open"] == 0:
                    break
            self.assertEqual(round(counters["bytes_out"] / counters["bytes_in"], 3),
                             round(counters["ratio"], 3))
            self.assertLess(counters["ratio"], 0.8)
        shards = lines_of(self.folder / "lossy", "stat", "--json")
        self.assertGreater(sum(shard["lossy"] for shard in shards), 0)
        self.assertEqual(sum(shard["fast"] for shard in shards), 0)
        with self.new_set("lossy", 0) as services:  # Durable, and more scans can come.
            self.assertEqual(self.hashes(services), coarse)
            self.publish(services, "--session", 2)
            self.assertNotEqual(self.hashes(services), coarse)

    @unittest.skipUnless(LONG, "--long only")
    def test_the_tiles_of_a_compressor_that_stands_still_go_to_another(self):
        expected, _ = self.undisturbed()
        with self.new_set("stopped", 2) as services:
            still = services.find("compress", 0)
            publish = services.begin("publish", self.drive, "--poses", "poses.txt",
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(publish.wait)
            for _, counters in self.statuses(services, "tilestore"):
                if counters["handed_to_compress"] > 0:
                    break
            still.signal(signal.SIGSTOP)
            self.addCleanup(still.signal, signal.SIGCONT)
            publish.wait()
            stores = self.until_all_is_encoded(services)
            print("handed again:", sum(store["handed_again"] for store in stores))
            still.signal(signal.SIGCONT)
            for index, counters in self.statuses(services, "compress"):
                if index == 0 and counters["queue"] == 0 and counters["results_open"] == 0:
                    break
            self.assertEqual(self.hashes(services), expected)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
