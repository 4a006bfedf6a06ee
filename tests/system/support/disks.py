"""Disks that fail: ext4 on a loop device on a file that nbdkit serves by FUSE. Root only."""

import os
import pathlib
import shutil
import signal
import subprocess
import time

TOOLS = ["nbdkit", "nbdfuse", "mkfs.ext4", "losetup", "mount", "umount"]
DISK_BYTES = 1 << 30
PATIENCE = 20


def missing():
    """Why there can be no such disk here, in words; empty where there can."""
    if os.geteuid() != 0:
        return "it takes root"
    absent = [tool for tool in TOOLS if not shutil.which(tool)]
    if absent:
        return "not installed: " + ", ".join(absent)
    return "" if pathlib.Path("/dev/fuse").exists() else "no /dev/fuse"


def wait_until(fact, what):
    """For facts no descriptor tells of: a file that another program makes."""
    end = time.monotonic() + PATIENCE
    while not fact():
        if time.monotonic() > end:
            raise AssertionError(f"{what} did not happen within {PATIENCE} s")
        time.sleep(0.02)


class Disk:
    """`mount` is where the file system hangs between up() and down()."""

    server = []  # What nbdkit serves the image through.
    features = []

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.mount = self.folder / "mount"
        self.mount.mkdir()
        self.image = self.folder / "image"
        with open(self.image, "wb") as image:
            image.truncate(DISK_BYTES)
        subprocess.run(["mkfs.ext4", "-q", "-F", *self.features, self.image], check=True)
        self.processes = []
        self.loop = None
        self.is_up = False

    def up(self):
        socket, volume = self.folder / "socket", self.folder / "volume"
        socket.unlink(missing_ok=True)
        volume.write_bytes(b"")
        filter_name, *settings = self.server
        self._start("nbdkit", "-f", "-U", socket, filter_name, "file", self.image, *settings,
                    env={"TMPDIR": self.folder})
        wait_until(socket.exists, "nbdkit")
        self._start("nbdfuse", volume, "--unix", socket)
        wait_until(lambda: volume.stat().st_size == DISK_BYTES, "nbdfuse")
        self.loop = subprocess.run(["losetup", "-f", "--show", volume], check=True, text=True,
                                   capture_output=True).stdout.strip()
        subprocess.run(["mount", "-t", "ext4", self.loop, self.mount], check=True)
        self.is_up = True

    def _start(self, *command, env=None):
        with open(self.folder / f"{command[0]}.log", "ab") as log:
            self.processes.append(subprocess.Popen(
                [str(part) for part in command], stdout=log, stderr=log,
                env={**os.environ, **{k: str(v) for k, v in (env or {}).items()}}))

    def stand_still(self):
        """It answers nothing, until go_on()."""
        self.processes[0].send_signal(signal.SIGSTOP)

    def go_on(self):
        self.processes[0].send_signal(signal.SIGCONT)

    def down(self):
        """Takes all away; in peace (unmounting writes everything), or what a fault has left."""
        if not self.is_up:
            return
        self.go_on()
        self.is_up = False
        run = lambda *command: subprocess.run(command, check=False, capture_output=True)
        if run("umount", self.mount).returncode != 0:
            run("umount", "-l", self.mount)
        run("sync", "-f", self.folder)
        run("losetup", "-d", self.loop)
        run("umount", "-l", self.folder / "volume")
        for process in reversed(self.processes):
            process.terminate()
            process.wait()
        self.processes = []


class VolatileDisk(Disk):
    """Its power can be cut: it has a cache that only a flush empties, and that goes with nbdkit."""

    server = ["--filter=cache", "cache=writeback", "cache-min-block-size=4096"]

    def cut(self):
        """The power goes. Whoever uses the file system gets errors from now on."""
        self.processes[0].kill()
        self.processes[0].wait()


class FailingDisk(Disk):
    """It can be told to refuse all writes, with EIO. Without a journal of its own: ext4 would not
    take its file system back after an error in that."""

    features = ["-O", "^has_journal"]

    def __init__(self, folder):
        super().__init__(folder)
        self.flag = self.folder / "fails"
        self.server = ["--filter=error", "error-pwrite=EIO", "error-pwrite-rate=100%",
                       f"error-file={self.flag}"]

    def fail(self):
        self.flag.touch()

    def mend(self):
        self.flag.unlink()
