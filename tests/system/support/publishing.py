"""A drive that is published while something goes wrong, and must come out as if nothing had.

Each class of tests publishes its drive once undisturbed; a test publishes it again under a fault and
compares the hashes and versions of all tiles: a scan lost, or counted twice, shows in both.
"""

import json
import subprocess
import threading
import time

from support import harness

import drives
from service_set import ServiceSet, default_bin_dir


def tile_hashes(services):
    """A line a tile, key, version and hash, of the running set."""
    file = services.data_dir / "hashes.txt"
    services.run("stat", "--hashes", file, quiet=True)
    return sorted(file.read_text().splitlines())


def simulate(folder, scans, passes=1, seed=None):
    """A simulated drive in `folder`, `passes` times over."""
    once = folder / "once" if passes > 1 else folder
    more = ["--seed", str(seed)] if seed is not None else []
    subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(scans), "--out", once, *more],
                   check=True, stdin=subprocess.DEVNULL, capture_output=True)
    if passes == 1:
        return folder
    drives.repeat(once, "poses.txt", folder / "drive", passes)
    return folder / "drive"


class PublishTest(harness.SystemTest):
    """SCANS scans, PASSES times over, through the services that SET names."""

    SCANS = 20
    PASSES = 1
    HZ = 20  # Scans a second, however fast the machine is: faults must find the publish under way.
    SET = {"stores": 2, "renders": 0}

    @classmethod
    def setUpClass(cls):
        cls.drive = cls.make_drive()
        with ServiceSet(harness.temporary_folder(cls), **cls.SET) as services:
            services.run("publish", cls.drive, "--poses", "poses.txt", quiet=True)
            cls.undisturbed = tile_hashes(services)

    @classmethod
    def make_drive(cls):
        return simulate(harness.temporary_folder(cls), cls.SCANS, cls.PASSES)

    def begin_publish(self, services, *options, drive=None):
        """`voxatlas publish` of the drive, going on while the test does."""
        publish = services.begin("publish", drive or self.drive, "--poses", "poses.txt", "--json",
                                 "--hz", self.HZ, *options, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 text=True)
        self.addCleanup(publish.communicate)
        self.addCleanup(publish.kill)
        return publish

    def end_publish(self, publish):
        """Waits for its end, which must be a good one; returns what it says on stderr."""
        _, err = publish.communicate()
        self.assertEqual(publish.returncode, 0, err)
        return err

    def watch_tiles(self, services):
        """The tile updates on the bus, from now on."""
        watch = services.begin("watch", "tiles", stdout=subprocess.PIPE, text=True)
        updates = Updates(watch.stdout)
        self.addCleanup(watch.communicate)
        self.addCleanup(updates.thread.join)
        self.addCleanup(watch.kill)
        return updates

    def wait_for_updates(self, updates, count, publish):
        """Returns when so many more updates were seen, all of them before the publish is over."""
        updates.wait_for(count, publish)
        self.assertIsNone(publish.poll(), "the publish was over before the fault")

    def publish_with(self, fault, **how):
        """Publishes the drive, lets fault(services, publish, updates) happen in the middle of it."""
        with ServiceSet(self.folder, **{**self.SET, **how}) as services:
            updates = self.watch_tiles(services)
            publish = self.begin_publish(services)
            fault(services, publish, updates)
            self.end_publish(publish)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def wait_for_counter(self, services, kind, index, counter, least, publish=None):
        """Returns when a service says that a counter of its is so high, while `publish` goes on."""
        status = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
        self.addCleanup(status.communicate)
        self.addCleanup(status.kill)
        for line in status.stdout:
            said = json.loads(line)
            if (said["service"], said["index"]) == (kind, index) and \
                    said["counters"].get(counter, 0) >= least:
                status.kill()
                return
            if publish and publish.poll() is not None:
                self.fail(f"the publish was over before {counter} of {kind} {index} was {least}")

    def restart(self, services, kind, index=0):
        service = services.find(kind, index)
        service.kill()
        if service.process.stdout:
            service.process.stdout.close()
        service.start(services.ended)


class Updates:
    """Lines that come, an update each: how many, and the longest time without one."""

    def __init__(self, lines):
        self.came = threading.Condition()
        self.count = 0
        self.last = self.longest = None
        self.over = False
        self.thread = threading.Thread(target=self._read, args=(lines,), daemon=True)
        self.thread.start()

    def _read(self, lines):
        for _ in lines:
            with self.came:
                self.count += 1
                self._note_pause()
                self.came.notify_all()
        with self.came:
            self.over = True
            self.came.notify_all()

    def _note_pause(self):
        now = time.monotonic()
        if self.last is not None:
            self.longest = max(self.longest, now - self.last)
            self.last = now

    def wait_for(self, count, publish):
        """Returns when so many more have come, or the publish is over."""
        with self.came:
            wanted = self.count + count
            while self.count < wanted and not self.over and publish.poll() is None:
                self.came.wait(1)

    def time_pauses(self):
        """From now on."""
        with self.came:
            self.last, self.longest = time.monotonic(), 0.0

    def longest_pause(self):
        with self.came:
            self._note_pause()
            return self.longest
