"""Where processes spend their time, by Linux perf."""

import re
import shutil
import signal
import subprocess

LINE = re.compile(r"^\s*(\d+\.\d+)%\s+(\S+)\s+\[[.k]\]\s+(.+?)(?:\s+-)*\s*$")
MOST = 15


class Profile:
    """Records the processes of a set by their clock, from its making to finish()."""

    def __init__(self, services, file):
        if not shutil.which("perf"):
            raise SystemExit("evaluate: no perf here: run scripts/setup --evaluate first")
        self.file = file
        pids = ",".join(str(service.process.pid) for service in services.services)
        self.process = subprocess.Popen(
            ["perf", "record", "-q", "-e", "cpu-clock", "-F", "199", "-o", str(file), "-p", pids],
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def finish(self):
        """The functions that take most: share of all samples in percent, process, name."""
        self.process.send_signal(signal.SIGINT)
        _, said = self.process.communicate()
        if not self.file.exists():
            raise SystemExit(f"evaluate: perf recorded nothing: {said}")
        report = subprocess.run(["perf", "report", "-i", self.file, "--stdio", "-q", "--sort",
                                 "comm,symbol"], check=True, capture_output=True, text=True).stdout
        found = [LINE.match(line) for line in report.splitlines()]
        return [(float(m[1]), m[2], m[3].strip()) for m in found if m][:MOST]
