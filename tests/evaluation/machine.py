"""The machine that figures come from."""

import os
import pathlib
import platform


def _first(path, key):
    for line in pathlib.Path(path).read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith(key):
            return line.split(":", 1)[1].strip()
    return "unknown"


def describe_machine():
    """Processor, memory, system, in a sentence."""
    kib = int(_first("/proc/meminfo", "MemTotal").split()[0])
    release = platform.freedesktop_os_release().get("PRETTY_NAME", "unknown system")
    flags = _first("/proc/cpuinfo", "flags").split()
    vector = "AVX-512" if "avx512bw" in flags else "AVX2" if "avx2" in flags else "no AVX2"
    return (f"{len(os.sched_getaffinity(0))} cores of {_first('/proc/cpuinfo', 'model name')} "
            f"({vector}), {kib / 2**20:.0f} GiB, {release}, Linux {platform.release()}")
