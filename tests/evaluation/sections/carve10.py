"""The paper's section 6. Free space at 10 cm."""

from mode import measure_mode, show_mode

NAME = "carve10"
TITLE = "Section 6: the drive, free space at 10 cm"


def measure(job):
    return measure_mode(job, 7)


def show(page, values, _all):
    show_mode(page, NAME, values)
