"""The paper's section 6. Free space at 80 cm by one ray in 80, the default (libs/integrate)."""

from mode import measure_mode, show_mode

NAME = "sampled80"
TITLE = "Section 6: the drive, free space at 80 cm by one ray in 80"


def measure(job):
    return measure_mode(job, 4)


def show(page, values, _all):
    show_mode(page, NAME, values)
