"""The paper's section 7, figures 7 and 8, as the codec bench measures them."""

from page import number
from plot import plot

NAME = "codecs"
TITLE = "Section 7, figures 7 and 8: loss and sizes"
MOST_SCANS = 120
ROWS = ["points", "paper_raw_unpruned", "paper_lossless_unpruned", "paper_lossy_9_bits_unpruned",
        "paper_raw", "paper_lossless", "paper_lossy_9_bits", "octomap_ot", "octomap_bt",
        "voxatlas_fast", "voxatlas_dense", "voxatlas_lossy_9_bits", "voxatlas_lossy_6_bits"]


def measure(job):
    model = "real" if job.options.data else "sim"
    values = job.lines("bench_codec", "--only", model, *job.real_scans(), "--scans",
                       *([3, "--tiles", 4] if job.short else [min(job.options.scans, MOST_SCANS)]))
    values = {name.removeprefix(model + "_"): value for name, value in values.items()}
    values["real"] = bool(job.options.data)
    bits = range(1, 33)
    plot(job.pictures(), "figure7.svg", x="bits", y="mean log-odds discrepancy",
         series=[("levels between the clamps", [(b, values[f"figure7_{b}bits"]) for b in bits]),
                 ("bins of [0, 1]", [(b, values[f"figure7_{b}bits_unit"]) for b in bits])])
    plot(job.pictures(), "figure8.svg", x="", y="MiB", style="histogram",
         series=[("as they are", [(row.replace("_", " "), values[f"figure8_{row}"] / 2**20)
                                  for row in ROWS])])
    return values


def show(page, values, _all):
    kind = "the real scans" if values["real"] else "the simulated drive"
    page.text(f"The model of {kind}.")
    page.picture("figure7.svg", "Figure 7: mean discrepancy of log-odds against bits of probability.")
    chosen = [1, 2, 4, 6, 8, 9, 12, 16, 32]
    page.table(["bits", *map(str, chosen)],
               [[title, *(f"{values[f'figure7_{b}bits{end}']:.2g}" for b in chosen)]
                for title, end in (("levels between the clamps", ""), ("bins of [0, 1]", "_unit"))])
    page.text("The paper reads from its figure 7 that 6 bits are very close and 9 the best choice.")
    page.picture("figure8.svg", "Figure 8: sizes of the model.")
    points = values["figure8_points"]
    page.table(["figure 8", "MiB", "of the points", "MiB, zstd 3", "MiB, zstd 19"],
               [[row.replace("_", " "), number(values[f"figure8_{row}"] / 2**20),
                 f"{100 * values[f'figure8_{row}'] / points:.3g} %",
                 number(values[f"figure8_{row}_zstd3"] / 2**20),
                 number(values[f"figure8_{row}_zstd19"] / 2**20)] for row in ROWS])
    raw = values["figure8_paper_raw"]
    page.text(f"Saved on the pruned model: the paper's lossless format "
              f"{100 * (1 - values['figure8_paper_lossless'] / raw):.1f} % (paper: about 15 %), its lossy "
              f"one with 9 bits {100 * (1 - values['figure8_paper_lossy_9_bits'] / raw):.1f} %, our lossless "
              f"one {100 * (1 - values['figure8_voxatlas_dense'] / raw):.1f} %. The paper's largest model is an "
              f"order of magnitude smaller than its points; here the uncompressed one is "
              f"{points / raw:.2g} times smaller, our lossless one "
              f"{points / values['figure8_voxatlas_dense']:.3g} times.")
