#!/usr/bin/env python3
"""g++ compiles a source with the optimisation flags of its precompiled header, and says nothing: they
must be the source's own."""

import json
import re

from support import harness

from service_set import default_bin_dir

COMMANDS = default_bin_dir().parent / "compile_commands.json"
HEADER = re.compile(r"CMakeFiles/(\w+)\.dir/cmake_pch\.hxx")


def flags(command):
    return sorted(set(re.findall(r" (-[fOm]\S+)", command)))


class Precompiled(harness.SystemTest):
    def test_every_source_is_compiled_as_its_precompiled_header_was(self):
        sources = [entry for entry in json.loads(COMMANDS.read_text()) if HEADER.search(entry["command"])]
        headers = {HEADER.search(entry["command"]).group(1): flags(entry["command"])
                   for entry in sources if entry["file"].endswith("cmake_pch.hxx.cxx")}
        if not headers:
            self.skipTest("nothing is precompiled in this build")
        self.assertGreater(len(sources), 100)
        for entry in sources:
            self.assertEqual(flags(entry["command"]), headers[HEADER.search(entry["command"]).group(1)],
                             entry["file"])


if __name__ == "__main__":
    harness.main()
