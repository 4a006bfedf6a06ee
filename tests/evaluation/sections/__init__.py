"""The sections of the report, in its order. Each is a module, or an object like one:

NAME            what --only calls it
TITLE           its heading
measure(job)    values that JSON can hold
show(page, values, all)   adds them to the report; `all` has every section's values by name
"""

from . import (index_parameters, depth_by_sigma, strategies, drive, frames, one_tile, node_shares,
               codecs, truth, planet, lookup, targets)
from .modes import MODES
from .summary import show_summary

ALL = [index_parameters, depth_by_sigma, strategies, *MODES, drive, frames, one_tile, node_shares,
       codecs, truth, planet, lookup, targets]

__all__ = ["ALL", "names", "show_summary"]


def names():
    return [section.NAME for section in ALL]
