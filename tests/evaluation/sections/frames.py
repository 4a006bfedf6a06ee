"""The paper's table 1 and figure 6: how long a picture takes at each depth."""

from page import number

NAME = "frames"
TITLE = "Table 1 and figure 6: pictures at each depth"
PAPER_MS = [3, 9, 19, 47, 165, 804, 3402, 10820]
MOST_SCANS = 1200  # Of the render bench's own drive: 20 m/s, fine in azimuth.
SMALL = ["--width", 320, "--height", 180, "--repeat", 3]
MUST_MS, NO_SLOWER = 40, 1.10


def measure(job):
    scans = 8 if job.short else min(job.options.scans, MOST_SCANS)
    values = job.lines("bench_render", "--scans", scans, "--no-far-field",
                       *(SMALL if job.short else []), "--out", job.pictures())
    values["judged"] = not job.short
    return values


def show(page, values, _all):
    page.text(f"{'320x180' if not values['judged'] else '1280x720'}, all within 100 m, {number(values['occupied_cells'])} occupied cells in "
              f"{number(values['tiles'])} tiles; one thread as in the paper; medians. Our default "
              "is two threads, shaded, as JPEG.")
    slowest = values["depth7_ms"]
    rows = []
    for depth, paper in enumerate(PAPER_MS):
        ms = values[f"depth{depth}_ms"]
        shown = page.judged(ms, f"{ms:.1f}", NO_SLOWER * slowest, at_least=False,
                            judge=values["judged"])
        rows.append([depth, shown, paper, f"{paper / ms:.3g} x"])
    page.table(["depth", "ms, one thread", "paper, ms", "faster"], rows)
    rows = []
    for view in ("street", "oblique", "aerial"):
        both = values[f"{view}_2t_jpeg_ms"]
        rows.append([view, number(values[f"{view}_1t_splat_ms"]), number(values[f"{view}_2t_splat_ms"]),
                     page.judged(both, number(both), MUST_MS, at_least=False, judge=values["judged"]),
                     number(values[f"{view}_2t_jpeg_best_ms"]), number(values[f"{view}_gl_ms"])])
    page.table(["view, depth 7", "one thread, ms", "two threads, ms",
                "two threads, shaded, JPEG (default), ms", "the best of them",
                "the paper's way, GL points, ms"], rows)
    page.picture("oblique_boxes.png", "Figure 6a: the model at 10 cm with the boxes of its tiles.")
    for depth in (4, 5, 6):
        page.picture(f"street_depth{depth}.png",
                     f"Figure 6b-d: depth {depth}, cells of {12.8 / 2**depth:g} m.")
    page.picture("street.png", "Figure 6e: depth 7, cells of 0.1 m.")
