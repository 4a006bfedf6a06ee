#!/usr/bin/env python3
"""What must not start, or must fail plainly, with real programs: the message names the culprit."""

import subprocess

from support import harness

from service_set import ServiceSet, SetError, default_bin_dir


class Refusal(harness.SystemTest):
    def fails(self, program, *arguments, env=None):
        """Runs a program that must end by itself with an error; returns what it says."""
        done = subprocess.run([default_bin_dir() / program, *map(str, arguments)], text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, env=env, check=False)
        self.assertGreater(done.returncode, 0, f"{program} {arguments}: {done.stdout}")
        return done.stderr

    def test_a_second_tilestore_on_the_same_folder_is_refused(self):
        with ServiceSet(self.folder) as services:
            said = self.fails("voxatlas-tilestore", "--url", services.bus.url, "--data-dir",
                              self.folder, "--shard", 0, "--shards", 1)
            self.assertIn(str(self.folder), said)
            services.check_alive()

    def test_parameters_that_differ_from_the_stored_model_are_refused(self):
        with ServiceSet(self.folder, store_options=["--cells-per-metre", 5]):
            pass
        with self.assertRaises(SetError) as refused:
            with ServiceSet(self.folder, store_options=["--cells-per-metre", 10]):
                pass
        self.assertIn("tilestore 0 ended", str(refused.exception))
        self.assertIn("cells", str(refused.exception))

    def test_a_number_of_shards_that_differs_from_the_stored_model_is_refused(self):
        with ServiceSet(self.folder, stores=1):
            pass
        with self.assertRaises(SetError) as refused:
            with ServiceSet(self.folder, stores=2):
                pass
        self.assertIn("shards", str(refused.exception))

    def test_a_misspelt_option_is_named(self):
        for command in (["voxatlas-tilestore", "--data-dir", self.folder], ["voxatlas-ingest"],
                        ["voxatlas-compress"], ["voxatlas-render"], ["voxatlas-hub"],
                        ["voxatlas", "stat"]):
            self.assertIn("--indx", self.fails(*command, "--indx", 1))

    def test_a_truncated_scan_and_a_missing_pose_file_are_named_and_the_rest_goes_on(self):
        drive = self.folder / "drive"
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", "3", "--out", drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)
        broken = drive / "velodyne" / "000001.bin"
        broken.write_bytes(broken.read_bytes()[:-3])
        with ServiceSet(self.folder / "data") as services:
            said = self.fails("voxatlas", "publish", drive, "--poses", "poses.txt",
                              env=services.env())
            self.assertIn("000001.bin", said)
            said = self.fails("voxatlas", "publish", drive, "--poses", "nowhere.txt",
                              env=services.env())
            self.assertIn("nowhere.txt", said)
            services.check_alive()

    def test_a_command_without_a_set_gives_up_and_says_who_is_silent(self):
        with ServiceSet(self.folder) as services:
            env = services.env()
        said = self.fails("voxatlas", "stat", env=env)
        self.assertIn("tilestore" if env["LCM_DEFAULT_URL"].startswith("udpm:") else "hub", said)


if __name__ == "__main__":
    harness.main()
