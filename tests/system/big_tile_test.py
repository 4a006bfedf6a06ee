#!/usr/bin/env python3
"""A tile of 4096 mixed bricks, whose updates fit no datagram, published on a bus that loses some."""

import json
import os
import random
import struct
import subprocess
import unittest

from support import harness, wire_faults
from support.publishing import PublishTest, tile_hashes

from service_set import ServiceSet

SCANS, POINTS = 4, 120_000
TILE_METRES = 12.8
MOST_IN_A_DATAGRAM = 59_000
# The lower corner of a tile on the equator, in ECEF: a whole number of tiles from the cube's corner.
CORNER = (round((6_378_160 + 6_400_000) / TILE_METRES) * TILE_METRES - 6_400_000, 0.0, 0.0)
STAND_BACK = 20.0  # Metres from the tile's near face to the sensor.


def scan_of_a_whole_tile(rng):
    """Points anywhere in the tile: about 29 in each brick of 8 x 8 x 8 voxels."""
    points = bytearray()
    for _ in range(POINTS):
        points += struct.pack("<4f", STAND_BACK + TILE_METRES * rng.random(),
                              TILE_METRES * (rng.random() - 0.5),
                              TILE_METRES * (rng.random() - 0.5), 0.0)
    return points


def drive_of_one_tile(folder):
    rng = random.Random(1)
    (folder / "velodyne").mkdir()
    for i in range(SCANS):
        (folder / "velodyne" / f"{i:06}.bin").write_bytes(scan_of_a_whole_tile(rng))
    (folder / "times.txt").write_text("".join(f"{1e9 + i:.1f}\n" for i in range(SCANS)))
    x, y, z = (CORNER[0] - STAND_BACK, CORNER[1] + TILE_METRES / 2, CORNER[2] + TILE_METRES / 2)
    (folder / "poses.txt").write_text(f"1 0 0 {x!r} 0 1 0 {y!r} 0 0 1 {z!r}\n" * SCANS)
    return folder


@unittest.skipUnless(harness.multicast_here() and os.geteuid() == 0,
                     "no network namespace of its own: no nftables")
class BigTile(PublishTest):
    SET = {"stores": 1, "renders": 1}

    @classmethod
    def make_drive(cls):
        return drive_of_one_tile(harness.temporary_folder(cls))

    def test_it_arrives_is_announced_without_its_bytes_and_is_fetched_whole(self):
        with ServiceSet(self.folder, **self.SET) as services:
            watch = services.begin("watch", "tiles", "--json", stdout=subprocess.PIPE, text=True)
            self.addCleanup(watch.communicate)
            self.addCleanup(watch.kill)
            with wire_faults.drop(5) as lost:
                services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertGreater(lost.packets, 0)
            found = tile_hashes(services)
            self.assertEqual(found, self.undisturbed)
            update = self.first_without_bytes(watch.stdout)
            self.assertIn(update["tile"], {line.split()[0] for line in found})
            self.assert_fetched_whole(services)

    def first_without_bytes(self, lines):
        for line in lines:
            update = json.loads(line)
            if update["content"] == 0:
                self.assertEqual(update["bytes"], 0)
                return update
        return self.fail("no update without its bytes")

    def assert_fetched_whole(self, services):
        stat = json.loads(services.run("stat", "--json"))
        self.assertGreater(stat["encoded_bytes"], MOST_IN_A_DATAGRAM)
        self.assertGreater(stat["leaves"], 8 * 4096)  # No brick is of one value.
        picture = self.folder / "tile.png"
        said = json.loads(services.run("render", "--view", "oblique", "--json",
                                       "--out", picture, quiet=True))
        self.assertGreater(said["tiles"], 0)
        self.assertEqual(said["tiles_missing"], 0)
        self.assertGreater(said["cells"], 100_000)


if __name__ == "__main__":
    harness.main()
