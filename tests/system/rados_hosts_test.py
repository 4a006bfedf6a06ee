#!/usr/bin/env python3
"""Three hosts on a bridge, a cluster behind them: one is cut off for 20 s and comes back.

    host 0: ingest 0, tilestore 0, compress    host 1: ingest 1, tilestore 1
    host 2: renderer, publisher                the test's own: the cluster

The bus leaves its host with a TTL of 1, in chunks of 1 400 bytes. Hashes must equal those of an
embedded model on one host without faults.
"""

import json
import os
import subprocess
import time
import unittest

from support import ceph, harness, hosts
from support.publishing import PublishTest, tile_hashes

from service_set import Service, ServiceSet

URL = "udpm://239.255.76.67:7667?ttl=1"
CUT_SECONDS = 20
TAKE_OVER_SECONDS = 10
HOST_OF = {("ingest", 0): 0, ("tilestore", 0): 0, ("compress", 0): 0,
           ("ingest", 1): 1, ("tilestore", 1): 1, ("render", 0): 2}
UPDATES_BEFORE = 200


class SpreadSet(ServiceSet):
    """Each service on its host; the command line on the last one."""

    def __init__(self, machines, *arguments, **options):
        super().__init__(*arguments, **options)
        self.machines = machines

    def _service(self, kind, index, *options):
        service = super()._service(kind, index, *options)
        service.command = self.machines[HOST_OF[kind, index]].enter(*service.command)
        return service

    def command(self, *arguments):
        return self.machines[-1].enter(*super().command(*arguments))


@unittest.skipUnless(harness.multicast_here() and os.geteuid() == 0,
                     "no network namespace of its own: no bridge")
@unittest.skipUnless((ServiceSet("unused").bin_dir / "voxatlas-rados.so").exists(),
                     "built without librados (scripts/setup --rados)")
class SeveralHosts(PublishTest):
    SCANS = 60
    HZ = 2  # Half a minute: the 20 s lie within.
    SET = {"stores": 2, "ingests": 2, "renders": 0}

    @classmethod
    def setUpClass(cls):
        if ceph.missing():
            raise unittest.SkipTest("no cluster: " + ceph.missing())
        super().setUpClass()
        machines = hosts.Hosts(3)
        cls.machines = machines.__enter__()
        cls.addClassCleanup(machines.__exit__, None, None, None)
        cls.cluster = ceph.Cluster(harness.temporary_folder(cls), address=hosts.HERE)
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()

    def begin_publish(self, services, *options, drive=None):
        return super().begin_publish(services, "--ingests", "2", *options, drive=drive)

    def test_a_host_that_is_cut_off_and_comes_back_loses_nothing(self):
        services = SpreadSet(self.machines, self.folder, url=URL, stores=2, ingests=2,
                             store=self.cluster.store("hosts"))
        with services:
            self.check_places(services)
            updates = self.watch_tiles(services)
            publish = self.begin_publish(services)
            self.wait_for_updates(updates, UPDATES_BEFORE, publish)
            self.machines[1].cut_off()
            time.sleep(CUT_SECONDS)  # The fault itself, not a wait for something.
            self.assertIsNone(publish.poll(), "the publish was over while a store was away")
            self.machines[1].come_back()
            self.end_publish(publish)
            self.assertEqual(tile_hashes(services), self.undisturbed)
            picture = self.folder / "street.png"
            frame = json.loads(services.run("render", "--view", "street", "--size", "320x180",
                                            "--out", picture, "--json", quiet=True))
            self.assertEqual(frame["tiles_missing"], 0)
            self.assertTrue(picture.exists())

    def test_a_killed_store_is_replaced_on_another_host(self):
        services = SpreadSet(self.machines, self.folder, url=URL, stores=2, ingests=2,
                             store=self.cluster.store("moved"))
        with services:
            updates = self.watch_tiles(services)
            publish = self.begin_publish(services)
            self.wait_for_updates(updates, UPDATES_BEFORE, publish)
            first = services.find("tilestore", 1)
            bare = first.command[len(self.machines[1].enter()):]
            second = Service("tilestore", 1, self.machines[2].enter(*bare),
                             first.log_path.with_suffix(".moved.log"), first.env)
            watch = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
            self.addCleanup(watch.communicate)
            self.addCleanup(watch.kill)
            first.kill()
            began = time.monotonic()
            second.start(services.ended)
            services.services[services.services.index(first)] = second
            next(said for said in map(json.loads, watch.stdout)
                 if said["pid"] == second.process.pid and said["ready"])
            took = time.monotonic() - began
            print(f"replaced in {took:.1f} s", flush=True)
            self.assertLess(took, TAKE_OVER_SECONDS)
            self.assertIsNone(publish.poll(), "the publish was over before the store moved")
            self.end_publish(publish)
            self.assertEqual(tile_hashes(services), self.undisturbed)

    def check_places(self, services):
        """The services' sockets really are on different hosts: none is open here."""
        here = subprocess.run(["ss", "-Hunap"], capture_output=True, text=True, check=True).stdout
        for service in services.services:
            self.assertNotIn(f"pid={service.process.pid},", here)
        self.assertEqual(len({os.readlink(f"/proc/{service.process.pid}/ns/net")
                              for service in services.services}), 3)


if __name__ == "__main__":
    harness.main()
