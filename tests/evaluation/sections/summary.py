"""What stands first: the machine, what the figures are worth, and the whole comparison in one table."""

from page import number

from . import drive, frames, truth

NOT_MEASURED = "not measured"


def show_summary(page, measured):
    page.text("Gehrung, Hebel, Arens, Stilla, `A framework for voxel-based global scale modeling of urban "
              "environments`: each of its tables and figures measured again on this system, beside the "
              "paper's own numbers. Where a target of the project is missed, it stands in bold.")
    for machine in dict.fromkeys(kept["machine"] for kept in measured.values()):
        page.text(f"Machine: {machine}. The paper's: an Intel Core i7, 12 cores at 3.5 GHz, 32 GiB.")
    loads = [kept["load_before"] for kept in measured.values()]
    page.text(f"Noise: load averages were {min(loads):.1f} to {max(loads):.1f} before the sections began "
              "(0 is a quiet machine); where a section repeats a measurement, it says how far "
              "repetitions lie apart. Take ratios before times.")
    values = {name: kept["values"] for name, kept in measured.items()}
    page.section("All of it in one table")
    page.table(["what", "paper", "here"], list(comparison(page, values)))


def comparison(page, values):
    """Rows of what the paper says and what was measured, of the sections that were."""
    for name, rows in (("drive", _drive_rows), ("frames", _frame_rows), ("nodes", _node_rows),
                       ("codecs", _codec_rows), ("truth", _truth_rows), ("planet", _planet_rows),
                       ("lookup", _lookup_rows)):
        if name in values:
            yield from rows(page, values)


def _drive_rows(page, values):
    for name, title in drive.TITLES.items():
        if name not in values:
            yield f"{title}, points/s", drive.PAPER[name][1] or "none", NOT_MEASURED
            continue
        published = values[name]["published"]
        rate = published["rays"] / published["seconds"]
        time, paper_rate = drive.PAPER[name]
        shown = f"{number(rate)} (2 cores)"
        if name in drive.MUST:
            shown = page.judged(rate, shown, drive.MUST[name], judge=published["scans"] >= 1000)
        yield (f"{title}, points/s", f"{number(paper_rate)} (12 cores)" if paper_rate else "none", shown)
        yield (f"{title}, 35 000 scans take", time, drive.whole_drive(values[name]))
        yield (f"{title}, tiles / disk", "4 619 tiles (35 000 scans)" if name == "free80" else "none",
               f"{number(values[name]['stat']['tiles'])} / {values[name]['disk'] / 2**20:.0f} MiB "
               f"({number(published['scans'])} scans)")


def _frame_rows(_page, values):
    times = values["frames"]
    yield ("picture at depth 0, 1, ... 7, one thread, ms", ", ".join(map(str, frames.PAPER_MS)),
           ", ".join(f"{times[f'depth{depth}_ms']:.1f}" for depth in range(8)))


def _node_rows(_page, values):
    nodes = values["nodes"]
    yield ("leaves among the nodes of a full octree", "87.5 %", f"{100 * nodes['full_leaf_share']:.1f} %")
    yield ("saved by the leaf bit, full octree, inner colour kept / dropped", "15.6 %",
           f"{100 * nodes['full_inner_colour_reduction']:.1f} / {100 * nodes['full_lossless_reduction']:.1f} %")
    yield ("saved with 1 bit a value / with 9 bits of probability", "91.4 / 80.5 %",
           f"{100 * nodes['full_lossy_1_reduction']:.1f} / {100 * nodes['full_lossy_9_1_reduction']:.1f} %")


def _codec_rows(_page, values):
    codecs = values["codecs"]
    yield ("mean log-odds discrepancy at 6 / 9 bits", "very low / best choice",
           f"{codecs['figure7_6bits']:.2g} / {codecs['figure7_9bits']:.2g}")
    raw, points = codecs["figure8_paper_raw"], codecs["figure8_points"]
    yield ("points over the uncompressed model / over our lossless one", "about 10 x / none",
           f"{points / raw:.2g} x / {points / codecs['figure8_voxatlas_dense']:.3g} x")
    yield ("saved by the paper's lossless format / by ours, pruned model", "about 15 % / none",
           f"{100 * (1 - codecs['figure8_paper_lossless'] / raw):.1f} / "
           f"{100 * (1 - codecs['figure8_voxatlas_dense'] / raw):.1f} %")


def _truth_rows(page, values):
    quality = values["truth"]
    judge = quality["scans"] >= truth.SCENE_SCANS
    shown = [page.judged(quality[f"default_{name}"], f"{quality[f'default_{name}']:.3f}", target,
                         judge=judge) for name, target in truth.TARGETS.items()]
    yield "recall / poles kept / vehicle's trail cleared / precision", "none", " / ".join(shown)


def _planet_rows(_page, values):
    planet = values["planet"]
    sound = planet["differing"] == 0 and planet["verified"]
    yield ("drives in seven places of the Earth, one model", "none",
           f"{number(planet['stat']['tiles'])} tiles, "
           + ("the same after a restart, verified" if sound else "**not the same after a restart**"))


def _lookup_rows(_page, values):
    counts = sorted({int(name.split("_")[0]) for name in values["lookup"] if name[0].isdigit()})
    yield (f"lookup of a tile among {' / '.join(map(number, counts))}, microseconds", "none",
           " / ".join(number(values["lookup"][f"{count}_store"]) for count in counts))
