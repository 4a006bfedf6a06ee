#!/usr/bin/env python3
"""FORMAT.md is enough to read every tile: a second decoder, written from it, gives the same hashes."""

import pathlib
import re
import unittest

import tile_reader

ROOT = pathlib.Path(__file__).resolve().parents[3]
GOLDEN = ROOT / "tests" / "data" / "codec"
FORMAT = ROOT / "libs" / "codec" / "FORMAT.md"


class Format(unittest.TestCase):
    def test_every_golden_tile_is_read_as_the_program_reads_it(self):
        lines = [line.split() for line in (GOLDEN / "hashes.txt").read_text().splitlines()]
        self.assertEqual(sorted(name for _, name in lines),
                         sorted(file.name for file in GOLDEN.glob("*.tile")))
        for digest, name in lines:
            with self.subTest(name):
                tile = tile_reader.read_tile((GOLDEN / name).read_bytes())
                self.assertEqual(tile.hash(), digest)

    def test_the_worked_examples_stand_in_the_text_byte_for_byte(self):
        hexes = re.sub(r"\s", "", "".join(
            re.match(r"    ((?:[0-9a-f]{2} {1,2})+)", line + "  ").group(1)
            for line in FORMAT.read_text(encoding="utf-8").splitlines()
            if re.match(r"    (?:[0-9a-f]{2} {1,2})+", line + "  ")))
        for name in ("example_fast_v2.tile", "example_dense_v2.tile"):
            with self.subTest(name):
                self.assertIn((GOLDEN / name).read_bytes().hex(), hexes)

    def test_a_flipped_bit_is_found(self):
        tile = bytearray((GOLDEN / "example_dense_v2.tile").read_bytes())
        tile[-1] ^= 1
        with self.assertRaises(tile_reader.Corrupt):
            tile_reader.read_tile(bytes(tile))


if __name__ == "__main__":
    unittest.main()
