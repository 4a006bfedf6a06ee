#!/usr/bin/env python3
"""Services that stand still, join, and are replaced one by one, in the middle of a publish.

With --long: a store stands still for 10 s, and what is replaced is a set of two of everything.
"""

import signal
import sys
import time

from support import harness
from support.publishing import PublishTest, tile_hashes

from service_set import ServiceSet

LONG = "--long" in sys.argv
STOPPED_SECONDS = 10 if LONG else 3  # Longer than a publisher waits for an ingest, and a claim lasts.
UPDATES_BEFORE_A_FAULT = 200
# How long one restart may keep every tile from changing. Nothing lasts longer than 5 s; a machine
# that is busy with other tests may need several times as long as one that is not.
STALL_SECONDS = 5
# How long one that is replaced may be away; the same, but for a machine busy with other tests.
AWAY_SECONDS = STALL_SECONDS if LONG else 30
RESTARTED = ("ingest", "tilestore", "compress", "render")
# What a service counts from its start, where it is in the way of every scan.
WORK_DONE = {"ingest": "scans_acknowledged", "tilestore": "scans_applied"}


class Stall(PublishTest):
    SCANS = 40
    PASSES = 10 if LONG else 4

    def test_an_ingest_joins_and_a_store_is_stopped_for_a_while_and_nothing_is_lost(self):
        with ServiceSet(self.folder, ingests=2, **self.SET) as services:
            late = services.find("ingest", 1)
            late.signal(signal.SIGTERM)
            late.process.wait()
            updates = self.watch_tiles(services)
            publish = self.begin_publish(services)
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            late.start(services.ended)
            self.wait_for_counter(services, "ingest", 1, "scans_acknowledged", 5, publish)
            store = services.find("tilestore", 0)
            store.signal(signal.SIGSTOP)
            time.sleep(STOPPED_SECONDS)  # The time is the fault.
            self.assertIsNone(publish.poll(), "the publish was over before the store went on")
            store.signal(signal.SIGCONT)
            self.end_publish(publish)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def test_every_service_is_restarted_during_a_publish_and_nothing_is_lost(self):
        def replaced(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            for service in [s for kind in RESTARTED for s in services.services if s.kind == kind]:
                updates.time_pauses()
                began = time.monotonic()
                service.signal(signal.SIGTERM)
                service.process.wait()
                service.start(services.ended)
                services.wait_until_ready()
                if service.kind in WORK_DONE:
                    self.wait_for_counter(services, service.kind,
                                          int(service.name.split()[1]), WORK_DONE[service.kind], 1,
                                          publish)
                away = time.monotonic() - began
                self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
                pause = updates.longest_pause()
                print(f"{service.name} replaced: at work again within {away:.2f} s, nothing at all "
                      f"changed for {pause:.2f} s at most", file=sys.stderr)
                self.assertLess(away, AWAY_SECONDS, service.name)
                self.assertLess(pause, STALL_SECONDS, service.name)

        self.publish_with(replaced, renders=1, ingests=2 if LONG else 1,
                          compressors=2 if LONG else 1)


if __name__ == "__main__":
    if LONG:
        sys.argv.remove("--long")
    harness.main()
