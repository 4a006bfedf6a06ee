"""What services say of themselves while they work, and what the kernel says of them."""

import json
import os
import pathlib
import subprocess
import threading
import time

TICK = os.sysconf("SC_CLK_TCK")


def cpu_seconds(service):
    stat = pathlib.Path(f"/proc/{service.process.pid}/stat").read_text(encoding="ascii")
    fields = stat.rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def resident_bytes(service, field="VmRSS"):
    """Now, or with VmHWM at the most so far."""
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith(field + ":"))
    return int(line.split()[1]) * 1024


def folder_bytes(folder):
    """Blocks on disk; files may go while it looks."""
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.stat(os.path.join(place, name)).st_blocks * 512
            except FileNotFoundError:
                pass
    return total


class Sampler:
    """Samples a set of services each time its tile store has said how it is, twice a second.

    A sample: seconds since the start, scans applied, rays of the ingest, resident bytes of tile
    store and ingest, bytes of the model's folder, tiles in the tile store's cache.
    """

    def __init__(self, services):
        self.services = services
        self.samples = []
        self.rays = 0
        self.began = time.monotonic()
        self.watch = services.begin("watch", "status", "--json", stdout=subprocess.PIPE, text=True)
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def _read(self):
        for line in self.watch.stdout:
            status = json.loads(line)
            if status["service"] == "ingest":
                self.rays = status["counters"].get("rays", self.rays)
            elif status["service"] == "tilestore" and status["ready"]:
                self._sample(status["counters"])

    def _sample(self, counters):
        try:
            memory = {kind: resident_bytes(self.services.find(kind))
                      for kind in ("tilestore", "ingest")}
        except (FileNotFoundError, StopIteration):
            return  # The set is being stopped.
        self.samples.append({"seconds": time.monotonic() - self.began,
                             "scans": counters["scans_applied"], "rays": self.rays,
                             "disk": folder_bytes(self.services.data_dir),
                             "cached_tiles": counters["cached_tiles"], **memory})

    def stop(self):
        self.watch.terminate()
        self.thread.join()
        self.watch.stdout.close()
        return self.samples
