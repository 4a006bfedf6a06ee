#!/usr/bin/env python3
"""`voxatlas publish` of an LCM log, written by the types that lcm-gen makes for Python."""

import collections
import importlib
import signal
import struct
import subprocess
import sys
import time

from support import harness

from service_set import ServiceSet, default_bin_dir

SCANS = 3
POINTS_A_PART = 3900
# Between two parts, so that a receiver with a default buffer keeps up while it is played.
PACE_US = 30_000
# The recorder is a plain subscriber: on a busy machine it loses a part now and then, and says nothing.
RECORDINGS = 6
RECORDING_SECONDS = 10
EVENT_HEAD = struct.Struct(">Iqqii")
PATIENCE_SECONDS = 60


def parts_of(folder, scan_t, count):
    """The first scans of a folder as a logger publishes them: parts that fit a datagram."""
    times = (folder / "times.txt").read_text().split()
    poses = (folder / "poses.txt").read_text().splitlines()
    for seq, (taken, pose) in enumerate(zip(times[:count], poses)):
        returns = (folder / "velodyne" / f"{seq:06}.bin").read_bytes()
        points = [returns[i:i + 12] for i in range(0, len(returns), 16)]
        colours = (folder / "colours" / f"{seq:06}.bin").read_bytes()
        firsts = range(0, len(points), POINTS_A_PART)
        for part, first in enumerate(firsts):
            scan = scan_t()
            scan.utime = round(float(taken) * 1e6)
            scan.source, scan.session, scan.seq = "logger", 5, seq
            scan.part, scan.parts = part, len(firsts)
            scan.sigma, scan.min_range = 0.02, 2.5
            scan.ecef_from_sensor = [float(number) for number in pose.split()]
            some = points[first:first + POINTS_A_PART]
            scan.coloured, scan.count = 1, len(some)
            scan.points = b"".join(some) + colours[3 * first:3 * (first + len(some))]
            scan.size = len(scan.points)
            yield scan


def write_events(file, events):
    """A log of lcm-logger's format: (channel, message) each, heard at an even pace."""
    with open(file, "wb") as out:
        for number, (channel, message) in enumerate(events):
            data, utime = message.encode(), 1_000_000 + number * PACE_US
            out.write(EVENT_HEAD.pack(0xEDA1DA01, number, utime, len(channel), len(data)))
            out.write(channel + data)


def write_log(folder, scan_t, file, count):
    """The first scans of a folder."""
    write_events(file, ((b"VOXATLAS_SCAN", scan) for scan in parts_of(folder, scan_t, count)))


def clouds_of(folder, pose_t, pointcloud_t, count):
    """The first scans of a folder as MIT's bot_core has them, each after the pose it was taken at:
    a metre a scan eastwards in a local frame."""
    times = (folder / "times.txt").read_text().split()
    for seq in range(count):
        pose = pose_t()
        pose.utime = round(float(times[seq]) * 1e6)
        pose.pos, pose.orientation = [float(seq), 0.0, 2.0], [1.0, 0.0, 0.0, 0.0]
        yield b"POSE", pose
        cloud = pointcloud_t()
        cloud.utime, cloud.seq, cloud.frame_id = pose.utime, seq, "body"
        returns = (folder / "velodyne" / f"{seq:06}.bin").read_bytes()
        cloud.points = [point[:3] for point in struct.iter_unpack("<4f", returns)]
        cloud.n_points = len(cloud.points)
        colours = (folder / "colours" / f"{seq:06}.bin").read_bytes()
        cloud.channel_names = ["r", "g", "b"]
        cloud.channels = [[value / 255 for value in colours[i::3]] for i in range(3)]
        cloud.n_channels = 3
        yield b"CLOUD", cloud


def comes_within(seconds, fact):
    """Whether a fact that only a file tells of came to be."""
    end = time.monotonic() + seconds
    while not fact():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def channels_in(log):
    """How often each channel stands in a log, read by its format."""
    channels, at, data = collections.Counter(), 0, log.read_bytes()
    while at + EVENT_HEAD.size <= len(data):
        sync, _, _, name_bytes, data_bytes = EVENT_HEAD.unpack_from(data, at)
        assert sync == 0xEDA1DA01, f"{log}: no event at byte {at}"
        at += EVENT_HEAD.size
        channels[data[at:at + name_bytes].decode()] += 1
        at += name_bytes + data_bytes
    return channels


