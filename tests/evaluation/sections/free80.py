"""The paper's section 6. Free space at 80 cm, as the paper has it."""

from mode import measure_mode, show_mode

NAME = "free80"
TITLE = "Section 6: the drive, free space at 80 cm"


def measure(job):
    return measure_mode(job, 4)


def show(page, values, _all):
    show_mode(page, NAME, values)
