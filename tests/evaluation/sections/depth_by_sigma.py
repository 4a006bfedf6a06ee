"""The paper's section 4.2: depth against standard deviation, and what it does to real scans."""

import json
import math
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


def depth(sigma):
    """Equation (5), for the plot alone; the tables show what the services did."""
    return min(math.floor(math.log2(TILE / (4 * sigma))), 7)


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
            services.run("render", "--view", view, "--out",
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
