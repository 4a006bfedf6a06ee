"""The paper's figure 3: occupied and free cells of one tile."""

from page import number

NAME = "tile"
TITLE = "Figure 3: one tile"


def measure(job):
    scans = min(job.options.scans, 200)
    return job.lines("bench_nodes", "--scans", scans, "--out", job.pictures())


def show(page, values, _all):
    page.text(f"The fullest tile of the simulated drive: {number(values['tile_occupied_voxels'])} "
              f"voxels occupied in {number(values['tile_occupied_leaves'])} leaves, "
              f"{number(values['tile_free_voxels'])} free in {number(values['tile_free_leaves'])}.")
    page.picture("tile_occupied.png", "Occupied cells at 10 cm, with the tile's edges.")
    page.picture("tile_free.png", "The same with free space at 80 cm.")
