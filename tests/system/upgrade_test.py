#!/usr/bin/env python3
"""Models of older versions are read; what a newer version wrote is refused by name.

tests/data/models/vN.tar.gz is a shard that voxatlas wrote when its formats were those of N, killed
so that the journal still held scans; vN.hashes is what `voxatlas stat --hashes` said just before.
They are kept for ever: a format that changes adds another. v2: which rays free (all_rays_free).
"""

import subprocess
import tarfile

from support import harness

from service_set import ServiceSet, SetError, default_bin_dir

MODELS = harness.ROOT / "tests" / "data" / "models"


class Upgrade(harness.SystemTest):
    def unpack(self, version):
        model = self.folder / f"model-{version}"
        with tarfile.open(MODELS / f"{version}.tar.gz") as packed:
            packed.extractall(model)
        return model

    def future(self, kind):
        """A model at rest in which one thing is as a newer voxatlas would write it."""
        model = self.unpack("v1")
        subprocess.run([default_bin_dir() / "future_model", kind, model / "shard-0"], check=True)
        return model

    def test_models_of_every_version_are_read_tile_by_tile_and_grow_on(self):
        versions = sorted(path.name.split(".")[0] for path in MODELS.glob("*.tar.gz"))
        self.assertEqual(versions[:2], ["v1", "v2"])
        for version in versions:
            with self.subTest(version), ServiceSet(self.unpack(version)) as services:
                hashes = self.folder / f"{version}.hashes"
                golden = (MODELS / hashes.name).read_text()
                services.run("stat", "--hashes", hashes)
                self.assertEqual(hashes.read_text(), golden)
                again = ["publish", "--simulate", 1, "--seed", 2, "--source", "golden two"]
                services.run(*again, quiet=True)  # It knows the scans it has.
                services.run("stat", "--hashes", hashes)
                self.assertEqual(hashes.read_text(), golden)
                services.run("publish", "--simulate", 1, "--seed", 3, "--source", "new", quiet=True)
                services.run("stat", "--hashes", hashes)
                self.assertNotEqual(hashes.read_text(), golden)

    def test_a_tile_store_names_what_is_newer_and_stops(self):
        for kind, words in (("format", r"has format 2, this program knows 1"),
                            ("parameters", r"parameters of version 3: this program knows 2"),
                            ("journal", r"journal record of kind 2, not 1")):
            with self.subTest(kind):
                model = self.future(kind)
                with self.assertRaises(SetError) as refused:
                    with ServiceSet(model):
                        pass
                self.assertRegex(str(refused.exception), r"tilestore 0 ended with exit code 1")
                self.assertRegex(str(refused.exception), words)

    def test_a_tile_of_a_newer_version_stops_the_store_that_has_to_change_it(self):
        with self.assertRaises(SetError) as refused:
            with ServiceSet(self.future("tile")) as services:
                services.run("publish", "--simulate", 1, "--seed", 1, "--source", "new", quiet=True)
        self.assertRegex(str(refused.exception), r"tilestore 0 ended with exit code 1")
        self.assertRegex(str(refused.exception), r"tile of version 102: this program knows 1 to 2")


if __name__ == "__main__":
    harness.main()
