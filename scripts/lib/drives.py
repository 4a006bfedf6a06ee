"""Drives made of drives: the same scans again and again, or in another city."""

import math
import pathlib

KITTI_POINT_BYTES = 16


def rays_in(folder):
    """How many points the scans of a KITTI folder have."""
    return sum(file.stat().st_size for file in (folder / "velodyne").iterdir()) // KITTI_POINT_BYTES


def repeat(source, poses, target, passes, east_deg=0.0):
    """Makes the folder `target`: the scans of `source`, `passes` times over, as one long drive.

    poses:    a file name, looked up in `source` first: 12 numbers a line, ecef_from_sensor.
    east_deg: turns the whole drive about the Earth's axis, into a city as far north as its own.
    The scans are links; times go on by 0.1 s. Returns how many scans there are.
    """
    source = pathlib.Path(source).resolve()
    pose_file = source / poses if (source / poses).exists() else pathlib.Path(poses)
    pose_lines = pose_file.read_text(encoding="ascii").splitlines()
    count = min(len(pose_lines), sum(1 for _ in (source / "velodyne").iterdir()))
    pose_lines = [_turned(line, math.radians(east_deg)) if east_deg else line
                  for line in pose_lines[:count]]
    for kind in ("velodyne", "colours"):
        if not (source / kind).is_dir():
            continue
        (target / kind).mkdir(parents=True)
        for i in range(count * passes):
            (target / kind / f"{i:06}.bin").symlink_to(source / kind / f"{i % count:06}.bin")
    times = "".join(f"{1e9 + 0.1 * i:.1f}\n" for i in range(count * passes))
    (target / "times.txt").write_text(times, encoding="ascii")
    (target / "poses.txt").write_text("\n".join(pose_lines * passes) + "\n", encoding="ascii")
    return count * passes


def _turned(line, angle):
    """A pose, row-major 3 x 4, turned about the z axis."""
    c, s = math.cos(angle), math.sin(angle)
    m = [float(number) for number in line.split()]
    x, y, z = m[0:4], m[4:8], m[8:12]
    rows = [[c * a - s * b for a, b in zip(x, y)], [s * a + c * b for a, b in zip(x, y)], z]
    return " ".join(repr(number) for row in rows for number in row)
