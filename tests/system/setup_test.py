#!/usr/bin/env python3
"""scripts/setup on a machine that is pretended: dpkg has a list, apt-get adds to it."""

import os
import shutil
import subprocess

from support import harness

TOOLS = ["bash", "sed", "grep", "sort", "wc", "mktemp", "tail", "rm", "env", "cat", "true"]
PRETENDERS = {
    "dpkg-query": '''cat "$FAKE/installed"''',
    "id": '''echo "$FAKE_UID"''',
    "apt-get": '''echo "$*" >> "$FAKE/asked"
case "$*" in
  *" update"*) [ ! -e "$FAKE/offline" ] || { echo "Could not resolve"; exit 100; } ;;
  *" install "*) for word; do echo "installed $word"; done >> "$FAKE/installed" ;;
esac''',
}


class Setup(harness.SystemTest):
    def setUp(self):
        super().setUp()
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for tool in TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool))
        for name, script in PRETENDERS.items():
            self.pretend(name, script)
        (self.folder / "installed").write_text("")

    def pretend(self, name, script):
        path = self.bin / name
        path.write_text(f"#!/bin/bash\n{script}\n")
        path.chmod(0o755)

    def setup_as(self, uid, *options):
        env = {**os.environ, "PATH": str(self.bin), "FAKE": str(self.folder), "FAKE_UID": str(uid)}
        return subprocess.run([harness.SCRIPTS / "setup", *options], env=env, text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, check=False)

    def asked(self):
        file = self.folder / "asked"
        return file.read_text().splitlines() if file.exists() else []

    def test_root_installs_what_is_missing_and_a_second_time_nothing(self):
        first = self.setup_as(0)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("librocksdb-dev", first.stdout)
        self.assertEqual(len(self.asked()), 2)
        self.assertIn("--no-install-recommends", self.asked()[1])
        second = self.setup_as(0)
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertIn("packages are there", second.stdout)
        self.assertEqual(len(self.asked()), 2)

    def test_the_programs_alone_ask_for_less(self):
        done = self.setup_as(0, "--programs")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("librocksdb-dev", done.stdout)
        self.assertNotIn("clang-format-14", done.stdout)
        rest = self.setup_as(0)
        self.assertIn("clang-format-14", rest.stdout)
        self.assertNotIn("librocksdb-dev", rest.stdout)

    def test_with_all_there_nobody_needs_root(self):
        self.setup_as(0)
        self.assertEqual(self.setup_as(1000).returncode, 0)

    def test_without_root_and_sudo_the_missing_packages_are_named(self):
        done = self.setup_as(1000)
        self.assertEqual(done.returncode, 1)
        self.assertIn("needs root or sudo: ", done.stderr)
        self.assertIn("librocksdb-dev", done.stderr)
        self.assertEqual(self.asked(), [])

    def test_sudo_is_used_where_it_is(self):
        self.pretend("sudo", '[ "$1" != -n ] || shift; exec "$@"')
        done = self.setup_as(1000)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(self.asked()), 2)

    def test_a_sudo_that_refuses_is_said(self):
        self.pretend("sudo", "exit 1")
        done = self.setup_as(1000)
        self.assertEqual(done.returncode, 1)
        self.assertIn("sudo refused", done.stderr)

    def test_apt_get_that_fails_is_quoted(self):
        (self.folder / "offline").write_text("")
        done = self.setup_as(0)
        self.assertEqual(done.returncode, 1)
        self.assertIn("Could not resolve", done.stderr)


if __name__ == "__main__":
    harness.main()
