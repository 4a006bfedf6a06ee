"""The paper's section 4.2: depth against standard deviation, and what it does to real scans."""

import json
import math
import pathlib
import shutil

from page import number
from plot import plot
from samples import folder_bytes

from service_set import ServiceSet

NAME = "sigma"
TITLE = "Section 4.2: depth of integration by the scans' quality"
TILE = 12.8
CASES = {"refined": 0.02, "recorded": 0.5, "recorded_as_if_exact": 0.02}
VIEWS = ("street", "oblique")
EQUATOR, POLE = 6_378_137.0, 6_356_752.314245  # Half axes of WGS 84, m.


def depth(sigma):
    """Equation (5), for the plot alone; the tables show what the services did."""
    return min(math.floor(math.log2(TILE / (4 * sigma))), 7)


def place(ecef):
    """A place as the command line takes it: latitude, longitude, height above the ellipsoid."""
    x, y, z = ecef
    flat, e2 = math.hypot(x, y), 1 - (POLE / EQUATOR) ** 2
    latitude = math.atan2(z, flat * (1 - e2))
    for _ in range(10):  # Converges by a factor of some hundred a step.
        radius = EQUATOR / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
        height = flat / math.cos(latitude) - radius
        latitude = math.atan2(z, flat * (1 - e2 * radius / (radius + height)))
    return f"{math.degrees(latitude):.9f},{math.degrees(math.atan2(y, x)):.9f},{height:.3f}"


def street(job):
    """The view ahead from where the scanner was in the middle of the drive, the same for all: of
    cells of 1.6 m the program finds no street to stand on."""
    file = job.options.data / job.options.poses  # There first, as `publish` looks for it.
    if not file.exists():
        file = pathlib.Path(job.options.poses)
    rows = [line.split() for line in file.read_text().splitlines() if line.strip()]
    pose = [float(number) for number in rows[len(rows) // 2]]
    eye = pose[3::4]
    return ["--at", place(eye), "--look-at",
            place([e + 20 * ahead - 0.04 * e / EQUATOR * 20 for e, ahead in zip(eye, pose[0::4])])]


def measure(job):
    sigmas = [0.01 * 1.05 ** i for i in range(115)]
    plot(job.pictures(), "sigma.svg", x="standard deviation, m", y="depth", log="x", style="steps",
         series=[("equation (5)", [(sigma, depth(sigma)) for sigma in sigmas if depth(sigma) >= 0])])
    if not job.options.data:
        return {}
    values = {}
    for case, sigma in CASES.items():
        poses = job.options.poses if case == "refined" else job.options.recorded_poses
        values[case] = measure_case(job, case, sigma, poses)
    return values


def measure_case(job, case, sigma, poses):
    model = job.work(f"model-sigma-{case}")
    shutil.rmtree(model, ignore_errors=True)
    with ServiceSet(model) as services:
        published = json.loads(services.run("publish", job.options.data, "--poses", poses, "--sigma",
                                            sigma, "--json", quiet=True))
        stat = json.loads(services.run("stat", "--json"))
        for view in VIEWS:
            where = street(job) if view == "street" else ["--view", view]
            services.run("render", *where, "--out",
                         job.pictures() / f"sigma_{case}_{view}.png", quiet=True)
    disk = folder_bytes(model)
    shutil.rmtree(model)
    return {"sigma": sigma, "poses": str(poses), "published": published, "stat": stat, "disk": disk}


def show(page, values, _all):
    page.picture("sigma.svg", "Depth of integration against the standard deviation, equation (5).")
    if not values:
        page.text("No real scans were given (--data): their part is missing.")
        return
    page.text("The real scans by their recorded poses, wrong by decimetres to metres, told as 0.5 m; by "
              "refined poses, told as 0.02 m; and what the recorded poses do when told as exact. The "
              "paper gives no figures here.")
    page.table(["poses", "sigma, m", "points", "tiles", "leaves occupied", "leaves free",
                "voxels occupied", "encoded bytes", "folder, bytes"],
               [[case.replace("_", " "), f"{v['sigma']:g}", number(v["published"]["rays"]),
                 number(v["stat"]["tiles"]), number(v["stat"]["occupied_leaves"]),
                 number(v["stat"]["free_leaves"]), number(v["stat"]["occupied_voxels"]),
                 number(v["stat"]["encoded_bytes"]), number(v["disk"])]
                for case, v in values.items()])
    for case in values:
        for view in VIEWS:
            page.picture(f"sigma_{case}_{view}.png", f"{case.replace('_', ' ')}: {view} view.")
