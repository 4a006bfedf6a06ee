"""The paper's section 6. Free space at 80 cm by every ray, as the paper has it."""

from mode import measure_mode, show_mode

NAME = "free80"
TITLE = "Section 6: the drive, free space at 80 cm by every ray"


def measure(job):
    return measure_mode(job, 4, all_rays_free=True)


def show(page, values, _all):
    show_mode(page, NAME, values)
