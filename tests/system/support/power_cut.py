"""A disk whose power can be cut: ext4 on a loop device on a file that nbdkit serves by FUSE, with a
cache that only a flush empties. Killing nbdkit loses whatever was not synced. Root only."""

import os
import pathlib
import shutil
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
    """`mount` is where the file system hangs between up() and cut() or down()."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.mount = self.folder / "mount"
        self.mount.mkdir()
        self.image = self.folder / "image"
        with open(self.image, "wb") as image:
            image.truncate(DISK_BYTES)
        subprocess.run(["mkfs.ext4", "-q", "-F", self.image], check=True)
        self.processes = []
        self.loop = None
        self.is_up = False

    def up(self):
        socket, volume = self.folder / "socket", self.folder / "volume"
        socket.unlink(missing_ok=True)
        volume.write_bytes(b"")
        self._start("nbdkit", "-f", "-U", socket, "--filter=cache", "file", self.image,
                    "cache=writeback", "cache-min-block-size=4096", env={"TMPDIR": self.folder})
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

    def cut(self):
        """The power goes. Whoever uses the file system gets errors from now on."""
        self.processes[0].kill()
        self.processes[0].wait()

    def down(self):
        """Takes the rest away; after cut(), or in peace (unmounting writes everything)."""
        if not self.is_up:
            return
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
