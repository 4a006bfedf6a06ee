#!/usr/bin/env python3
"""How scripts/lib/bus.py finds a bus, with the real probe and the real hub."""

import socket
import subprocess
import unittest

from support import harness

from bus import DEFAULT_URL, Bus, probe
from service_set import ServiceSet, default_bin_dir


def ip(*arguments):
    subprocess.run(["ip", *arguments], check=True)


@unittest.skipUnless(harness.multicast_here(), "no network namespace of its own: no multicast")
class Multicast(harness.SystemTest):
    def test_multicast_is_taken_where_it_works(self):
        bus = Bus()
        bus.find(default_bin_dir())
        self.assertEqual(bus.url, DEFAULT_URL)
        bus.leave()  # The route is not ours.
        self.assertIsNone(probe(default_bin_dir(), DEFAULT_URL))

    def test_a_missing_route_is_added_and_taken_away_again(self):
        ip("route", "del", "224.0.0.0/4", "dev", "lo")
        try:
            self.assertIsNotNone(probe(default_bin_dir(), DEFAULT_URL))
            bus = Bus()
            bus.find(default_bin_dir())
            self.assertEqual(bus.url, DEFAULT_URL)
            bus.leave()
            self.assertIsNotNone(probe(default_bin_dir(), DEFAULT_URL))
        finally:
            ip("route", "add", "224.0.0.0/4", "dev", "lo")


class Hub(harness.SystemTest):
    def test_the_whole_set_works_over_the_hub(self):
        with ServiceSet(self.folder, hub=True) as services:
            self.assertTrue(services.bus.url.startswith("tcpq://127.0.0.1:"))
            services.run("publish", "--simulate", 1, quiet=True)
            hashes = self.folder / "hashes.txt"
            services.run("stat", "--hashes", hashes, quiet=True)
            self.assertGreater(len(hashes.read_text().splitlines()), 10)

    def test_a_hub_that_is_not_there_is_no_bus(self):
        with socket.socket() as nobody:
            nobody.bind(("127.0.0.1", 0))  # Taken, but nobody listens.
            url = f"tcpq://127.0.0.1:{nobody.getsockname()[1]}"
            self.assertIn(url, probe(default_bin_dir(), url))


if __name__ == "__main__":
    harness.main()
