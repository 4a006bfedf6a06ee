#!/usr/bin/env python3
"""From the logger to the durable tile, through the bus, with the real services.

The scans are repeated until there are enough rays. Printed are `name value unit`: rays a second with
free space at 80 cm and carved at 10 cm, from the first scan sent to the last one durable; the carving
rate over OctoMap's, which integrates the first five scans alone, with neither bus nor disk; scans
that a separate process did not find in the stored marks; processor time of each process and bytes on
each channel, so that the next bottleneck is plain to see.
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

from channel_bytes import ChannelBytes

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "lib"))

import drives  # noqa: E402
from service_set import ServiceSet, default_bin_dir  # noqa: E402

CASES = {"free80": ["--free-depth", 4, "--all-rays-free", "true"],
         "sampled80": ["--free-depth", 4],  # By one ray in 80, the default.
         "carve10": ["--free-depth", 7]}
LEAST = {"free80_rays_per_s": 1e6, "carve10_rays_per_s": 0.5e6, "carve10_vs_octomap_inprocess": 20}
CITIES_APART_DEG = 1.0


def parse(arguments):
    parser = argparse.ArgumentParser(prog="bench endtoend", description=__doc__,
                                     allow_abbrev=False)
    parser.add_argument("--data", metavar="DIR", type=pathlib.Path,
                        help="scans in KITTI odometry form [a simulated drive]")
    parser.add_argument("--poses", metavar="FILE", default="poses.txt",
                        help="ecef_from_sensor, looked up in DIR first [%(default)s]")
    parser.add_argument("--million-rays", metavar="N", type=float, default=20,
                        help="at least so many in each case [%(default)s]")
    parser.add_argument("--only", choices=[*CASES, "scaling"],
                        help="one case; scaling, which is not run otherwise, publishes two drives "
                        "in different cities at once, into one store and into two")
    parser.add_argument("--ingest", metavar="M", type=int, default=1, help="ingests [1]")
    parser.add_argument("--stores", metavar="N", type=int, default=1, help="tile stores [1]")
    parser.add_argument("--json", action="store_true", help="one JSON object in place of lines")
    return parser.parse_args(arguments)


class Lines:
    """Figures as they come; as lines at once, or as one JSON object at the end."""

    def __init__(self, as_json):
        self.as_json = as_json
        self.values = {}

    def add(self, name, value, unit):
        self.values[name] = value
        if value < LEAST.get(name, value):
            print(f"bench endtoend: {name} is {value:.6g}, the target is {LEAST[name]:.6g}",
                  file=sys.stderr)
        if not self.as_json:
            print(f"{name} {value:.6g} {unit}", flush=True)

    def finish(self):
        if self.as_json:
            print(json.dumps(self.values))


def run(program, *arguments):
    return subprocess.run([default_bin_dir() / program, *map(str, arguments)], check=True,
                          stdin=subprocess.DEVNULL, capture_output=True, text=True).stdout


def cpu_seconds(services):
    """Of each process of the set, so far."""
    tick = os.sysconf("SC_CLK_TCK")
    seconds = {}
    for service in services.services:
        stat = pathlib.Path(f"/proc/{service.process.pid}/stat").read_text(encoding="ascii")
        fields = stat.rpartition(")")[2].split()
        seconds[service.name.replace(" ", "_")] = (int(fields[11]) + int(fields[12])) / tick
    return seconds


def children_cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def publish_all(services, folders, ingests):
    """Publishes all drives at once; rays and seconds from the first start to the last end."""
    running = [services.begin("publish", folder, "--poses", "poses.txt", "--ingests", ingests,
                              "--json", stdout=subprocess.PIPE, text=True) for folder in folders]
    results = []
    for process in running:
        results.append(json.loads(process.communicate()[0] or "{}"))
        if process.returncode != 0:
            raise SystemExit("bench endtoend: a publish failed")
    return sum(r["rays"] for r in results), max(r["seconds"] for r in results)


def lost_scans(model, folders, scans):
    """Scans generated minus scans whose marks are stored, by a process that reads the files."""
    marks = model / "marks.txt"
    run("voxatlas", "store", "stat", "--data-dir", model, "--marks", marks)
    rows = [line.split(" ", 3) for line in marks.read_text(encoding="utf-8").splitlines()]
    found = 0
    for folder in folders:
        found += min((int(seq) + 1 for _, seq, _, source in rows if source == folder.name),
                     default=0)
    return scans - found


def measure(folders, scans, how, options, stores):
    """One run of the set: its rate, lost scans, processor time and bytes."""
    with tempfile.TemporaryDirectory(prefix="voxatlas-bench-") as place:
        model = pathlib.Path(place)
        with ServiceSet(model, stores=stores, ingests=options.ingest, renders=0,
                        store_options=how) as services:
            multicast = services.bus.url.startswith("udpm:") and os.geteuid() == 0
            channels = ChannelBytes(max(stores, options.ingest)) if multicast else None
            before, children = cpu_seconds(services), children_cpu_seconds()
            rays, seconds = publish_all(services, folders, options.ingest)
            after = cpu_seconds(services)
            cpu = {name: after[name] - before[name] for name in after}
            cpu["publish"] = children_cpu_seconds() - children
            sent = channels.read() if channels else {}
        return {"rays": rays, "seconds": seconds, "cpu": cpu, "bytes": sent,
                "lost": lost_scans(model, folders, scans)}


def add_details(lines, name, result):
    for process, seconds in result["cpu"].items():
        lines.add(f"{name}_{process}_cpu", 100 * seconds / result["seconds"], "%")
    for channel, count in result["bytes"].items():
        lines.add(f"{name}_{channel}_bytes_per_ray", count / result["rays"], "bytes")


def run_cases(lines, folder, scans, options):
    lost = 0
    rates = {}
    for name, how in CASES.items():
        if options.only not in (None, name):
            continue
        result = measure([folder], scans, how, options, options.stores)
        rates[name] = result["rays"] / result["seconds"]
        lost += result["lost"]
        lines.add(f"{name}_rays_per_s", rates[name], "rays/s")
        add_details(lines, name, result)
    if "carve10" in rates:
        data = ["--data", options.data, "--poses", options.poses] if options.data else []
        said = run("bench_octomap", *data)
        octomap = float(said.split()[1])
        lines.add("octomap_inprocess_rays_per_s", octomap, "rays/s")
        lines.add("carve10_vs_octomap_inprocess", rates["carve10"] / octomap, "x")
    lines.add("lost_scans", lost, "scans")


def run_scaling(lines, folders, scans, options):
    rates = {}
    for stores in (1, 2):
        result = measure(folders, scans, CASES["free80"], options, stores)
        rates[stores] = result["rays"] / result["seconds"]
        lines.add(f"stores{stores}_rays_per_s", rates[stores], "rays/s")
        add_details(lines, f"stores{stores}", result)
        by_store = [s for name, s in result["cpu"].items() if name.startswith("tilestore")]
        lines.add(f"stores{stores}_busiest_share", max(by_store) / sum(by_store), "fraction")
        lines.add(f"stores{stores}_lost_scans", result["lost"], "scans")
    lines.add("stores2_vs_stores1", rates[2] / rates[1], "x")


def main(arguments):
    options = parse(arguments)
    lines = Lines(options.json)
    with tempfile.TemporaryDirectory(prefix="voxatlas-bench-") as place:
        source = options.data
        if source is None:
            source = pathlib.Path(place) / "simulated"
            run("voxatlas", "simulate", 40, "--out", source)
        passes = max(1, -(-int(options.million_rays * 1e6) // drives.rays_in(source)))
        cities = 2 if options.only == "scaling" else 1
        folders = [pathlib.Path(place) / f"city{i}" for i in range(cities)]
        scans = sum(drives.repeat(source, options.poses, folder, max(1, passes // cities),
                                  CITIES_APART_DEG * i) for i, folder in enumerate(folders))
        lines.add("scans", scans, "scans")
        if options.only == "scaling":
            run_scaling(lines, folders, scans, options)
        else:
            run_cases(lines, folders[0], scans, options)
    lines.finish()


if __name__ == "__main__":
    main(sys.argv[1:])
