#!/usr/bin/env python3
"""What every service tells of itself twice a second, and `voxatlas watch status` on a terminal."""

import collections
import fcntl
import json
import os
import pty
import re
import select
import statistics
import struct
import termios
import time

from support import harness

from service_set import ServiceSet

PATIENCE_SECONDS = 60
STREAMS_IN = {"in_held_bytes", "in_credit", "in_gaps"}
STREAMS_OUT = {"out_held_bytes", "out_credit", "out_resent"}
COUNTERS = {
    "tilestore": {"queue", "kernel_drops", "epoch", "scans_applied", "updates_published"}
    | STREAMS_IN | STREAMS_OUT,
    "ingest": {"queue", "kernel_drops", "scans_acknowledged"} | STREAMS_IN | STREAMS_OUT,
    "compress": {"queue", "kernel_drops", "tiles"} | STREAMS_IN | STREAMS_OUT,
    "render": {"requests_waiting", "kernel_drops", "frames"} | STREAMS_OUT,
    "hub": {"kernel_drops", "clients", "dropped", "out_held_bytes"},
}


class Status(harness.SystemTest):
    def statuses(self, services, count):
        """The next statuses of all services, by kind."""
        by_kind = collections.defaultdict(list)
        for line in services.run("watch", "status", "--json", "--count", count).splitlines():
            status = json.loads(line)
            by_kind[status["service"]].append(status)
        return by_kind

    def test_every_service_tells_twice_a_second_how_it_is(self):
        with ServiceSet(self.folder, hub=True) as services:
            services.run("publish", "--simulate", 3, quiet=True)
            by_kind = self.statuses(services, 40)
            self.assertEqual(set(by_kind), set(COUNTERS))
            for kind, statuses in by_kind.items():
                with self.subTest(kind):
                    last = statuses[-1]
                    self.assertEqual((last["ready"], last["state"]), (1, "ready"))
                    self.assertEqual(last["pid"], services.find(kind).process.pid)
                    self.assertRegex(last["version"], r"^\d+\.\d+")
                    self.assertLessEqual(COUNTERS[kind], set(last["counters"]))
                    sent = [status["utime"] / 1e6 for status in statuses]
                    between = [b - a for a, b in zip(sent, sent[1:])]
                    # Not the least: one that a busy machine held up has the next close behind it.
                    self.assertGreater(statistics.median(between), 0.4)
                    self.assertLess(statistics.median(between), 0.9)
            for kind in ("tilestore", "ingest"):
                counters = by_kind[kind][-1]["counters"]
                newest = {name: value for name, value in counters.items() if name.startswith("seq ")}
                self.assertEqual(list(newest.values()), [2], newest)

    def test_on_a_terminal_the_set_is_a_table_that_lives(self):
        with ServiceSet(self.folder) as services:
            terminal, inside = pty.openpty()
            self.addCleanup(os.close, terminal)
            fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 130, 0, 0))
            watch = services.begin("watch", "status", stdout=inside)
            os.close(inside)
            self.addCleanup(watch.wait)
            self.addCleanup(watch.kill)
            all_of_them = len(services.services)  # The hub is one more, where that is the bus.
            self.wait_for(terminal, rf"{all_of_them} of {all_of_them} services ready"
                          r"\s+service +state +version +pid[^\n]*\s+compress 0 +ready [^\n]*"
                          r"(\s+hub 0 +ready [^\n]*)?\s+ingest 0 +ready [^\n]*"
                          r"\s+render 0 +ready [^\n]*\s+tilestore 0 +ready [^\n]* epoch 1 ")
            services.find("compress").kill()
            shown = self.wait_for(terminal, rf"{all_of_them - 1} of {all_of_them} services "
                                  r"ready[^\x1b]*compress 0 +silent for")
            for line in shown.splitlines():
                self.assertLessEqual(len(line.replace("\x1b[H\x1b[J", "")), 130)
            services.find("compress").start(services.ended)
            self.wait_for(terminal, rf"{all_of_them} of {all_of_them} services ready")

    def wait_for(self, terminal, pattern):
        """Reads the terminal until a table like that is drawn; returns the last one."""
        text, end = "", time.monotonic() + PATIENCE_SECONDS
        while time.monotonic() < end:
            if select.select([terminal], [], [], 1)[0]:
                text += os.read(terminal, 65536).decode()
            text = text[-20000:]
            tables = text.split("\x1b[H\x1b[J")
            if len(tables) > 1 and re.search(pattern, tables[-1]):
                return tables[-1]
        self.fail(f"never on the terminal: {pattern}\n{text[-3000:]}")


if __name__ == "__main__":
    harness.main()
