"""The paper's section 3.3: sizes that follow from two wishes."""

from page import number

NAME = "index"
TITLE = "Section 3.3: parametrisations of the index"
PAPER = {"10/0.1": "7; 12.8 m; 12 800 km"}


def measure(job):
    return job.lines("bench_index")


def show(page, values, _all):
    page.text("Equations (1) to (4): the tiles' depth `d_tile`, their edge `l_tile`, the index's edge "
              "`l_index`, for wishes of a tile's size and of the finest cell.")
    wishes = dict.fromkeys(name.rpartition("/")[0] for name in values)
    page.table(
        ["tile wished for, m / cell, m", "d_tile", "l_tile, m", "l_index, km", "paper"],
        [[f"{wish.replace('/', ' / ')}{' (standard)' if wish in PAPER else ''}",
          f"{values[wish + '/d_tile']:.0f}", f"{values[wish + '/l_tile']:g}",
          f"{values[wish + '/l_index'] / 1000:,.4f}".rstrip("0").rstrip(".").replace(",", " "),
          PAPER.get(wish, "none")] for wish in wishes])
    tiles = values["10/0.1/l_index"] / values["10/0.1/l_tile"]
    page.text(f"The standard has {number(tiles)} tiles an axis.")
