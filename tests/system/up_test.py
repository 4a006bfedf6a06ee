#!/usr/bin/env python3
"""scripts/up as a supervisor, over programs that only pretend to be services.

The pretenders say by a fifo that they run and write into one file in which order they were asked to
stop; `voxatlas watch` among them waits for as many words as it was told to.
"""

import os
import select
import signal
import stat
import subprocess
import sys
import time
import unittest

from support import harness

PRETENDER = r'''#!/usr/bin/env python3
import os, pathlib, signal, sys
here = pathlib.Path(__file__).parent
name = pathlib.Path(__file__).name
if name == "voxatlas":
    for _ in range(int(sys.argv[sys.argv.index("--until-ready") + 1])):
        os.read(os.open(here / "ready", os.O_RDWR), 1)
    sys.exit(0)
if "--probe" in sys.argv:
    works = (here / "works").read_text()
    if works.startswith("stalls") and os.popen("ip route show 224.0.0.0/4").read():
        os.write(os.open(here / "ready", os.O_RDWR), b".")
        signal.pause()
    print("nothing came back")
    sys.exit(0 if works and sys.argv[-1].startswith(works) else 1)
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
print(*(["ready 12345"] if name == "voxatlas-hub" else [name, *sys.argv[1:]]), flush=True)
if (here / "dies").read_text() == name:
    sys.exit("the disk is full")
os.write(os.open(here / "ready", os.O_RDWR), b".")
signal.sigwait({signal.SIGTERM})
with open(here / "order", "a") as order:
    order.write(name + "\n")
'''
PROGRAMS = ["voxatlas", "voxatlas-hub", "voxatlas-tilestore", "voxatlas-ingest",
            "voxatlas-compress", "voxatlas-render"]


