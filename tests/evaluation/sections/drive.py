"""The paper's section 6: the modes of the drive beside the paper, and what 35 000 scans take."""

from mode import linearity, rate_between, settled
from page import number

from .modes import MODES

NAME = "drive"
TITLE = "Section 6: the drive beside the paper's"
PAPER_SCANS, PAPER_POINTS = 35_000, 715e6
PAPER = {"surface": ("37 min", 322_000), "free80": ("21 h 40 min", 9_200),
         "sampled80": ("none", None), "carve10": ("none", None)}
TITLES = {mode.NAME: mode.WHAT for mode in MODES}
LINEAR = (0.8, 1.25)  # Rays/s of the last quarter over the third one's.
MUST = {"free80": 1.0e6, "sampled80": 1.0e6, "carve10": 0.5e6}
PAPER_CORES, OUR_CORES = 12, 2


def measure(_job):
    return {}


def show(page, _values, all_values):
    page.text("The paper: two 64-beam scanners, 35 000 scans, 715 million points, 0.2 km2, 4619 tiles, "
              "12 cores at 3.5 GHz, 17.1 GiB of points. Here: the same drive simulated, every scan through "
              "the bus to durable tiles, with all services, the compressor too, on this machine.")
    rows = []
    for name, title in TITLES.items():
        values = all_values.get(name)
        if values:
            rows.append([title, *columns(page, name, values)])
    if not rows:
        page.text("None of the modes was measured.")
        return
    page.table(["mode", "scans", "points", "s", "points/s", "of the paper's, a core", "tiles",
                "tile store at most, MiB", "disk, MiB", "last / third quarter's rays/s",
                "35 000 scans take, extrapolated", "the paper took", "the paper's points/s"], rows)
    page.text("Extrapolated is the time of as many points as the paper's at the rate of the drive's second "
              "half, when caches are full and streets are seen again, and only where its two quarters "
              "were within 0.8 to 1.25 of one another, which also says how much the machine's noise is.")


def whole_drive(values):
    """What the paper's number of points takes, in words."""
    published, ratio = values["published"], linearity(values)
    if published["scans"] >= PAPER_SCANS:
        return f"{published['seconds'] / 60:.1f} min, measured"
    if ratio is None:
        return "too short to say"
    if not LINEAR[0] <= ratio <= LINEAR[1]:
        return f"**not linear (last / third quarter {ratio:.2f}): not extrapolated**"
    points = settled(values)
    return f"{PAPER_POINTS / rate_between(points[0], points[-1]) / 60:.1f} min, extrapolated"


def columns(page, name, values):
    published = values["published"]
    rate = published["rays"] / published["seconds"]
    shown = number(rate)
    if name in MUST:
        shown = page.judged(rate, shown, MUST[name], judge=published["scans"] >= 1000)
    time, paper_rate = PAPER[name]
    per_core = "none"
    if paper_rate:
        per_core = f"{rate / OUR_CORES / (paper_rate / PAPER_CORES):.3g} x"
    ratio = linearity(values)
    return [number(published["scans"]), number(published["rays"]), number(published["seconds"]), shown,
            per_core, number(values["stat"]["tiles"]),
            number(values["memory"]["tilestore 0"] / 2**20), number(values["disk"] / 2**20),
            "none" if ratio is None else f"{ratio:.2f}", whole_drive(values), time,
            number(paper_rate) if paper_rate else "none"]
