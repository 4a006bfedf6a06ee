#!/usr/bin/env python3
"""`voxatlas doctor` on machines that lack something, and what its sentences are worth."""

import json
import re
import subprocess
import unittest

from support import harness

from service_set import ServiceSet, default_bin_dir

ROUTE = ["224.0.0.0/4", "dev", "lo"]


class Doctor(harness.SystemTest):
    def ask(self, data_dir=None, env=None):
        """The exit code, and what is not fine: level and check, with all that was said of it."""
        done = subprocess.run([default_bin_dir() / "voxatlas", "doctor", "--json", "--listen", "1.6",
                               "--data-dir", data_dir or self.folder / "data"], env=env, check=False,
                              capture_output=True, text=True, stdin=subprocess.DEVNULL)
        findings = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertGreaterEqual(len(findings), 8, done.stderr)
        return done.returncode, {(f["level"], f["check"]): f"{f['what']} {f['mend']}"
                                 for f in findings if f["level"] != "fine"}

    def wrong(self, data_dir=None, env=None):
        code, findings = self.ask(data_dir, env)
        wrong = {check: said for (level, check), said in findings.items() if level == "wrong"}
        self.assertEqual(code, 1 if wrong else 0, findings)
        return wrong

    def test_of_a_set_that_runs_nothing_is_wrong(self):
        with ServiceSet(self.folder / "data", stores=2) as services:
            self.assertEqual(self.wrong(env=services.env()), {})

    def test_nor_of_one_at_a_hub(self):
        with ServiceSet(self.folder / "data", hub=True) as services:
            self.assertEqual(self.wrong(env=services.env()), {})
            env = services.env()
        self.assertEqual(list(self.wrong(env=env)), ["hub", "services"])

    def test_that_nobody_is_there_is_told_in_words(self):
        done = subprocess.run([default_bin_dir() / "voxatlas", "doctor", "--listen", "0.1"],
                              cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, r"wrong +services +none is heard")
        self.assertIn("-> Start the set with scripts/up", done.stdout)
        self.assertRegex(done.stdout, r"weak +data folder +.*/voxatlas-data is not there")

    def test_two_ingests_of_one_number_and_a_data_folder_that_is_none_are_told(self):
        file = self.folder / "file"
        file.write_text("")
        with ServiceSet(self.folder / "data") as services:
            with open(self.folder / "second.log", "wb") as log:
                second = subprocess.Popen([default_bin_dir() / "voxatlas-ingest", "--index", "0",
                                           "--stores", "1"], env=services.env(), stdout=log,
                                          stderr=log, stdin=subprocess.DEVNULL)
            self.addCleanup(second.wait)
            self.addCleanup(second.kill)
            pids = set()
            while len(pids) < 2:
                heard = services.run("watch", "status", "--json", "--count", 1, "--timeout", 60)
                pids |= {json.loads(heard)["pid"]} if '"ingest"' in heard else set()
            wrong = self.wrong(file, services.env())
            self.assertIn("is no folder", wrong["data folder"])
            self.assertRegex(wrong["services"], rf"2 run as ingest 0: pids .*\b{second.pid}\b")

    @unittest.skipUnless(harness.multicast_here(), "no network namespace of its own")
    def test_what_it_says_of_a_missing_route_mends_it(self):
        subprocess.run(["ip", "route", "del", *ROUTE], check=True)
        self.addCleanup(subprocess.run, ["ip", "route", "replace", *ROUTE], check=True)
        said = self.wrong()["route"]
        commands = re.search(r"As root: (ip .*?)\. ", said)[1]
        subprocess.run(commands, shell=True, check=True)
        self.assertNotIn("route", self.wrong())

    @unittest.skipUnless(harness.multicast_here(), "no network namespace of its own")
    def test_a_firewall_is_told(self):
        rules = ("add table inet wall\n"
                 "add chain inet wall in { type filter hook input priority 0; }\n"
                 "add rule inet wall in udp dport 7667 drop\n")
        subprocess.run(["nft", "-f", "-"], input=rules, text=True, check=True)
        self.addCleanup(subprocess.run, ["nft", "delete", "table", "inet", "wall"], check=True)
        self.assertIn("firewall", self.wrong()["multicast"])


if __name__ == "__main__":
    harness.main()
