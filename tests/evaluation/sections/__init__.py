"""The sections of the report, in its order. Each is a module:

NAME            what --only calls it
TITLE           its heading
measure(job)    values that JSON can hold
show(page, values, all)   adds them to the report; `all` has every section's values by name
"""

from . import (index_parameters, depth_by_sigma, strategies, surface, free80, sampled80,
               carve10, drive, frames, one_tile, node_shares, codecs, truth, planet, lookup, targets)
from .summary import show_summary

ALL = [index_parameters, depth_by_sigma, strategies, surface, free80, sampled80, carve10,
       drive, frames, one_tile, node_shares, codecs, truth, planet, lookup, targets]

__all__ = ["ALL", "names", "show_summary"]


def names():
    return [section.NAME for section in ALL]
