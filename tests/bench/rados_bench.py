#!/usr/bin/env python3
"""The tile store in a Ceph cluster of one monitor and three OSDs on loopback, started for this.

rados_commit_vs_raw         tiles written over earlier versions, 32 a put, over librados doing the
                            same batches (rados_rates.cpp); _first_: new regions among them
rados_get_vs_raw            32 tiles a multi_get, likewise
rados_endtoend_vs_rocksdb   rays a second from the logger to durable, over the embedded store's
                            rate with the same scans

Lines are `name value unit`. A target that is missed is said so on standard error.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts" / "lib"), str(ROOT / "tests" / "system")]

from service_set import ServiceSet, default_bin_dir  # noqa: E402
from support import ceph  # noqa: E402

RATES = ("_raw_ours", "_raw_raw", "_rate")
TARGETS = {"rados_commit_vs_raw": 0.7, "rados_get_vs_raw": 0.7, "rados_endtoend_vs_rocksdb": 0.3}


def parse(arguments):
    parser = argparse.ArgumentParser(prog="bench store --rados", description=__doc__,
                                     allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", metavar="DIR", type=pathlib.Path,
                        help="scans in KITTI odometry form [a simulated drive]")
    parser.add_argument("--poses", metavar="FILE", default="poses.txt",
                        help="ecef_from_sensor, looked up in DIR first [%(default)s]")
    parser.add_argument("--scans", metavar="N", type=int, default=60,
                        help="of the simulated drive [%(default)s]")
    parser.add_argument("--turns", metavar="N", type=int, default=3,
                        help="end to end: so many runs of each, in turns; the median counts [3]")
    parser.add_argument("--json", action="store_true", help="one JSON object in place of lines")
    return parser.parse_args(arguments)


def publish_rate(place, scans, poses, store=None):
    """Rays a second until each is durable, in a fresh model."""
    with ServiceSet(place, renders=0, store=store) as services:
        told = json.loads(services.run("publish", scans, "--poses", poses, "--json", quiet=True))
    return told["rays"] / told["seconds"]


def median(values):
    return sorted(values)[len(values) // 2]


def end_to_end(cluster, scans, options):
    embedded, rados = [], []
    for turn in range(options.turns):
        for kind in (embedded, rados) if turn % 2 == 0 else (rados, embedded):
            with tempfile.TemporaryDirectory(prefix="voxatlas-bench-") as place:
                store = cluster.store(f"turn-{turn}") if kind is rados else None
                kind.append(publish_rate(place, scans, options.poses, store))
    return median([r / e for r, e in zip(rados, embedded)]), median(rados), median(embedded)


def main(arguments):
    options = parse(arguments)
    if ceph.missing():
        raise SystemExit("bench store --rados: " + ceph.missing())
    if not (default_bin_dir() / "rados_rates").exists():
        raise SystemExit("bench store --rados: built without librados (scripts/setup --rados)")
    figures = {}
    with tempfile.TemporaryDirectory(prefix="voxatlas-bench-") as place:
        scans = options.data or pathlib.Path(place) / "drive"
        if not options.data:
            subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(options.scans), "--out",
                            scans], check=True, stdin=subprocess.DEVNULL, capture_output=True)
        cluster = ceph.Cluster(pathlib.Path(place) / "ceph")
        try:
            cluster.start()
            rates = subprocess.run([default_bin_dir() / "rados_rates", cluster.conf, ceph.POOL],
                                   check=True, stdout=subprocess.PIPE, text=True).stdout
            for line in rates.splitlines():
                name, *values = line.split()
                for suffix, value in zip(("", "_ours", "_raw"), values):
                    figures[name + suffix] = float(value)
            name = "rados_endtoend_vs_rocksdb"
            for suffix, value in zip(("", "_rados_rate", "_rocksdb_rate"),
                                     end_to_end(cluster, scans, options)):
                figures[name + suffix] = value
        finally:
            cluster.stop()
    if options.json:
        print(json.dumps(figures))
    for name, value in figures.items():
        if not options.json:
            print(f"{name} {value:.4g} {'1/s' if name.endswith(RATES) else 'of_it'}")
        if value < TARGETS.get(name, 0):
            print(f"bench store --rados: {name} is {value:.3g}, the target is "
                  f"{TARGETS[name]} or more", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