class Up(harness.SystemTest):
    def setUp(self):
        super().setUp()
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for program in PROGRAMS:
            path = self.bin / program
            path.write_text(PRETENDER)
            path.chmod(path.stat().st_mode | stat.S_IXUSR)
        os.mkfifo(self.bin / "ready")
        (self.bin / "dies").write_text("")
        (self.bin / "works").write_text("udpm:")
        self.processes = []

    def up(self, *options):
        env = {k: v for k, v in os.environ.items() if k not in ("LCM_DEFAULT_URL", "VOX_NAMESPACE")}
        process = subprocess.Popen(
            [harness.SCRIPTS / "up", "--bin-dir", self.bin, "--data-dir", self.folder / "data",
             *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def lines_until_all_ready(self, process):
        lines = []
        for line in process.stdout:
            lines.append(line.strip())
            if "all ready" in line:
                return lines
        self.fail("\n".join([*lines, process.stderr.read()]))

    def wait_for_a_word(self):
        """A pretender says by the fifo that it runs, and no longer dies of SIGTERM."""
        os.read(os.open(self.bin / "ready", os.O_RDWR), 1)

    def stop(self, process):
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate()
        self.assertEqual(process.returncode, 0, err)
        return out

    def order(self):
        return (self.bin / "order").read_text().replace("voxatlas-", "").split()

    def test_every_service_gets_its_line_and_all_stop_in_order(self):
        process = self.up("--stores", "2", "--ingest", "2", "--free-depth", "7")
        lines = self.lines_until_all_ready(process)
        self.stop(process)
        names = [" ".join(line.split()[:3]) for line in lines[1:-1]]
        self.assertEqual(names, [f"{name} ready," for name in (
            "tilestore 0", "tilestore 1", "compress 0", "ingest 0", "ingest 1", "render 0")])
        self.assertEqual(self.order(), ["ingest", "ingest", "render", "compress", "tilestore",
                                        "tilestore"])
        log = (self.folder / "data" / "logs" / "tilestore-1.log").read_text()
        self.assertIn("--shard 1 --shards 2 --compressors 1 --free-depth 7", log)

    def test_ctrl_c_stops_as_term_does(self):
        process = self.up()
        self.lines_until_all_ready(process)
        process.send_signal(signal.SIGINT)
        process.communicate()
        self.assertEqual(process.returncode, 0)
        self.assertEqual(self.order()[-1], "tilestore")

    def test_the_services_end_with_a_supervisor_that_is_killed(self):
        process = self.up()
        pids = [int(line.split()[4].strip(","))
                for line in self.lines_until_all_ready(process)[1:-1]]
        ends = {os.pidfd_open(pid): pid for pid in pids}
        process.kill()
        outliving = []
        for end, pid in ends.items():
            self.addCleanup(os.close, end)
            if not select.select([end], [], [], 5)[0]:
                os.kill(pid, signal.SIGKILL)
                outliving.append(pid)
        self.assertEqual(outliving, [])
        self.assertEqual(sorted(self.order()), ["compress", "ingest", "render", "tilestore"])

    def test_a_service_that_ends_at_start_up_makes_up_fail_with_its_last_words(self):
        (self.bin / "dies").write_text("voxatlas-render")
        process = self.up()
        _, err = process.communicate()
        self.assertEqual(process.returncode, 1)
        self.assertIn("render 0 ended with exit code 1", err)
        self.assertIn("the disk is full", err)

    def test_a_service_that_is_killed_is_started_again_and_waits_longer_each_time(self):
        process = self.up()
        lines = self.lines_until_all_ready(process)
        pid = next(int(line.split()[4].strip(",")) for line in lines if line.startswith("ingest"))
        for wait in ("at once", "in 0.5 s", "in 1 s"):
            killed = time.monotonic()
            os.kill(pid, signal.SIGKILL)
            again = process.stdout.readline().split()
            self.assertEqual(again[1:5], ["ingest", "0", "started", "again,"])
            least = float(wait.split()[1]) if wait != "at once" else 0
            self.assertGreaterEqual(time.monotonic() - killed, least)
            pid = int(again[-1])
            self.wait_for_a_word()
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate()
        self.assertEqual(process.returncode, 0, err)
        self.assertEqual([line for line in err.splitlines() if "starts again" in line],
                         [f"up: ingest 0 starts again {wait}"
                          for wait in ("at once", "in 0.5 s", "in 1 s")])
        self.assertEqual(err.count("ingest 0 was ended by SIGKILL"), 3)

    def test_while_one_waits_to_be_started_again_another_is_started(self):
        process = self.up()
        lines = self.lines_until_all_ready(process)
        pids = {line.split()[0]: int(line.split()[4].strip(",")) for line in lines[1:-1]}
        for _ in range(3):
            os.kill(pids["ingest"], signal.SIGKILL)
            pids["ingest"] = int(process.stdout.readline().split()[-1])
            self.wait_for_a_word()
        os.kill(pids["ingest"], signal.SIGKILL)
        os.kill(pids["render"], signal.SIGKILL)
        self.assertIn("render 0 started again", process.stdout.readline())
        self.wait_for_a_word()
        self.stop(process)

    @unittest.skipUnless(harness.multicast_here(), "no network namespace of its own")
    def test_a_route_goes_away_again_when_up_is_stopped_while_it_tries_it(self):
        route = ["224.0.0.0/4", "dev", "lo"]
        subprocess.run(["ip", "route", "del", *route], check=True)
        self.addCleanup(subprocess.run, ["ip", "route", "replace", *route], check=True)
        (self.bin / "works").write_text("stalls where there is a route")
        process = self.up()
        self.wait_for_a_word()  # The route is being tried.
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
        self.assertEqual(process.returncode, 0, err)
        self.assertIn("SIGINT, stopping", out)
        shown = subprocess.run(["ip", "route", "show", route[0]], capture_output=True, check=True)
        self.assertEqual(shown.stdout, b"")

    def test_without_multicast_the_hub_carries_the_bus_and_ends_last(self):
        (self.bin / "works").write_text("")
        process = self.up()
        lines = self.lines_until_all_ready(process)
        self.stop(process)
        self.assertRegex(lines[0], r"^bus tcpq://127\.0\.0\.1:12345 .*nothing came back")
        self.assertEqual(self.order()[-1], "hub")
        url = lines[0].split()[1]
        log = (self.folder / "data" / "logs" / "ingest-0.log").read_text()
        self.assertIn(f"--url {url}", log)

    def test_a_url_that_was_asked_for_is_never_replaced(self):
        (self.bin / "works").write_text("")
        process = self.up("--url", "udpm://239.255.0.1:7000?ttl=0")
        _, err = process.communicate()
        self.assertEqual(process.returncode, 1)
        self.assertIn("udpm://239.255.0.1:7000?ttl=0: nothing came back", err)

    def test_a_data_folder_that_cannot_be_made_is_named(self):
        (self.folder / "data").write_text("a file")
        process = self.up()
        _, err = process.communicate()
        self.assertEqual(process.returncode, 1)
        self.assertIn(str(self.folder / "data"), err)

    def test_a_count_that_is_no_number_is_refused(self):
        process = self.up("--stores", "none")
        _, err = process.communicate()
        self.assertEqual(process.returncode, 2)
        self.assertIn("'none' is not a whole number above 0", err)


if __name__ == "__main__":
    harness.main()
