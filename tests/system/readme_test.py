#!/usr/bin/env python3
"""The README's programs, taken out of its text: they compile as it says, and they work."""

import re
import select
import subprocess

from support import harness

from service_set import ServiceSet

# `name.cpp` in a sentence, then the program in the next code block.
PROGRAM = re.compile(r"^`(\w+)\.cpp`(?:(?!^```).)*^```cpp\n(.*?)^```$", re.M | re.S)


class Readme(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        cls.bin = harness.temporary_folder(cls)
        types = sorted((harness.ROOT / "lcmtypes").glob("*.lcm"))
        subprocess.run(["lcm-gen", "--cpp", "--cpp-std", "c++11", "--cpp-hpath", cls.bin, *types],
                       check=True, stdout=subprocess.DEVNULL)
        text = (harness.ROOT / "README.md").read_text(encoding="utf-8")
        cls.programs = dict(PROGRAM.findall(text))
        for name, source in cls.programs.items():
            (cls.bin / f"{name}.cpp").write_text(source, encoding="utf-8")
            subprocess.run(["g++", "-std=c++17", "-O2", "-fno-strict-aliasing", "-Wall", "-Wextra", "-I",
                            cls.bin, cls.bin / f"{name}.cpp", "-o", cls.bin / name, "-llcm"], check=True)

    def test_the_readme_holds_both_programs(self):
        self.assertEqual(sorted(self.programs), ["logger", "subscriber"])

    def test_a_scan_of_the_logger_reaches_the_subscriber_as_tiles_and_as_a_picture(self):
        with ServiceSet(self.folder / "data") as services:
            subscriber = subprocess.Popen([self.bin / "subscriber"], stdout=subprocess.PIPE,
                                          text=True, cwd=self.folder, env=services.env())
            self.addCleanup(subscriber.communicate)
            self.addCleanup(subscriber.kill)
            self.assertEqual(subscriber.stdout.readline(), "listening\n")
            self.log_until_heard(services, subscriber)
            self.assertRegex(subscriber.stdout.readline(), r"^tile \d+ version \d+$")
            services.run("render", "--view", "oblique", "--size", "320x180", "--broadcast", "--out",
                         self.folder / "asked.jpg", quiet=True)
            line = subscriber.stdout.readline()
            while line.startswith("tile "):
                line = subscriber.stdout.readline()
            self.assertRegex(line, r"^frame.jpg shows \d+ tiles$")
        self.assertTrue((self.folder / "frame.jpg").read_bytes().startswith(b"\xff\xd8"))

    def log_until_heard(self, services, subscriber):
        """Once is enough on multicast; the hub may learn of a subscription after `listening`."""
        heard = False
        while not heard:
            subprocess.run([self.bin / "logger"], check=True, env=services.env())
            heard, _, _ = select.select([subscriber.stdout], [], [], 2)


if __name__ == "__main__":
    harness.main()
