#!/usr/bin/env python3
"""A model in a real Ceph cluster while parts of it fail during a publish, and owners change.

Each test must end with the hashes and versions that an embedded model had undisturbed.
"""

import json
import os
import re
import signal
import subprocess
import time
import unittest

from support import ceph, harness
from support.publishing import PublishTest, tile_hashes
from support.wire_faults import Rules

from service_set import Service, ServiceSet

UPDATES_BEFORE_A_FAULT = 200
UPDATES_BETWEEN = 100
TAKE_OVER_SECONDS = 10
# A silent OSD is called down after 4 s (support/ceph.py); then its work is somebody else's.
GRACE_SECONDS, SLACK_SECONDS = 4, 16


def built_with_rados():
    return (ServiceSet("unused").bin_dir / "voxatlas-rados.so").exists()


@unittest.skipUnless(built_with_rados(), "built without librados (scripts/setup --rados)")
class RadosFaults(PublishTest):
    SCANS = 80
    HZ = 3
    SET = {"stores": 1, "renders": 0}

    @classmethod
    def setUpClass(cls):
        if ceph.missing():
            raise unittest.SkipTest("no cluster: " + ceph.missing())
        super().setUpClass()  # The undisturbed run is an embedded one.
        cls.cluster = ceph.Cluster(harness.temporary_folder(cls))
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()

    def setUp(self):
        super().setUp()
        self.place = self.cluster.store(self._testMethodName)

    def publish_on_the_cluster(self, fault):
        self.publish_with(fault, store=self.place)

    def statuses(self, services):
        """What the services say, as it comes."""
        watch = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
        self.addCleanup(watch.communicate)
        self.addCleanup(watch.kill)
        return (json.loads(line) for line in watch.stdout)

    def wait_for_state(self, services, words, pid=None):
        """Returns the first status of a tilestore that says so."""
        for said in self.statuses(services):
            if said["service"] == "tilestore" and words in said["state"] and \
                    pid in (None, said["pid"]):
                return said
        raise AssertionError(f"nobody said {words!r}")

    def another_owner(self, services):
        """A second process for shard 0, as another host would start it."""
        first = services.find("tilestore")
        second = Service("tilestore", 0, first.command, first.log_path.with_suffix(".second.log"),
                         first.env)
        second.name = "second tilestore"
        return second

    # --- the cluster fails ---

    def test_each_osd_is_killed_in_turn(self):
        def in_turn(_, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            for number in range(self.cluster.osds):
                self.cluster.kill(f"osd.{number}")
                try:
                    self.wait_for_updates(updates, UPDATES_BETWEEN, publish)
                finally:
                    self.cluster.revive(f"osd.{number}")

        self.publish_on_the_cluster(in_turn)

    def test_the_monitor_is_killed(self):
        def gone(_, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            self.cluster.kill("mon.a")
            self.wait_for_updates(updates, UPDATES_BETWEEN, publish)
            self.cluster.revive("mon.a")

        self.publish_on_the_cluster(gone)

    def test_all_daemons_are_killed_at_once(self):
        def all_at_once(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            names = list(self.cluster.daemons)
            for name in names:
                self.cluster.daemons[name].kill()
            for name in names:
                self.cluster.kill(name)
            self.wait_for_state(services, "waiting for the store")
            self.assertIsNone(publish.poll())
            self.cluster.revive(*names)

        self.publish_on_the_cluster(all_at_once)

    def test_an_osd_that_stands_still_stalls_no_longer_than_the_grace(self):
        def slow(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            updates.time_pauses()
            still = self.cluster.daemons["osd.0"]
            still.send_signal(signal.SIGSTOP)
            try:
                self.wait_for_state(services, "waiting for the store")
                self.wait_for_updates(updates, UPDATES_BETWEEN, publish)
                pause = updates.longest_pause()
            finally:
                still.send_signal(signal.SIGCONT)
            print(f"stalled for {pause:.1f} s", flush=True)
            self.assertLess(pause, GRACE_SECONDS + SLACK_SECONDS)

        self.publish_on_the_cluster(slow)
        self.cluster.wait_until_up(self.cluster.osds)

    def test_a_full_osd_is_waited_for_and_said_so(self):
        def full(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            self.cluster.set_full(True)
            try:
                self.wait_for_state(services, "waiting for the store")
                self.assertIsNone(publish.poll())
            finally:
                self.cluster.set_full(False)

        self.publish_on_the_cluster(full)

    @unittest.skipUnless(harness.multicast_here() and os.geteuid() == 0,
                         "no network namespace of its own: no nftables")
    def test_a_write_whose_answer_is_lost_is_read_back(self):
        # The cluster's answers vanish on their way to this process's sockets; new ones work.
        impatient = self.folder / "ceph.conf"
        impatient.write_text(self.cluster.conf.read_text() + "rados_osd_op_timeout = 2\n")
        self.place = self.place.replace(str(self.cluster.conf), str(impatient))

        def lost(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            ports = self.ports_of(services.find("tilestore").process.pid)
            rules = Rules("type filter hook input priority 0;",
                          [f"tcp dport {{ {', '.join(ports)} }} counter name hit drop"])
            with rules:
                self.wait_for_state(services, "the disk fails")
                self.wait_for_state(services, "ready")
            self.assertGreater(rules.packets, 0)
            self.wait_for_updates(updates, UPDATES_BETWEEN, publish)

        self.publish_on_the_cluster(lost)

    @staticmethod
    def ports_of(pid):
        """Its own ends of the connections to the cluster."""
        listed = subprocess.run(["ss", "-Htnp", "state", "established"], check=True, text=True,
                                capture_output=True).stdout
        return sorted({line.split()[2].rsplit(":", 1)[1] for line in listed.splitlines()
                       if f"pid={pid}," in line})

    # --- owners change ---

    def test_a_killed_owner_is_replaced_within_ten_seconds(self):
        def replaced(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            first = services.find("tilestore")
            second = self.another_owner(services)
            first.kill()
            began = time.monotonic()
            second.start(services.ended)
            services.services[services.services.index(first)] = second
            self.wait_for_state(services, "ready", second.process.pid)
            took = time.monotonic() - began
            print(f"replaced in {took:.1f} s", flush=True)
            self.assertLess(took, TAKE_OVER_SECONDS)
            self.wait_for_updates(updates, UPDATES_BETWEEN, publish)

        self.publish_on_the_cluster(replaced)

    def test_a_living_owner_is_not_replaced_and_named(self):
        with ServiceSet(self.folder, **self.SET, store=self.place) as services:
            second = self.another_owner(services)
            second.start(services.ended)
            second.process.wait(60)
            self.assertEqual(second.process.returncode, 1)
            said = second.log_path.read_text()
            self.assertRegex(said, rf"in use by another process, \S+:"
                             rf"{services.find('tilestore').process.pid} ")
            self.assertTrue(services.find("tilestore").is_running())

    def test_an_owner_that_slept_is_fenced_when_it_wakes(self):
        def asleep(services, publish, updates):
            self.wait_for_updates(updates, UPDATES_BEFORE_A_FAULT, publish)
            first = services.find("tilestore")
            self.addCleanup(first.process.kill)
            first.signal(signal.SIGSTOP)
            second = self.another_owner(services)
            second.start(services.ended)
            services.services[services.services.index(first)] = second
            self.wait_for_state(services, "ready", second.process.pid)
            self.wait_for_updates(updates, UPDATES_BETWEEN, publish)
            first.signal(signal.SIGCONT)
            first.process.wait(60)
            self.assertNotEqual(first.process.returncode, 0)
            self.assertIn("belongs to epoch", first.obituary())
            self.wait_for_updates(updates, UPDATES_BETWEEN, publish)

        self.publish_on_the_cluster(asleep)

    # --- there and back ---

    def voxatlas(self, *arguments, **options):
        return subprocess.run([ServiceSet("unused").bin_dir / "voxatlas", *map(str, arguments)],
                              check=False, capture_output=True, text=True, **options)

    def hashes_of(self, place):
        file = self.folder / "hashes"
        done = self.voxatlas("store", "stat", "--store", place, "--hashes", file)
        self.assertEqual(done.returncode, 0, done.stderr)
        return sorted(file.read_text().splitlines())

    def test_a_model_is_copied_to_the_cluster_and_back_and_goes_on_there(self):
        with ServiceSet(self.folder / "first", **self.SET) as services:
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
        there, back = self.place, self.folder / "back"
        copied = self.voxatlas("store", "copy", self.folder / "first", there)
        self.assertEqual(copied.returncode, 0, copied.stderr)
        self.assertEqual(self.hashes_of(there), self.undisturbed)
        verified = self.voxatlas("store", "verify", "--store", there)
        self.assertEqual(verified.returncode, 0, verified.stderr)
        again = self.voxatlas("store", "copy", self.folder / "first", there)
        self.assertIn("holds a model already", again.stderr)
        copied = self.voxatlas("store", "copy", there, back)
        self.assertEqual(copied.returncode, 0, copied.stderr)
        self.assertEqual(self.hashes_of(back), self.undisturbed)
        # The marks came too: what is in the model already is not added again.
        with ServiceSet(self.folder / "logs", **self.SET, store=there) as services:
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def test_a_copy_that_is_killed_is_no_model_and_goes_on(self):
        with ServiceSet(self.folder / "first", **self.SET) as services:
            services.run("publish", self.drive, "--poses", "poses.txt", quiet=True)
        self.cluster.slow_down(True)  # So that it is killed in the middle.
        self.addCleanup(self.cluster.slow_down, False)
        command = [ServiceSet("unused").bin_dir / "voxatlas", "store", "copy",
                   self.folder / "first", self.place]
        copy = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)
        self.addCleanup(copy.wait)
        self.addCleanup(copy.kill)
        end = time.monotonic() + ceph.PATIENCE
        while not self.cluster.tiles(self._testMethodName):
            self.assertIsNone(copy.poll(), "the copy was over before it was killed")
            self.assertLess(time.monotonic(), end, "the copy wrote nothing")
        copy.kill()
        copy.wait()
        self.cluster.slow_down(False)
        refused = self.voxatlas("store", "verify", "--store", self.place)
        self.assertIn("unfinished copy", refused.stderr)
        again = self.voxatlas("store", "copy", self.folder / "first", self.place)
        self.assertEqual(again.returncode, 0, again.stderr)
        tiles, now = map(int, re.search(r"(\d+) tiles, (\d+) of them", again.stdout).groups())
        self.assertLess(now, tiles)
        self.assertEqual(self.hashes_of(self.place), self.undisturbed)


if __name__ == "__main__":
    harness.main()
