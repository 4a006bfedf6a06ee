#!/usr/bin/env python3
"""Pictures of a running model: by stream and broadcast, single, in steps, along paths, from two
renderers of which one dies."""

import json
import re
import struct
import zlib

from support import harness

from service_set import ServiceSet, SetError

SIZE = "320x180"


def png_size(file):
    head = file.read_bytes()[:24]
    assert head.startswith(b"\x89PNG\r\n\x1a\n"), head
    return struct.unpack(">II", head[16:24])


def variety(file):
    """How many different bytes an 8-bit RGB PNG holds: a picture of nothing has few."""
    data, at, body = file.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            body += data[at + 8:at + 8 + length]
        at += 12 + length
    return len(set(zlib.decompress(body)))


class Render(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        cls.shared = harness.temporary_folder(cls)
        cls.services = ServiceSet(cls.shared / "data", renders=2)
        cls.enterClassContext(cls.services)
        cls.services.run("publish", "--simulate", 3, quiet=True)

    def render(self, *options, size=SIZE):
        out = self.services.run("render", "--size", size, "--json", *options, quiet=True)
        return [json.loads(line) for line in out.splitlines()]

    def watched(self, *options):
        """What one frame makes `watch frames` print. A broadcast is for those who listen already:
        it is sent again until the watcher has heard one."""
        printed = self.folder / "watched.txt"
        with open(printed, "wb") as out:  # Not a pipe: nobody would read it meanwhile.
            watcher = self.services.begin("watch", "frames", "--count", 1, "--timeout", 120,
                                          *options, stdout=out)
        self.addCleanup(watcher.wait)
        self.addCleanup(watcher.kill)
        while watcher.poll() is None:
            self.render("--view", "oblique", "--broadcast", "--out", self.folder / "b.jpg")
        return printed.read_text(encoding="utf-8")

    def test_a_picture_says_what_it_shows(self):
        (said,) = self.render("--view", "oblique", "--out", self.folder / "a.png")
        self.assertEqual(png_size(self.folder / "a.png"), (320, 180))
        self.assertGreater(variety(self.folder / "a.png"), 50)
        self.assertEqual(said["tiles_missing"], 0)
        self.assertGreater(said["tiles"], 10)
        self.assertEqual(said["depth"], 7)

    def test_files_of_all_kinds(self):
        for name, length in (("raw.raw", 320 * 180 * 3), ("jpeg.jpg", None)):
            self.render("--view", "street", "--out", self.folder / name)
            if length:
                self.assertEqual((self.folder / name).stat().st_size, length)
        self.assertTrue((self.folder / "jpeg.jpg").read_bytes().startswith(b"\xff\xd8"))
        for name, bytes_a_pixel in (("d.u16", 2), ("d.f32", 4)):
            self.render("--out", self.folder / "d.png", "--depth-image", self.folder / name)
            self.assertEqual((self.folder / name).stat().st_size, 320 * 180 * bytes_a_pixel)

    def test_a_map_an_orbit_and_a_path(self):
        self.render("--map", 100, "--out", self.folder / "map.png")
        self.assertGreater(variety(self.folder / "map.png"), 50)
        orbit = self.render("--orbit", 5, "--out", self.folder / "orbit")
        self.assertEqual([frame["place"] for frame in orbit], list(range(5)))
        self.assertEqual(sorted(file.name for file in (self.folder / "orbit").iterdir()),
                         [f"frame_{i:06}.png" for i in range(5)])
        pictures = {file.read_bytes() for file in (self.folder / "orbit").iterdir()}
        self.assertEqual(len(pictures), 5)
        path = self.folder / "path.txt"
        path.write_text("0 48.1,11.5,600 48.1001,11.5,500\n1 48.1,11.5,620 48.1001,11.5,500\n")
        walked = self.render("--path", path, "--rate", 4, "--out", self.folder / "path")
        self.assertEqual(len(walked), 5)

    def test_within_a_budget_the_last_picture_is_supersampled(self):
        (said,) = self.render("--view", "oblique", "--budget", 5, "--out", self.folder / "a.png")
        self.assertEqual(said["samples"], 4)
        self.assertGreater(said["sequence"], 0)

    def test_watching_frames_as_files_lines_and_blocks(self):
        frame = json.loads(self.watched("--json", "--out", self.folder / "kept"))
        self.assertEqual((frame["final"], frame["last"], frame["error"]), (1, 1, ""))
        kept = (self.folder / "kept" / "frame_000000.jpg").read_bytes()
        self.assertEqual(len(kept), frame["bytes"])
        text = self.watched("--blocks")
        self.assertEqual(len(re.findall("\u2580", text)), 80 * 23)

    def test_what_cannot_be_is_refused_by_name(self):
        for options, size, word in ((["--colouring", "plaid"], SIZE, "plaid"),
                                    (["--at", "48,11,500"], "0x180", "0 x 180"),
                                    (["--at", "48,11,500"], "100000x9", "100000"),
                                    (["--at", "48,11,500", "--look-at", "48,11,500"], SIZE,
                                     "same point"),
                                    (["--at", "nan,11,500"], SIZE, "nan")):
            with self.assertRaises(SetError) as refused:
                self.render(*options, "--out", self.folder / "no.png", size=size)
            self.assertIn(word, str(refused.exception))
        (inside,) = self.render("--at", "48,11,-3000000", "--out", self.folder / "inside.png")
        self.assertEqual(inside["tiles"], 0)

    def test_z_one_renderer_answers_and_the_other_when_it_has_died(self):
        answered = set()
        for _ in range(24):  # Each command is another client.
            (said,) = self.render("--out", self.folder / "a.png")
            answered.add(said["renderer"])
            if len(answered) == 2:
                break
        self.assertEqual(answered, {0, 1})
        dying = self.services.find("render", 0)
        dying.kill()
        self.services.services.remove(dying)
        for _ in range(6):
            (said,) = self.render("--out", self.folder / "a.png")
            self.assertEqual(said["renderer"], 1)


if __name__ == "__main__":
    harness.main()
