#!/usr/bin/env python3
"""kill -9 in the middle of a publish: each scan counts once, the model is as without the fault."""

import subprocess

from support import harness

from service_set import ServiceSet, default_bin_dir

SCANS = 40
UPDATES_BEFORE_THE_FAULT = 300  # Tile updates seen on the bus: the publish is well under way.


class Kill(harness.SystemTest):
    """One drive, published undisturbed once, then with a fault in each test."""

    @classmethod
    def setUpClass(cls):
        cls.drive = harness.temporary_folder(cls)
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(SCANS), "--out", cls.drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)
        with ServiceSet(harness.temporary_folder(cls), stores=2) as services:
            services.run("publish", cls.drive, "--poses", "poses.txt", quiet=True)
            cls.undisturbed = cls.hashes(services)

    @staticmethod
    def hashes(services):
        file = services.data_dir / "hashes.txt"
        services.run("stat", "--hashes", file, quiet=True)
        return sorted(file.read_text().splitlines())

    def publish_with(self, fault, ingests=1):
        """Publishes the drive, lets `fault` happen in the middle, returns the tile hashes."""
        with ServiceSet(self.folder, stores=2, ingests=ingests) as services:
            watch = services.begin("watch", "tiles", stdout=subprocess.PIPE, text=True)
            self.addCleanup(watch.communicate)
            self.addCleanup(watch.kill)
            publish = services.begin("publish", self.drive, "--poses", "poses.txt",
                                     "--ingests", ingests, stdout=subprocess.PIPE,
                                     stderr=subprocess.PIPE, text=True)
            self.addCleanup(publish.communicate)
            self.addCleanup(publish.kill)
            for _ in range(UPDATES_BEFORE_THE_FAULT):
                watch.stdout.readline()
            self.assertIsNone(publish.poll(), "the publish was over before the fault")
            fault(services)
            _, err = publish.communicate()
            self.assertEqual(publish.returncode, 0, err)
            watch.kill()
            return self.hashes(services)

    def restart(self, services, kind, index=0):
        service = services.find(kind, index)
        service.kill()
        service.start(services.ended)

    def test_an_ingest_that_is_killed_and_restarted_loses_nothing(self):
        found = self.publish_with(lambda services: self.restart(services, "ingest"))
        self.assertEqual(found, self.undisturbed)

    def test_the_scans_of_an_ingest_that_never_comes_back_go_to_another(self):
        def for_good(services):
            gone = services.find("ingest", 0)
            gone.kill()
            services.services.remove(gone)

        self.assertEqual(self.publish_with(for_good, ingests=2), self.undisturbed)

    def test_a_tilestore_that_is_killed_and_restarted_loses_nothing(self):
        found = self.publish_with(lambda services: self.restart(services, "tilestore", 1))
        self.assertEqual(found, self.undisturbed)

    def test_everything_killed_at_once_and_restarted_loses_nothing(self):
        def all_at_once(services):
            killed = [s for s in services.services if s.kind != "hub"]  # The bus itself stays.
            for service in killed:
                service.process.kill()
            for service in killed:
                service.process.wait()
                service.start(services.ended)

        self.assertEqual(self.publish_with(all_at_once), self.undisturbed)

    def test_a_publish_repeated_adds_nothing_and_the_hashes_tell_when_scans_count_twice(self):
        # The second half is the negative control of all of the above.
        with ServiceSet(self.folder, stores=2) as services:
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(self.hashes(services), self.undisturbed)
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(self.hashes(services), self.undisturbed)
            services.run("publish", self.drive, "--poses", "poses.txt", "--session", 1, quiet=True)
            self.assertNotEqual(self.hashes(services), self.undisturbed)


if __name__ == "__main__":
    harness.main()
