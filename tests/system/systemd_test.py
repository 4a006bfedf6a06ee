#!/usr/bin/env python3
"""Under systemd: readiness and watchdog over its socket, events as lines, units it finds sound."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import unittest

from support import harness

from bus import DEFAULT_URL
from service_set import default_bin_dir

UNITS = harness.SCRIPTS / "systemd"
SECONDS = 60
SERVICES = {"ingest@0": "STATUS=waiting for tilestore 0", "compress@0": "STATUS=",
            "render@0": "STATUS=", "tilestore@0": "STATUS=ready", "hub": "READY=1\nWATCHDOG=1"}


def line_of(unit, key):
    text = (UNITS / f"voxatlas-{unit.replace('@0', '@')}.service").read_text(encoding="utf-8")
    return re.search(rf"^{key}=(.*)$", text, re.M).group(1)


class Systemd(harness.SystemTest):
    def setUp(self):
        super().setUp()
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)
        self.socket.bind(str(self.folder / "notify"))
        self.socket.settimeout(SECONDS)

    def start(self, unit, url, *more):
        """The command of a unit, as systemd would fill it in, on this machine's programs."""
        settings = {"VOX_STORE": "/var/lib/voxatlas", "VOX_STORES": "1", "VOX_INGESTS": "1",
                    "VOX_COMPRESSORS": "1"}
        command = line_of(unit, "ExecStart").replace("%i", "0")
        command = re.sub(r" \$VOX_\w+_OPTIONS", "", command)
        command = re.sub(r"\$\{(\w+)\}", lambda name: settings[name.group(1)], command)
        command = command.replace("/usr/bin", str(default_bin_dir()))
        command = command.replace("/var/lib/voxatlas", str(self.folder / "model"))
        command = command.replace("--port 7700", "--port 0")
        env = {**os.environ, "NOTIFY_SOCKET": str(self.folder / "notify"), "LCM_DEFAULT_URL": url}
        process = subprocess.Popen([*command.split(), *more], env=env, stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def bus(self):
        """A bus without services: multicast, else a hub."""
        if harness.multicast_here():
            return DEFAULT_URL
        hub = subprocess.Popen([default_bin_dir() / "voxatlas-hub", "--port", "0"],
                               stdout=subprocess.PIPE, text=True)
        self.addCleanup(hub.communicate)
        self.addCleanup(hub.kill)
        return f"tcpq://127.0.0.1:{hub.stdout.readline().split()[1]}"

    def test_every_unit_says_that_it_is_ready_and_feeds_its_watchdog(self):
        url = self.bus()
        for unit, words in SERVICES.items():
            with self.subTest(unit):
                process = self.start(unit, url, "--log-json")
                said = [self.socket.recv(1000).decode() for _ in range(3)]
                for datagram in said:
                    self.assertTrue(datagram.startswith("READY=1\nWATCHDOG=1"), datagram)
                self.assertIn(words, "".join(said))
                process.send_signal(signal.SIGTERM)
                _, err = process.communicate()
                self.assertEqual(process.returncode, 0, err)
                for line in err.splitlines():
                    if line.startswith("LCM tcpq: "):
                        continue  # What LCM itself says of the hub; nothing can keep it from that.
                    self.assertEqual(sorted(json.loads(line)), ["level", "service", "text", "time"])
                self.assertIn("stopped", err)
                self.forget_datagrams()

    def forget_datagrams(self):
        self.socket.setblocking(False)
        try:
            while True:
                self.socket.recv(1000)
        except BlockingIOError:
            self.socket.settimeout(SECONDS)

    def test_a_service_that_hangs_feeds_no_watchdog(self):
        process = self.start("hub", "")
        self.socket.recv(1000)
        process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)
        self.forget_datagrams()
        self.socket.settimeout(2)  # Four times what it may take.
        with self.assertRaises(TimeoutError):
            self.socket.recv(1000)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd here")
    def test_systemd_finds_the_units_sound_and_little_exposed(self):
        units = self.folder / "units"
        shutil.copytree(UNITS, units)
        for file in units.glob("*.service"):  # Verifying asks whether the programs are there.
            file.write_text(file.read_text().replace("/usr/bin", str(default_bin_dir())))
        env = {**os.environ, "SYSTEMD_UNIT_PATH": f"{units}:/usr/lib/systemd/system"}
        names = [f"voxatlas-{unit}.service" for unit in SERVICES]
        done = subprocess.run(["systemd-analyze", "verify", "voxatlas.target", *names], env=env,
                              capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))
        for name in names:
            done = subprocess.run(["systemd-analyze", "security", "--offline=yes",
                                   "--threshold=20", name], env=env, capture_output=True, text=True,
                                  check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    harness.main()
