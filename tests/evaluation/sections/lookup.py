"""Beyond the paper: what finding a tile costs, against how many there are."""

from page import number
from plot import plot

NAME = "lookup"
TITLE = "Beyond the paper: cost of a tile lookup"
COLUMNS = [("store", "store"), ("atlas", "atlas, decoded"), ("atlas_cached", "atlas, cached"),
           ("absent", "no such tile")]


def measure(job):
    tiles = 10_000 if job.short else 10_000_000
    values = job.lines("bench_lookup", "--tiles", tiles)
    counts = counts_of(values)
    plot(job.pictures(), "lookup.svg", x="tiles", y="microseconds a lookup", log="x",
         series=[(title, [(count, values[f"{count}_{name}"]) for count in counts])
                 for name, title in COLUMNS])
    return values


def counts_of(values):
    return sorted({int(name.split("_")[0]) for name in values if name[0].isdigit()})


def show(page, values, _all):
    page.text(f"Simulated keys in patches of 1 024 tiles all over the Earth, "
              f"{number(values['tile_bytes'])} bytes a tile, RocksDB on this machine's disk; medians of "
              "2 000 random lookups, microseconds. The operating system may hold the files.")
    page.table(["tiles", *(title for _, title in COLUMNS), "disk, MiB", "resident, MiB"],
               [[number(count), *(number(values[f"{count}_{name}"]) for name, _ in COLUMNS),
                 number(values[f"{count}_disk"] / 2**20),
                 number(values[f"{count}_resident"] / 2**20)] for count in counts_of(values)])
    page.picture("lookup.svg", "Median time of a lookup against the number of tiles.")
