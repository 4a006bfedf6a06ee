#!/usr/bin/env python3
"""kill -9 in the middle of a publish: each scan counts once, the model is as without the fault.

With --long: 50 services, chosen at random, in one publish.
"""

import os
import random
import sys

from support import harness
from support.publishing import PublishTest, tile_hashes

from service_set import ServiceSet

LONG = "--long" in sys.argv
KILLS = 50 if LONG else 5
UPDATES_BEFORE_A_FAULT = 300  # Seen on the bus: the publish is well under way.
UPDATES_BETWEEN_FAULTS = 100


class Kill(PublishTest):
    """One drive, published undisturbed once, then with a fault in each test."""

    SCANS = 40
    PASSES = 10 if LONG else 1

    def publish_with_one(self, fault, **how):
        def in_the_middle(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            fault(services)

        self.publish_with(in_the_middle, **how)

    def test_an_ingest_that_is_killed_and_restarted_loses_nothing(self):
        self.publish_with_one(lambda services: self.restart(services, "ingest"))

    def test_the_scans_of_an_ingest_that_never_comes_back_go_to_another(self):
        def for_good(services):
            gone = services.find("ingest", 0)
            gone.kill()
            services.services.remove(gone)

        self.publish_with_one(for_good, ingests=2)

    def test_a_tilestore_that_is_killed_and_restarted_loses_nothing(self):
        self.publish_with_one(lambda services: self.restart(services, "tilestore", 1))

    def test_everything_killed_at_once_and_restarted_loses_nothing(self):
        def all_at_once(services):
            killed = [s for s in services.services if s.kind != "hub"]  # The bus itself stays.
            for service in killed:
                service.process.kill()
            for service in killed:
                service.process.wait()
                service.start(services.ended)

        self.publish_with_one(all_at_once)

    def test_a_hub_that_is_killed_and_restarted_loses_nothing(self):
        self.publish_with_one(lambda services: self.restart(services, "hub"), hub=True)

    def test_a_publisher_that_is_killed_goes_on_where_it_was(self):
        def killed(services):
            publish = self.begin_publish(services)
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            publish.kill()
            publish.communicate()

        with ServiceSet(self.folder, **self.SET) as services:
            updates = self.watch_tiles(services)
            killed(services)
            said = self.end_publish(self.begin_publish(services))
            self.assertIn("are in the model already", said)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def test_services_killed_at_random_one_after_another_lose_nothing(self):
        seed = int(os.environ.get("VOX_SEED") or random.randrange(1 << 32))
        print(f"VOX_SEED={seed}", file=sys.stderr)
        rng = random.Random(seed)

        def again_and_again(services, publish, updates):
            for _ in range(KILLS):
                self.wait_for_updates(updates, rng.randrange(2 * UPDATES_BETWEEN_FAULTS), publish)
                killed = rng.choice(services.services)
                self.restart(services, killed.kind, int(killed.name.split()[1]))

        self.publish_with(again_and_again, ingests=2, renders=1)

    def test_a_publish_repeated_adds_nothing_and_the_hashes_tell_when_scans_count_twice(self):
        # The second half is the negative control of all of the above.
        with ServiceSet(self.folder, stores=2) as services:
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(tile_hashes(services), self.undisturbed)
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(tile_hashes(services), self.undisturbed)
            services.run("publish", self.drive, "--poses", "poses.txt", "--session", 1, quiet=True)
            self.assertNotEqual(tile_hashes(services), self.undisturbed)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
