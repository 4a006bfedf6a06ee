#!/usr/bin/env python3
"""`voxatlas watch tiles --follow`: a copy of the model from a snapshot and updates that may be lost."""

import json
import os
import signal
import subprocess
import time
import unittest

from support import harness

from service_set import ServiceSet

PATIENCE_SECONDS = 60
# After the last change; 2 s is promised, the rest is for a machine that has other things to do.
IN_STEP_SECONDS = 10
TILE_METRES, HALF_CUBE_METRES = 12.8, 6_400_000


def index_of(key):
    """A tile's index on each axis: its Morton code, bit by bit."""
    return tuple(sum((key >> (3 * bit + axis) & 1) << bit for bit in range(20)) for axis in range(3))


def lines_of(file):
    return sorted(file.read_text().splitlines()) if file.exists() else []


class Loss:
    """`with Loss(5):` so many of a hundred datagrams never arrive."""

    def __init__(self, percent):
        self.rules = ("add table inet loss\n"
                      "add chain inet loss in { type filter hook input priority 0; }\n"
                      f"add rule inet loss in meta l4proto udp numgen random mod 100 < {percent} drop\n")

    def __enter__(self):
        subprocess.run(["nft", "-f", "-"], input=self.rules, text=True, check=True)

    def __exit__(self, *_):
        subprocess.run(["nft", "delete", "table", "inet", "loss"], check=True)


class Subscriber(harness.SystemTest):
    def follow(self, services, name, *options):
        """A follower; its copy's hashes are in the file that is returned, its words in NAME.json."""
        file = self.folder / f"{name}.txt"
        with open(self.folder / f"{name}.json", "wb") as words:
            process = services.begin("watch", "tiles", "--follow", "--json", "--hashes", file,
                                     *options, stdout=words)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, file

    def words(self, name):
        return [json.loads(line) for line in (self.folder / f"{name}.json").read_text().splitlines()]

    def stored(self, services):
        file = self.folder / "stored.txt"
        services.run("stat", "--hashes", file, quiet=True)
        return lines_of(file)

    def wait_until(self, fact, what, seconds=PATIENCE_SECONDS):
        end = time.monotonic() + seconds
        while not fact():
            if time.monotonic() > end:
                self.fail(f"{what}: not within {seconds} s")
            time.sleep(0.02)

    def publish(self, services, seed, scans=4):
        services.run("publish", "--simulate", scans, "--seed", seed, quiet=True)

    def box_about(self, lines):
        """A box within what is stored, in ECEF, as --box wants it, and the tiles it touches."""
        indexes = sorted(index_of(int(line.split()[0], 16)) for line in lines)
        middle = indexes[len(indexes) // 2]
        low, high = [i - 1 for i in middle], [i + 1 for i in middle]
        corner = [(i + 0.5) * TILE_METRES - HALF_CUBE_METRES for i in high + low]
        holds = lambda line: all(a <= i <= b for a, i, b in zip(
            low, index_of(int(line.split()[0], 16)), high))
        return ",".join(map(str, corner)), holds

    @unittest.skipUnless(harness.multicast_here(), "no network namespace of its own")
    def test_late_joiners_have_the_stores_hashes_also_when_datagrams_are_lost(self):
        with ServiceSet(self.folder / "data", stores=2, renders=0, compressors=0) as services:
            self.publish(services, 1)
            box, holds = self.box_about(self.stored(services))
            _, all_tiles = self.follow(services, "all")
            _, in_box = self.follow(services, "box", "--box", box)
            _, coarse = self.follow(services, "coarse", "--depth", 4)
            self.wait_until(lambda: lines_of(all_tiles) == self.stored(services), "the snapshot")
            with Loss(5):
                self.publish(services, 2)
                published = time.monotonic()
                stored = self.stored(services)
                self.wait_until(lambda: lines_of(all_tiles) == stored, "the copy in step",
                                IN_STEP_SECONDS)
                took = time.monotonic() - published
                self.wait_until(lambda: lines_of(in_box) == list(filter(holds, stored)),
                                "the copy of the box", IN_STEP_SECONDS)
            print(f"in step within {took:.2f} s of quiet", flush=True)
            self.assertLess(0, len(lines_of(in_box)))
            self.assertLess(len(lines_of(in_box)), len(stored))
            last = self.words("all")[-1]
            self.assertGreater(last["applied"], 0)
            self.assertGreater(last["fetched"], len(stored) // 2)
            # At a depth of its own: what one who comes now gets at that depth.
            _, fresh = self.follow(services, "fresh", "--depth", 4, "--quiet", "0.1")
            self.wait_until(lambda: fresh.exists() and lines_of(coarse) == lines_of(fresh),
                            "the coarse copy")
            self.assertEqual([line.split()[:2] for line in lines_of(fresh)],
                             [line.split()[:2] for line in stored])
            self.assertNotEqual(lines_of(fresh), stored)

    def stop_some_and_publish(self, **options):
        with ServiceSet(self.folder / "data", renders=0, compressors=0, **options) as services:
            follower, copy = self.follow(services, "copy")
            self.publish(services, 1, 1)
            self.wait_until(copy.exists, "the first copy")
            watcher = services.begin("watch", "tiles", stdout=subprocess.DEVNULL)
            self.addCleanup(watcher.wait)
            self.addCleanup(watcher.kill)
            for process in (follower, watcher):
                os.kill(process.pid, signal.SIGSTOP)
            self.publish(services, 2)  # Ends when all is durable: nobody waited for them.
            stored = self.stored(services)
            self.assertNotEqual(lines_of(copy), stored)
            os.kill(follower.pid, signal.SIGCONT)
            self.wait_until(lambda: lines_of(copy) == stored, "the copy of one that was stopped")

    def test_subscribers_that_stand_still_hold_nobody_back(self):
        self.stop_some_and_publish()

    def test_nor_do_they_at_the_hub(self):
        self.stop_some_and_publish(hub=True)


if __name__ == "__main__":
    harness.main()
