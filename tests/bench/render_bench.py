#!/usr/bin/env python3
"""Pictures: how long they take by themselves, and what a client of the running service sees.

First bench_render (its options are passed on: --help shows them), on the simulated city or --data.
Then, with the real services: from a request to its frame at a subscriber, all tiles cached, less what
the frame itself took, alone and beside a client who asks a thousand times a second; and, while scans
are imported, from a change that is durable to the frame that shows it: at a sensor's rate, and as fast
as they can be.
"""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "lib"))

import drives  # noqa: E402
from service_set import ServiceSet, default_bin_dir  # noqa: E402

SCANS = 40  # Of the simulated drive, in the model before anything is measured,
MORE_SCANS = 160  # and imported while it is watched,
SENSOR_HZ = 20  # at most so many a second,
PASSES = 10  # or so many times over, as fast as they can be.


def run(services, program, *arguments, **options):
    return subprocess.run([default_bin_dir() / program, *map(str, arguments)], check=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                          env=services.env(), **options).stdout


def service_lines():
    with tempfile.TemporaryDirectory(prefix="voxatlas-bench-") as place:
        drive, again = pathlib.Path(place) / "drive", pathlib.Path(place) / "again"
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(MORE_SCANS), "--out", drive],
                       check=True, stdin=subprocess.DEVNULL, capture_output=True)
        drives.repeat(drive, "poses.txt", again, PASSES)
        with set_with_a_street(pathlib.Path(place) / "latency") as services:
            yield from run(services, "render_probe", "--view", "street", "latency").splitlines()
        for name, folder, pace in ((f"live_{SENSOR_HZ}hz_", drive, ["--hz", SENSOR_HZ]),
                                   ("live_", again, [])):
            with set_with_a_street(pathlib.Path(place) / name) as services:
                yield from live_lines(services, name, folder, pace)


@contextlib.contextmanager
def set_with_a_street(place):
    with ServiceSet(place) as services:
        services.run("publish", "--simulate", SCANS, quiet=True)
        yield services


def stolen_ms():
    """Processor time that the host has given to others, of all processors: where it grows while
    something is measured, that was slower than the machine is."""
    with open("/proc/stat", encoding="ascii") as stat:
        return int(stat.readline().split()[8]) * 1000 / os.sysconf("SC_CLK_TCK")


def live_lines(services, name, folder, pace):
    stolen = stolen_ms()
    with tempfile.TemporaryFile("w+") as out:
        importing = services.begin("publish", folder, "--poses", "poses.txt", "--source", name,
                                   "--json", *pace, stdout=out, stderr=subprocess.DEVNULL)
        shown = run(services, "render_probe", "--view", "street", "--budget", 40, "live")
        services.wait_for(importing)
        stolen = stolen_ms() - stolen
        out.seek(0)
        published = json.load(out)
    yield from (name + line.removeprefix("live_") for line in shown.splitlines())
    yield f"{name}scans_per_s {published['scans'] / published['seconds']:.4g} scans/s"
    for which in ("mean", "most"):
        yield f"{name}durable_{which}_ms {published[f'durable_after_ms_{which}']:.4g} ms"
    yield f"{name}stolen_ms {stolen:.4g} ms"


def main(arguments):
    as_json = "--json" in arguments
    passed_on = [argument for argument in arguments if argument != "--json"]
    if "--service-only" in passed_on:
        drawn = ""
    else:
        done = subprocess.run([default_bin_dir() / "bench_render", *passed_on], check=False,
                              stdout=subprocess.PIPE if as_json else None, text=True)
        if done.returncode != 0 or "--help" in passed_on:
            sys.exit(done.returncode)
        drawn = done.stdout or ""
    values = {}
    for line in drawn.splitlines():
        values |= dict([(line.split()[0], float(line.split()[1]))]) if len(line.split()) == 3 else {}
    for line in service_lines():
        name, value, _ = line.split()
        values[name] = float(value)
        if not as_json:
            print(line, flush=True)
    if as_json:
        print(json.dumps(values))


if __name__ == "__main__":
    main(sys.argv[1:])
