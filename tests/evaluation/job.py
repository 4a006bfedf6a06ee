"""What a section needs to measure: programs, folders, the options of the run."""

import os
import subprocess

from service_set import default_bin_dir

SHORT_SCANS = 100


class Job:
    """One section's measuring. Folders are made when asked for."""

    def __init__(self, name, options):
        self.name = name
        self.options = options
        self.out = options.out
        self.load_before = os.getloadavg()[0]
        (self.out / "measured").mkdir(parents=True, exist_ok=True)

    @property
    def short(self):
        """A run to see that all works, not to judge by."""
        return self.options.scans < SHORT_SCANS

    def measured_file(self, name):
        return self.out / "measured" / f"{name}.json"

    def pictures(self):
        """Where pictures go; the report names them from its own folder."""
        folder = self.out / "pictures"
        folder.mkdir(exist_ok=True)
        return folder

    def work(self, name):
        """A folder for what later sections of the same run use again."""
        folder = self.out / "work" / name
        folder.parent.mkdir(exist_ok=True)
        return folder

    def real_scans(self, poses=None):
        """Options that give a benchmark the real scans, or none."""
        if not self.options.data:
            return []
        return ["--data", self.options.data, "--poses", poses or self.options.poses]

    def run(self, program, *arguments, env=None):
        """What a program prints; an error of its ends the evaluation."""
        done = subprocess.run([default_bin_dir() / program, *map(str, arguments)], check=False,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, env=env)
        if done.returncode != 0:
            raise SystemExit(f"evaluate: {program} {' '.join(map(str, arguments))} "
                             f"ended with exit code {done.returncode}")
        return done.stdout

    def lines(self, program, *arguments):
        """The values of a benchmark's lines `name value unit`, by name."""
        values = {}
        for line in self.run(program, *arguments).splitlines():
            name, value, *_ = line.split(" ", 2)
            values[name] = float(value)
        return values
