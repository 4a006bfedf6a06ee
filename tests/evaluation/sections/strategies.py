"""The paper's section 4.1: its two strategies of importing rays."""

from page import number

NAME = "strategies"
TITLE = "Section 4.1: ray-based against tile-based"
ROWS = {"ray": "ray-based (ours), 1 thread", "tile_1t": "tile-based, a scan at a time, 1 thread",
        "tile_2t": "tile-based, a scan at a time, 2 threads",
        "tile_all_2t": "tile-based, all scans at once, 2 threads"}
MOST_SCANS = 10  # The tile-based strategy takes seconds a scan.


def measure(job):
    scans = 1 if job.short else MOST_SCANS
    return job.lines("bench_strategy", "--scans", scans, *job.real_scans())


def show(page, values, _all):
    page.text(f"{number(values['scans'])} scans, {number(values['rays'])} rays. The paper: the ray-based "
              "strategy performed best in time and memory, the tile-based one was a few orders of "
              "magnitude slower, likely as the machine swapped. Here both are in memory; the "
              "tile-based one updates the octree for every ray that passes a cell, so its cells "
              "count more than once a scan and its model differs.")
    whole = values["free10_tile_all_2t_queue_bytes"] / values["scans"] * 35_000
    page.text(f"Queued all at once, the rays of 35 000 such scans would take {number(whole / 2**30)} GiB: "
              "that is where the paper's machine, of 32 GiB, swapped.")
    for case, title in (("free80", "free space at 80 cm"), ("free10", "free space at 10 cm")):
        base = values[f"{case}_ray_seconds"]
        page.table([title, "s", "rays/s", "times as long", "memory at most, MiB", "rays queued, MiB",
                    "voxels occupied"],
                   [[text, number(values[f"{case}_{row}_seconds"]),
                     number(values[f"{case}_{row}_rays_per_s"]),
                     number(values[f"{case}_{row}_seconds"] / base),
                     number(values[f"{case}_{row}_peak_bytes"] / 2**20),
                     number(values[f"{case}_{row}_queue_bytes"] / 2**20),
                     number(values[f"{case}_{row}_occupied"])] for row, text in ROWS.items()])