class Log(harness.SystemTest):
    def setUp(self):
        super().setUp()
        types, sources = harness.temporary_folder(self), harness.ROOT / "lcmtypes"
        subprocess.run(["lcm-gen", "--python", "--ppath", types, sources / "scan_t.lcm",
                        *(sources / "bot_core").glob("*.lcm")], check=True,
                       stdout=subprocess.DEVNULL)
        sys.path.insert(0, str(types))
        self.addCleanup(sys.path.remove, str(types))
        self.scan_t, self.pose_t, self.pointcloud_t = (
            getattr(importlib.import_module(f"{package}.{name}"), name)
            for package, name in (("voxatlas", "scan_t"), ("bot_core", "pose_t"),
                                  ("bot_core", "pointcloud_t")))
        self.drive = self.folder / "drive"
        subprocess.run([default_bin_dir() / "voxatlas", "simulate", str(SCANS), "--out",
                        self.drive], check=True, stdin=subprocess.DEVNULL, capture_output=True)
        self.log = self.folder / "drive.lcm"
        write_log(self.drive, self.scan_t, self.log, SCANS)

    def publish(self, services, *what):
        return subprocess.run([default_bin_dir() / "voxatlas", "publish", *what],
                              env=services.env(), capture_output=True, text=True, check=False,
                              stdin=subprocess.DEVNULL)

    def hashes_after(self, name, *publish, code=0):
        """The model's hashes when this was published twice: the second time adds nothing."""
        with ServiceSet(self.folder / name, renders=0) as services:
            for _ in range(2):
                done = self.publish(services, *publish)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertEqual("cut off" in done.stderr, code == 1, done.stderr)
            file = self.folder / f"{name}.txt"
            services.run("stat", "--hashes", file, quiet=True)
            return sorted(file.read_text().splitlines())

    def test_a_log_makes_the_model_that_its_folder_makes(self):
        expected = self.hashes_after("folder", self.drive, "--poses", "poses.txt")
        self.assertGreater(len(expected), 10)
        self.assertEqual(self.hashes_after("log", self.log), expected)

    def test_so_does_a_log_of_mits_clouds_and_poses(self):
        local = "\n".join(f"1 0 0 {i} 0 1 0 0 0 0 1 2" for i in range(SCANS))
        (self.drive / "local.txt").write_text(local + "\n")
        clouds = self.folder / "clouds.lcm"
        write_events(clouds, clouds_of(self.drive, self.pose_t, self.pointcloud_t, SCANS))
        alike = ["--origin", "48.1,11.5,500", "--sigma", "0.02", "--min-range", "2.5"]
        expected = self.hashes_after("folder", self.drive, "--poses", "local.txt", *alike)
        self.assertGreater(len(expected), 10)
        self.assertEqual(self.hashes_after("clouds", clouds, *alike), expected)

    def test_of_a_log_cut_off_the_whole_scans_count_and_the_rest_is_told(self):
        cut, fewer = self.folder / "cut.lcm", self.folder / "fewer.lcm"
        cut.write_bytes(self.log.read_bytes()[:-7])
        write_log(self.drive, self.scan_t, fewer, SCANS - 1)
        expected = self.hashes_after("fewer", fewer)
        self.assertEqual(self.hashes_after("cut", cut, code=1), expected)

    def record(self, services, file):
        """lcm-logger, once it has written down the first message of the set."""
        logger = subprocess.Popen(["lcm-logger", "--quiet", f"--lcm-url={services.bus.url}",
                                   "--flush-interval=20", file], stdin=subprocess.DEVNULL)
        self.addCleanup(logger.wait)
        self.addCleanup(logger.kill)
        self.assertTrue(comes_within(
            PATIENCE_SECONDS, lambda: file.exists() and file.stat().st_size > 0))
        return logger

    def recording(self, name):
        """What lcm-logger wrote down while the log was played to a new set, whole or not."""
        recorded, played = self.folder / f"{name}.lcm", channels_in(self.log)["VOXATLAS_SCAN"]
        with ServiceSet(self.folder / name, renders=0) as services:
            logger = self.record(services, recorded)
            subprocess.run(["lcm-logplayer", f"--lcm-url={services.bus.url}", self.log],
                           check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            whole = comes_within(RECORDING_SECONDS, lambda: (
                channels_in(recorded)["VOXATLAS_SCAN"] == played and
                channels_in(recorded)["VOXATLAS_TILE_UPDATE"] > 0))
            logger.send_signal(signal.SIGINT)
            self.assertEqual(logger.wait(PATIENCE_SECONDS), 0)
        return recorded, whole

    def test_what_lcm_logger_recorded_of_the_bus_makes_the_same_model(self):
        expected = self.hashes_after("folder", self.drive, "--poses", "poses.txt")
        for attempt in range(RECORDINGS):
            recorded, whole = self.recording(f"heard{attempt}")
            if whole:
                break
        self.assertTrue(whole, f"none of {RECORDINGS} recordings heard all that was played")
        heard = channels_in(recorded)
        for channel in ("VOXATLAS_STATUS", "VOXATLAS_TILE_UPDATE", "VOXATLAS_ACK"):
            self.assertGreater(heard[channel], 0, heard)
        self.assertEqual(self.hashes_after("again", recorded), expected)


if __name__ == "__main__":
    harness.main()
