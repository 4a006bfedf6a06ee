"""The drive of the paper's section 6 in one way to treat free space, through the bus to the disk."""

import json
import shutil
import time

from page import number
from perf_profile import Profile
from plot import plot
from samples import Sampler, cpu_seconds, folder_bytes, resident_bytes

from service_set import ServiceSet

AZIMUTH_STEP_DEG = 1.1  # 20 000 points a scan, as in the paper.
CACHE_MB = 2048  # At 10 cm the tiles around the car alone take 420; five eighths are for tiles.
VIEWS = ("street", "oblique")


def drive_folder(job):
    """The simulated scans, made once for all modes."""
    folder = job.work(f"drive-{job.options.scans}")
    if not folder.exists():
        part = folder.with_name(folder.name + ".part")
        shutil.rmtree(part, ignore_errors=True)
        job.run("voxatlas", "simulate", job.options.scans, "--azimuth-step", AZIMUTH_STEP_DEG,
                "--out", part)
        part.rename(folder)
    return folder


def measure_mode(job, free_depth, all_rays_free=False):
    folder = drive_folder(job)
    model = job.work(f"model-{job.name}")
    shutil.rmtree(model, ignore_errors=True)
    how = ["--free-depth", free_depth, "--all-rays-free", "true" if all_rays_free else "false"]
    with ServiceSet(model, store_options=["--cache-mb", CACHE_MB, *how]) as services:
        profile = None
        if job.options.perf:
            profile = Profile(services, job.work(f"{job.name}.perf"))
        before = {s.name: cpu_seconds(s) for s in services.services}
        sampler = Sampler(services)
        began = time.monotonic()
        published = json.loads(services.run("publish", folder, "--poses", "poses.txt",
                                            "--min-range", 0, "--json", quiet=True))
        seconds = time.monotonic() - began
        samples = sampler.stop()
        cpu = {s.name: cpu_seconds(s) - before[s.name] for s in services.services}
        functions = profile.finish() if profile else []
        memory = {s.name: resident_bytes(s, "VmHWM") for s in services.services}
        stat = json.loads(services.run("stat", "--json"))
        for view in VIEWS:
            services.run("render", "--view", view, "--out",
                         job.pictures() / f"{job.name}_{view}.png", quiet=True)
    disk = folder_bytes(model)
    shutil.rmtree(model)
    values = {"published": published, "command_seconds": seconds, "cpu": cpu, "memory": memory,
              "stat": stat, "disk": disk, "samples": samples, "functions": functions,
              "input_bytes": folder_bytes_of_points(folder)}
    plot_samples(job, samples)
    return values


def folder_bytes_of_points(folder):
    return sum(file.stat().st_size for file in (folder / "velodyne").iterdir())


def rates(samples, parts=35):
    """(scans, rays/s) over equal parts of the drive."""
    moving = [s for s in samples if s["rays"] > 0]
    step = max(1, len(moving) // parts)
    ends = moving[::step]
    return [(b["scans"], (b["rays"] - a["rays"]) / (b["seconds"] - a["seconds"]))
            for a, b in zip(ends, ends[1:]) if b["rays"] > a["rays"]]


def plot_samples(job, samples):
    points = rates(samples) or [(0, 0)]
    plot(job.pictures(), f"{job.name}_rate.svg", x="scans", y="million rays/s",
         series=[("rays/s", [(scans, rate / 1e6) for scans, rate in points])])
    series = [(title, [(s["scans"], s[kind] / 2**20) for s in samples if s["scans"] > 0] or [(0, 0)])
              for kind, title in (("tilestore", "tile store, resident"),
                                  ("ingest", "ingest, resident"), ("disk", "the model's folder"))]
    plot(job.pictures(), f"{job.name}_memory.svg", x="scans", y="MiB", series=series, style="lines")


def settled(values):
    """Samples of the drive's second half: caches are full, and tiles come back that were left. None
    where there are too few."""
    points = [s for s in values["samples"] if 0 < s["rays"] < values["published"]["rays"]]
    return points[len(points) // 2:] if len(points) >= 16 else None


def rate_between(first, last):
    return (last["rays"] - first["rays"]) / (last["seconds"] - first["seconds"])


def linearity(values):
    """Rays/s of the drive's last quarter over the third one's: 1 is a cost that grows with the drive
    alone. None where there are too few samples."""
    points = settled(values)
    if points is None:
        return None
    middle = points[len(points) // 2]
    return rate_between(middle, points[-1]) / rate_between(points[0], middle)


def show_mode(page, name, values):
    published, stat = values["published"], values["stat"]
    page.table(["what", "figure"], [
        ["scans, each durable", f"{number(published['durable'])} of {number(published['scans'])}"],
        ["points", number(published["rays"])],
        ["seconds, first scan sent to last one durable", number(published["seconds"])],
        ["points/s", number(published["rays"] / published["seconds"])],
        ["points per second of processor time, all services",
         number(published["rays"] / sum(values["cpu"].values()))],
        ["tiles", number(stat["tiles"])],
        ["voxels occupied / free", f"{number(stat['occupied_voxels'])} / {number(stat['free_voxels'])}"],
        ["encoded bytes of tiles", number(stat["encoded_bytes"])],
        ["folder when stopped, bytes", number(values["disk"])],
        ["points as floats, bytes", number(published["rays"] * 16)],
        ["processor time, s", ", ".join(f"{n} {s:.1f}" for n, s in values["cpu"].items())],
        ["resident at most, MiB", ", ".join(f"{n} {b / 2**20:.0f}"
                                            for n, b in values["memory"].items())]])
    page.picture(f"{name}_rate.svg", "Rays a second over the scans.")
    page.picture(f"{name}_memory.svg", "Memory and disk over the scans.")
    ratio = linearity(values)
    if ratio is not None:
        page.text(f"The last quarter of the drive went at {ratio:.2f} times the third one's rays/s.")
    for view in VIEWS:
        page.picture(f"{name}_{view}.png", f"The model: {view} view.")
    if values["functions"]:
        page.text("Where the services' time went (perf, by the processor's clock):")
        page.table(["function", "process", "share"],
                   [[f"`{function}`", process, f"{share:.1f} %"]
                    for share, process, function in values["functions"]])
