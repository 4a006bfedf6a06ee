"""The paper's section 6: the drive, once for each way to treat free space."""

from mode import measure_mode, show_mode


class Mode:
    """A section of the report."""

    def __init__(self, name, what, *how):
        self.NAME, self.WHAT, self.how = name, what, how
        self.TITLE = f"Section 6: the drive, {what}"

    def measure(self, job):
        return measure_mode(job, *self.how)

    def show(self, page, values, _all):
        show_mode(page, self.NAME, values)


MODES = [Mode("surface", "surface only", -1),
         Mode("free80", "free space at 80 cm by every ray, as the paper's", 4, True),
         Mode("sampled80", "free space at 80 cm by one ray in 80, the default", 4),
         Mode("carve10", "free space at 10 cm", 7)]
