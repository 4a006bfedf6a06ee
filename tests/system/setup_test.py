#!/usr/bin/env python3
"""scripts/setup on a machine that is pretended: dpkg has a list, apt-get adds to it."""

import os
import shutil
import signal
import subprocess

from support import harness

TOOLS = ["bash", "sed", "grep", "sort", "wc", "mktemp", "tail", "rm", "env", "cat", "true", "setsid"]
PRETENDERS = {
    "dpkg-query": '''cat "$FAKE/installed"''',
    "id": '''echo "$FAKE_UID"''',
    "apt-get": '''echo "$*" >> "$FAKE/asked"
case "$*" in
  *" update"*) [ ! -e "$FAKE/offline" ] || { echo "Could not resolve"; exit 100; } ;;
  *--download-only*) ;;
  *" install "*)
    [ ! -p "$FAKE/begun" ] || { echo > "$FAKE/begun"; read -r < "$FAKE/go"; }
    for word; do echo "installed $word"; done >> "$FAKE/installed" ;;
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

    def env_of(self, uid):
        return {**os.environ, "PATH": str(self.bin), "FAKE": str(self.folder), "FAKE_UID": str(uid)}

    def setup_as(self, uid, *options):
        return subprocess.run([harness.SCRIPTS / "setup", *options], env=self.env_of(uid), text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, check=False)

    def asked(self):
        file = self.folder / "asked"
        return file.read_text().splitlines() if file.exists() else []

    def test_root_installs_what_is_missing_and_a_second_time_nothing(self):
        first = self.setup_as(0)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("librocksdb-dev", first.stdout)
        self.assertEqual(len(self.asked()), 3)  # Lists, a download, what was downloaded.
        self.assertIn("--no-install-recommends", self.asked()[2])
        second = self.setup_as(0)
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertIn("packages are there", second.stdout)
        self.assertEqual(len(self.asked()), 3)

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
        self.assertEqual(len(self.asked()), 3)

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

    def test_ctrl_c_lets_dpkg_finish_what_it_has_begun(self):
        for pipe in ("begun", "go"):
            os.mkfifo(self.folder / pipe)
        go = os.open(self.folder / "go", os.O_RDWR)
        self.addCleanup(os.close, go)
        process = subprocess.Popen([harness.SCRIPTS / "setup"], env=self.env_of(0), text=True,
                                   stdout=subprocess.PIPE, stdin=subprocess.DEVNULL,
                                   start_new_session=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        self.assertIn("installing", process.stdout.readline())
        (self.folder / "begun").read_text()
        os.killpg(process.pid, signal.SIGINT)
        self.assertIn("dpkg", process.stdout.readline())
        os.write(go, b"\n")
        self.assertEqual(process.wait(), 130)
        self.assertIn("installed librocksdb-dev", (self.folder / "installed").read_text())


if __name__ == "__main__":
    harness.main()
