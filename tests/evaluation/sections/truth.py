"""Beyond the paper: the model against what is really there."""

from page import number

NAME = "truth"
TITLE = "Beyond the paper: quality against the simulated truth"
SCENE_SCANS = 400  # Fixed before anything was tuned, as the city and the drive are.
RULES = {"default": "80 cm by one ray in 80, a cell with a hit of the same scan left alone (default)",
         "all_rays": "80 cm by every ray, likewise", "pushed": "80 cm, pushed into all finer cells",
         "carve": "10 cm", "surface": "none"}
TARGETS = {"recall": 0.75, "kept_poles": 0.90, "cleared_9": 0.97, "precision": 0.98}
COLUMNS = {"recall": "recall", "kept": "kept", "poles": "poles, recall", "kept_poles": "poles, kept",
           "cleared_9": "cleared, 9 looks", "cleared_any": "cleared, any look",
           "precision": "precision", "precision_then": "precision, vehicles that left allowed"}


def measure(job):
    return job.lines("bench_truth", "--scans", min(job.options.scans, SCENE_SCANS))


def show(page, values, _all):
    judged = values["scans"] >= SCENE_SCANS
    page.text(
        f"The simulated city and drive as they are by default, {number(values['scans'])} scans at 2 cm "
        "of noise; the truth is the same beams without it. Recall: occupied, of all voxels that such a "
        "beam ended in on something that never moves; kept: occupied, of those that are "
        "so without free space (the others noise has moved into the next cell, which no rule can "
        "help); poles: the same of lamps and signs. Cleared: not occupied, of the voxels of vehicles that have left and that at least 9 later scans see through "
        "(9 misses bring a cell from the upper clamp below zero), and of those that any later scan sees "
        "through. Precision: of all occupied voxels, those within a cell (their middle within 15 cm) "
        "of a surface at the end of the drive, and those within a cell of one or of a vehicle seen there "
        "before. Targets are the default rule's.")
    if not judged:
        page.text(f"Too few scans to judge: the scene has {SCENE_SCANS}.")
    rows = []
    for rule, title in RULES.items():
        def cell(what):
            shown = f"{values[f'{rule}_{what}']:.3f}"
            if rule != "default" or what not in TARGETS:
                return shown
            return page.judged(values[f"{rule}_{what}"], shown, TARGETS[what], judge=judged)
        rows.append([title, *(cell(what) for what in COLUMNS), number(values[f"{rule}_occupied"])])
    page.table(["free space", *COLUMNS.values(), "voxels occupied"], rows)
    page.text(f"Static voxels {number(values['default_statics'])}, of poles "
              f"{number(values['default_pole_voxels'])}; of vehicles that left "
              f"{number(values['default_trail_any'])}, seen through 9 times "
              f"{number(values['default_trail_9'])}.")
