"""The paper's section 6. Surface points alone."""

from mode import measure_mode, show_mode

NAME = "surface"
TITLE = "Section 6: the drive, surface only"


def measure(job):
    return measure_mode(job, -1)


def show(page, values, _all):
    show_mode(page, NAME, values)
