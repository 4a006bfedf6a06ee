"""Runs `store_probe` (store_probe.cpp): a shard in a process that can be killed."""

import pathlib
import os
import re
import subprocess

PROBE = pathlib.Path(os.environ["VOX_BIN_DIR"]) / "store_probe"


class Writer:
    """`store_probe write`: commits until it is killed; `acknowledged` is the last scan it told."""

    def __init__(self, folder, *options):
        self.process = subprocess.Popen([PROBE, "write", folder, *options], text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.acknowledged = -1

    def read_until(self, scan):
        """Until the scan is acknowledged, or the writer has ended."""
        while self.acknowledged < scan and self._read_line():
            pass

    def kill(self):
        """Ends it with -9, and takes in what it had told by then. Returns its standard error."""
        self.process.kill()
        while self._read_line():
            pass
        told = self.process.stderr.read().splitlines()
        error = "\n".join(line for line in told if " info: " not in line)
        self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()
        return error

    def _read_line(self):
        told = re.fullmatch(r"A (\d+)\n", self.process.stdout.readline())
        if told:
            self.acknowledged = int(told[1])
        return told


def verify(folder, acknowledged):
    """What is wrong, in words; an empty text where nothing is."""
    done = subprocess.run([PROBE, "verify", folder, str(acknowledged)], capture_output=True,
                          text=True, check=False)
    return "" if done.returncode == 0 else done.stderr.strip() or f"exit code {done.returncode}"


def fill(folder, tiles, cache_mb):
    """The figures of `store_probe fill`, by name."""
    done = subprocess.run([PROBE, "fill", folder, str(tiles), str(cache_mb)], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return dict(line.split() for line in done.stdout.splitlines())


def kill_rounds(folder, rounds, rng, *options):
    """Writes and kills, again and again. Returns what was found wrong, in words."""
    acknowledged = -1
    for number in range(rounds):
        writer = Writer(folder, *options)
        writer.read_until(acknowledged + rng.randint(1, 30))
        error = writer.kill()
        acknowledged = max(acknowledged, writer.acknowledged)
        wrong = verify(folder, acknowledged) or error.strip()
        if wrong:
            return f"round {number}: {wrong}"
    return ""
