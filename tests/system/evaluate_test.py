#!/usr/bin/env python3
"""The evaluation at 20 scans: every section measures, the report shows it, and what is known holds."""

import html.parser
import json
import pathlib
import re
import subprocess
import sys

from support import harness

PROGRAM = harness.ROOT / "tests" / "evaluation" / "evaluate.py"
SCANS = 20
MODES = ("surface", "free80", "sampled80", "carve10")


class Links(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.files = []

    def handle_starttag(self, tag, attributes):
        self.files += [value for name, value in attributes if tag == "img" and name == "src"]


class Evaluation(harness.SystemTest):
    def evaluate(self, *arguments):
        return subprocess.run([sys.executable, "-B", PROGRAM, *map(str, arguments)], check=False,
                              text=True, capture_output=True, stdin=subprocess.DEVNULL)

    def values(self, section):
        file = self.folder / "out" / "measured" / f"{section}.json"
        return json.loads(file.read_text())["values"]

    def test_every_section_measures_and_what_is_known_holds(self):
        done = self.evaluate("--scans", SCANS, "--out", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print(done.stdout)
        self.check_report()
        self.check_arithmetic()
        self.check_drive()
        # Again in part: one section is measured, the others stay in the report.
        before = (self.folder / "out" / "evaluation.md").read_text()
        done = self.evaluate("--scans", SCANS, "--out", self.folder / "out", "--only", "index")
        self.assertEqual(done.returncode, 0, done.stderr)
        after = (self.folder / "out" / "evaluation.md").read_text()
        self.assertEqual(re.findall("^## .*", before, re.M), re.findall("^## .*", after, re.M))

    def check_report(self):
        text = (self.folder / "out" / "evaluation.md").read_text()
        self.assertEqual(len(re.findall("^## ", text, re.M)), 17)
        links = Links()
        links.feed((self.folder / "out" / "evaluation.html").read_text())
        self.assertGreater(len(links.files), 30)
        for file in links.files:
            path = pathlib.Path(self.folder / "out" / file)
            self.assertGreater(path.stat().st_size, 500, file)
            start = path.read_bytes()[:200]
            self.assertTrue(start.startswith(b"\x89PNG") or b"<svg" in start or b"<?xml" in start, file)
            self.assertIn(file, text)

    def check_arithmetic(self):
        """What follows from the paper's equations and formats alone."""
        index = self.values("index")
        self.assertEqual([index[f"10/0.1/{name}"] for name in ("d_tile", "l_tile", "l_index")],
                         [7, 12.8, 12.8e6])
        nodes = self.values("nodes")
        self.assertAlmostEqual(nodes["full_leaf_share"], 0.875, places=4)
        self.assertAlmostEqual(nodes["full_lossless_reduction"], 0.203125, places=5)
        self.assertAlmostEqual(nodes["full_lossy_1_reduction"], 0.914063, places=5)
        self.assertAlmostEqual(sum(nodes[f"model_layer_{depth}"] for depth in range(8)), 1, places=4)

    def check_drive(self):
        drives = {mode: self.values(mode) for mode in MODES}
        for mode, values in drives.items():
            self.assertEqual(values["published"]["durable"], SCANS, mode)
            self.assertGreater(values["published"]["rays"], SCANS * 15_000, mode)
        occupied = {mode: values["stat"]["occupied_voxels"] for mode, values in drives.items()}
        self.assertGreater(occupied["surface"], occupied["carve10"])
        self.assertEqual(drives["surface"]["stat"]["free_voxels"], 0)
        self.assertGreater(drives["free80"]["stat"]["free_voxels"], 0)
        planet = self.values("planet")
        self.assertEqual((planet["differing"], planet["verified"]), (0, True), planet["said"])
        self.assertEqual({p["durable"] for p in planet["published"].values()}, {planet["scans"]})
        truth = self.values("truth")
        for rule in ("default", "all_rays", "pushed", "carve", "surface"):
            self.assertGreater(truth[f"{rule}_precision"], 0.9, rule)
        self.assertGreater(truth["surface_recall"], 0.9)
        self.assertGreaterEqual(truth["surface_recall"], truth["default_recall"])
        self.assertGreater(truth["default_recall"], truth["all_rays_recall"])
        self.assertGreater(truth["all_rays_recall"], truth["pushed_recall"])

    def test_wrong_options_are_told_before_anything_is_measured(self):
        for wrong in (["--only", "nothing"], ["--scans", "3"], ["--data", "/nowhere"]):
            done = self.evaluate("--out", self.folder / "none", *wrong)
            self.assertEqual(done.returncode, 2)
            self.assertIn(wrong[1], done.stderr)
        self.assertFalse((self.folder / "none").exists())


if __name__ == "__main__":
    harness.main()
