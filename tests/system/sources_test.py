#!/usr/bin/env python3
"""Who publishes what: a source has one publisher, several sources share the set, marks never fall."""

import shutil
import signal
import subprocess

from support import harness
from support.publishing import PublishTest, simulate, tile_hashes

from service_set import ServiceSet, default_bin_dir

UPDATES_BEFORE_A_FAULT = 300


class Sources(PublishTest):
    SCANS = 40

    def test_a_second_publisher_of_a_source_is_refused_and_the_first_goes_on(self):
        with ServiceSet(self.folder, **self.SET) as services:
            updates = self.watch_tiles(services)
            first = self.begin_publish(services)
            self.wait_for_updates(updates, 1, first)
            ingest = services.find("ingest")  # The first is still there when the second asks.
            ingest.signal(signal.SIGSTOP)
            second = self.begin_publish(services)
            _, said = second.communicate()
            ingest.signal(signal.SIGCONT)
            self.assertEqual(second.returncode, 1)
            self.assertIn("is being published by another process", said)
            self.end_publish(first)
            self.assertEqual(tile_hashes(services), self.undisturbed)
            self.end_publish(self.begin_publish(services))  # The claim was given back.

    def test_several_sources_and_faults_equal_a_replay_in_the_journals_order(self):
        others = [simulate(harness.temporary_folder(self), self.SCANS) for _ in range(2)]
        with ServiceSet(self.folder, ingests=2, store_options=["--keep-journal"],
                        **self.SET) as services:
            updates = self.watch_tiles(services)
            # The same street, driven by three: their scans change the same tiles.
            publishes = [self.begin_publish(services, "--source", f"car {i}", drive=drive)
                         for i, drive in enumerate([self.drive, *others])]
            for kind in ("tilestore", "ingest"):
                self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publishes[0])
                self.restart(services, kind)
            for publish in publishes:
                self.end_publish(publish)
            found = tile_hashes(services)
        replayed = subprocess.run([default_bin_dir() / "journal_replay", self.folder], check=True,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True)
        self.assertEqual(found, sorted(replayed.stdout.splitlines()))
        self.assertEqual({line.split()[0] for line in found},
                         {line.split()[0] for line in self.undisturbed})
        self.assertNotEqual(found, self.undisturbed)

    def test_a_shard_that_has_lost_acknowledged_scans_raises_an_alarm(self):
        with ServiceSet(self.folder, **self.SET) as services:
            updates = self.watch_tiles(services)
            publish = self.begin_publish(services)
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            store = services.find("tilestore", 1)
            store.kill()
            shutil.rmtree(self.folder / "shard-1")  # A disk that forgets, the worst of all.
            store.start(services.ended)
            _, said = publish.communicate()
            self.assertEqual(publish.returncode, 1)
            self.assertIn("tilestore 1 has lost scans", said)
            self.assertIn("ALARM", store.log_path.read_text())
            self.wait_for_counter(services, "tilestore", 1, "marks_regressed", 1)


if __name__ == "__main__":
    harness.main()
