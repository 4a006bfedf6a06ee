#!/usr/bin/env python3
"""Datagrams lost, doubled and reordered, for real, during a publish: the model is as without."""

import os
import unittest

from support import harness, wire_faults
from support.publishing import PublishTest, tile_hashes

from service_set import ServiceSet


@unittest.skipUnless(harness.multicast_here() and os.geteuid() == 0,
                     "no network namespace of its own: no nftables")
class LossyBus(PublishTest):
    def publish_under(self, fault):
        with ServiceSet(self.folder, **self.SET) as services:
            with fault:
                services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def test_datagrams_are_lost(self):
        for percent in (1, 5, 20):
            with self.subTest(percent=percent):
                self.folder = harness.temporary_folder(self)
                lost = wire_faults.drop(percent)
                self.publish_under(lost)
                self.assertGreater(lost.packets, percent)

    def test_datagrams_come_twice_and_in_another_order(self):
        relay = wire_faults.Relay(duplicated=0.1, delayed=0.3, delay_ms=5)
        self.publish_under(relay)
        self.assertGreater(relay.counts["duplicated"], 20)
        self.assertGreater(relay.counts["delayed"], 50)


if __name__ == "__main__":
    harness.main()
