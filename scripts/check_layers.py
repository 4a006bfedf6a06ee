#!/usr/bin/env python3
"""Keeps the house in order: which room may include which, and what stands at the top level.

    check_layers.py [TREE]       check the tree (this one)
    check_layers.py --self-test  show that each rule can fail

Rules, for what stands in libs/ and services/:
  1. A library includes only libraries above it in LAYERS; those of one row never one another.
  2. A service includes libraries and its own folder, never another service.
  3. Only libs/bus includes LCM's headers or the generated types, and links to them.
  4. Project headers are included as "room/file.hpp", from libs/ or services/.
  5. What a CMakeLists.txt links obeys the same order.
  6. The top level holds TOP_LEVEL and hidden files, nothing else.
Files that are too long are named, but do not fail.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# From the top down. A room may include the rows above its own.
LAYERS = [
    ["base"],
    ["geodesy", "grid"],
    ["octree"],
    ["integrate", "codec", "store", "render", "sim"],
    ["atlas"],
    ["bus", "io"],
]
# sim stands beside integrate, but what a scanner sees is a scan: it may use those types.
EXCEPTIONS = {("sim", "integrate/scan.hpp"), ("sim", "integrate/sensor_scan.hpp")}
# sim is input made for tests and the command line: the model's own rooms know nothing of it.
HIDDEN_FROM_LIBS = {"sim"}

TOP_LEVEL = {"CMakeLists.txt", "lcmtypes", "services", "libs", "scripts", "tests", "docker",
             "README.md"}
IGNORED = {"build", "voxatlas-data"}  # As .gitignore does.
BUS_ONLY_HEADERS = ("lcm/", "voxatlas/", "bot_core/", "lcmtypes/")
BUS_ONLY_TARGETS = {"lcm", "lcmtypes"}
LONGEST = {".hpp": 150, ".cpp": 300}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
TARGET = re.compile(r"\bvox::(\w+)")
LIBRARY = re.compile(r"\bvox_library\(\s*(\w+)")


def rooms_above(room):
    """The libraries that `room` may include."""
    above = set()
    for row in LAYERS:
        if room in row:
            return above - HIDDEN_FROM_LIBS
        above |= set(row)
    return None


def all_rooms():
    return {room for row in LAYERS for room in row}


def top_level_names(tree):
    """What a clone holds at its top: git's list, else the folder's without what git ignores."""
    if shutil.which("git") and (tree / ".git").exists():
        listed = subprocess.run(["git", "-C", str(tree), "ls-files", "-z"], capture_output=True,
                                text=True, check=False)
        if listed.returncode == 0:
            return {name.split("/")[0] for name in listed.stdout.split("\0") if name}
    return {entry.name for entry in tree.iterdir()} - IGNORED


def check_top_level(tree):
    for name in sorted(top_level_names(tree)):
        if name not in TOP_LEVEL and not name.startswith("."):
            yield f"{name}: not one of the top level's: {' '.join(sorted(TOP_LEVEL))}"


def why_not(room, is_service, quote, header):
    """Why code in `room` may not include `header`, or None where it may."""
    if header.startswith(BUS_ONLY_HEADERS) or header.startswith("lcm_"):
        return None if room == "bus" and not is_service else "only libs/bus sees LCM and its types"
    if quote == "<":
        return None
    folder = header.split("/")[0]
    if "/" not in header or folder == "..":
        return 'project headers are included as "room/file.hpp"'
    if is_service:
        known = folder in all_rooms() or folder == room
        return None if known else f"service {room} may include libraries and itself, not {folder}"
    if folder == room or (room, header) in EXCEPTIONS:
        return None
    return None if folder in rooms_above(room) else f"{folder} does not stand above {room}"


def check_includes(tree):
    for part in ("libs", "services"):
        for file in sorted((tree / part).glob("*/**/*.[ch]pp")):
            room = file.relative_to(tree / part).parts[0]
            if part == "libs" and room not in all_rooms():
                yield f"{file.relative_to(tree)}: libs/{room} has no place in LAYERS"
                continue
            text = file.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(text):
                reason = why_not(room, part == "services", match[1], match[2])
                if reason:
                    line = text.count("\n", 0, match.start(2)) + 1
                    yield f"{file.relative_to(tree)}:{line}: includes {match[2]}: {reason}"


def cmake_text(file):
    return re.sub(r"#.*", "", file.read_text(encoding="utf-8"))


def check_links(tree):
    home = {}  # library target -> the room it is declared in; a room may hold several.
    for file in sorted((tree / "libs").glob("*/**/CMakeLists.txt")):
        for name in LIBRARY.findall(cmake_text(file)):
            home[name] = file.relative_to(tree / "libs").parts[0]
    for part in ("libs", "services"):
        for file in sorted((tree / part).glob("*/**/CMakeLists.txt")):
            room = file.relative_to(tree / part).parts[0]
            for target in sorted(set(TARGET.findall(cmake_text(file)))):
                reason = why_not_link(room, part == "services", target, home)
                if reason:
                    yield f"{file.relative_to(tree)}: links vox::{target}: {reason}"


def why_not_link(room, is_service, target, home):
    if target in BUS_ONLY_TARGETS:
        return None if room == "bus" and not is_service else "only libs/bus sees LCM and its types"
    if target.endswith("_service"):
        own = is_service and target == f"{room}_service"
        return None if own else "services never use one another"
    if target not in home or is_service or home[target] == room:
        return None
    allowed = (rooms_above(room) or set()) | {h.split("/")[0] for r, h in EXCEPTIONS if r == room}
    return None if home[target] in allowed else f"{home[target]} does not stand above {room}"


def too_long(tree):
    for part in ("libs", "services", "tests"):
        for file in sorted((tree / part).glob("**/*.[ch]pp")):
            lines = file.read_bytes().count(b"\n")
            if lines > LONGEST[file.suffix]:
                yield f"{file.relative_to(tree)}: {lines} lines, over {LONGEST[file.suffix]}"


def check(tree):
    return [*check_top_level(tree), *check_includes(tree), *check_links(tree)]


# What breaks each rule once: (file, its text, a part of the expected complaint or None).
CASES = [
    ("libs/grid/a.hpp", '#include "base/result.hpp"\n#include <vector>\n', None),
    ("libs/grid/a.hpp", '#include "octree/tile_tree.hpp"\n', "octree does not stand above grid"),
    ("libs/grid/a.hpp", '#include "geodesy/ecef.hpp"\n', "geodesy does not stand above grid"),
    ("libs/codec/a.cpp", '#include "store/tile_store.hpp"\n', "store does not stand above codec"),
    ("libs/render/a.cpp", '#include "integrate/scan.hpp"\n', "integrate does not stand above"),
    ("libs/sim/a.cpp", '#include "integrate/scan.hpp"\n', None),
    ("libs/sim/a.cpp", '#include "integrate/quality.hpp"\n', "integrate does not stand above sim"),
    ("libs/atlas/a.cpp", '#include "sim/city.hpp"\n', "sim does not stand above atlas"),
    ("libs/io/a.cpp", '#include "bus/bus.hpp"\n', "bus does not stand above io"),
    ("libs/bus/a.cpp", '#include "io/kitti.hpp"\n', "io does not stand above bus"),
    ("libs/bus/a.cpp", '#include <lcm/lcm-cpp.hpp>\n#include "voxatlas/scan_t.hpp"\n', None),
    ("libs/atlas/a.cpp", "#include <lcm/lcm-cpp.hpp>\n", "only libs/bus"),
    ("services/cli/a.cpp", "#include <bot_core/pose_t.hpp>\n", "only libs/bus"),
    ("services/ingest/a.cpp", "#include <voxatlas/scan_t.hpp>\n", "only libs/bus"),
    ("services/ingest/a.cpp", '#include "bus/bus.hpp"\n#include "ingest/x.hpp"\n', None),
    ("services/ingest/a.cpp", '#include "tilestore/x.hpp"\n', "not tilestore"),
    ("libs/grid/a.cpp", '#include "../base/result.hpp"\n', "included as"),
    ("libs/grid/a.cpp", '#include "tile_key.hpp"\n', "included as"),
    ("libs/attic/a.cpp", "\n", "no place in LAYERS"),
    ("libs/grid/CMakeLists.txt", "vox_library(grid DEPS vox::base)\n", None),
    ("libs/grid/CMakeLists.txt", "vox_library(grid DEPS vox::octree)\n", "links vox::octree"),
    ("libs/grid/CMakeLists.txt", "vox_library(grid DEPS vox::lcm)\n", "only libs/bus"),
    ("services/ingest/CMakeLists.txt", "vox_service(ingest DEPS vox::hub_service)\n",
     "services never use one another"),
    ("docs/manual.md", "\n", "not one of the top level's"),
]


def self_test():
    """Plants each case in an otherwise good tree; exit code 1 if a rule lets it through."""
    wrong = 0
    for path, text, expected in CASES:
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder)
            for room in ("base", "octree"):
                (tree / "libs" / room).mkdir(parents=True)
                (tree / "libs" / room / "CMakeLists.txt").write_text(f"vox_library({room})\n")
            (tree / path).parent.mkdir(parents=True, exist_ok=True)
            (tree / path).write_text(text, encoding="utf-8")
            found = check(tree)
        as_expected = (not found) if expected is None else len(found) == 1 and expected in found[0]
        if not as_expected:
            wrong += 1
            print(f"self-test: {path} with {text!r}: expected {expected!r}, found {found}")
    print(f"check_layers: self-test, {len(CASES)} cases, {wrong} wrong")
    return 1 if wrong else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) > 1 or (arguments and arguments[0].startswith("-")):
        print(__doc__, file=sys.stderr)
        return 2
    tree = pathlib.Path(arguments[0]) if arguments else pathlib.Path(__file__).parent.parent
    tree = tree.resolve()
    if not (tree / "libs").is_dir():
        print(f"check_layers: {tree} holds no libs/", file=sys.stderr)
        return 2
    for line in too_long(tree):
        print(f"note: {line}")
    broken = check(tree)
    for line in broken:
        print(line, file=sys.stderr)
    print(f"check_layers: {len(broken)} rules broken" if broken else "check_layers: in order")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
