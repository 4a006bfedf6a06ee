"""The paper's section 5, figures 4 and 5: nodes a layer, bits a node."""

from page import number
from plot import plot

NAME = "nodes"
TITLE = "Section 5, figures 4 and 5: shares of nodes per layer, bits per node"
FORMATS = [("raw", "uncompressed: 32 + 24 + 8 bits", "64 bits"),
           ("inner_colour", "leaf bit; inner nodes keep their colour", "15.6 % less"),
           ("lossless", "leaf bit; no payload in inner nodes", "15.6 % less"),
           ("lossy_1", "1 bit of probability, 1 bit a channel", "91.4 % less"),
           ("lossy_9_1", "9 bits of probability, 1 bit a channel", "80.5 % less"),
           ("lossy_9_8", "9 bits of probability, 8 bits a channel", "none")]


def measure(job):
    scans = min(job.options.scans, 200)
    values = job.lines("bench_nodes", "--scans", scans)
    plot(job.pictures(), "layers.svg", x="depth", y="share of nodes, %", style="histogram",
         series=[(title, [(depth, 100 * values[f"{kind}_layer_{depth}"]) for depth in range(8)])
                 for kind, title in (("full", "full octree"), ("model", "the drive's model"))])
    return values


def show(page, values, _all):
    page.table(["depth", *map(str, range(8))],
               [[title, *(f"{100 * values[f'{kind}_layer_{depth}']:.2g} %" for depth in range(8))]
                for kind, title in (("full", "full octree"), ("model", "the drive's model"))])
    page.text(f"In a full octree {100 * values['full_leaf_share']:.1f} % of all nodes are leaves "
              f"(paper: 87.5 %); in the model of the drive, pruned, "
              f"{100 * values['model_leaf_share']:.1f} % of {number(values['model_nodes'])}.")
    page.picture("layers.svg", "Figure 4: shares of nodes per layer.")
    page.table(["figure 5: bits a node", "full octree", "less than uncompressed", "the drive's model",
                "less", "paper"],
               [[title, number(values[f"full_{name}_bits_per_node"], 4),
                 f"{100 * values[f'full_{name}_reduction']:.1f} %",
                 number(values[f"model_{name}_bits_per_node"], 4),
                 f"{100 * values[f'model_{name}_reduction']:.1f} %", paper]
                for name, title, paper in FORMATS])
