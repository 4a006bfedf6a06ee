#!/usr/bin/env python3
"""The paper's evaluation, run again on this system; scripts/evaluate calls it.

Each section measures into OUT/measured/SECTION.json and shows what stands there; so a run may be
made in parts, and a report be written again without measuring.
"""

import argparse
import json
import pathlib
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "lib"))

import sections  # noqa: E402
from job import Job  # noqa: E402
from machine import describe_machine  # noqa: E402
from page import Page  # noqa: E402

PAPER_SCANS = 35_000


def parse(arguments):
    parser = argparse.ArgumentParser(prog="evaluate", description=__doc__, allow_abbrev=False)
    parser.add_argument("--scans", metavar="N", type=int, default=3500,
                        help=f"of the simulated drive; the paper has {PAPER_SCANS} [%(default)s]")
    parser.add_argument("--data", metavar="DIR", type=pathlib.Path,
                        help="real scans in KITTI odometry form, for section 4.2 and the codecs")
    parser.add_argument("--poses", metavar="FILE", default="poses_refined_ecef.txt",
                        help="their refined poses, ecef_from_sensor [%(default)s]")
    parser.add_argument("--recorded-poses", metavar="FILE", default="poses_ecef.txt",
                        help="their poses as recorded, for section 4.2 [%(default)s]")
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, default=ROOT / "build/evaluation",
                        help="where report, pictures and figures go [%(default)s]")
    parser.add_argument("--only", metavar="SECTION,...",
                        help="measure these: " + ", ".join(sections.names()))
    parser.add_argument("--perf", action="store_true",
                        help="profile the processes of the drive (Linux perf)")
    parser.add_argument("--check-options", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    options.wanted = options.only.split(",") if options.only else sections.names()
    unknown = [name for name in options.wanted if name not in sections.names()]
    if unknown:
        parser.error(f"--only {unknown[0]}: the sections are {', '.join(sections.names())}")
    if options.scans < 4:
        parser.error(f"--scans {options.scans}: at least 4")
    if options.data and not options.data.is_dir():
        parser.error(f"--data {options.data}: no such folder")
    if options.data:
        options.data = options.data.absolute()
    options.out = options.out.absolute()
    return options


def measure(section, options):
    """Measures a section and keeps what it has found, with when, and at how many scans."""
    job = Job(section.NAME, options)
    print(f"evaluate: {section.NAME}", flush=True)
    began = time.time()
    values = section.measure(job)
    kept = {"values": values, "scans": options.scans, "began": began,
            "seconds": time.time() - began, "load_before": job.load_before,
            "machine": describe_machine()}
    job.measured_file(section.NAME).write_text(json.dumps(kept, indent=1), encoding="utf-8")
    print(f"evaluate: {section.NAME} took {kept['seconds']:.0f} s", flush=True)


def write_report(options):
    page = Page(options.out, "voxatlas beside the paper: its evaluation, run again")
    measured = {}
    for section in sections.ALL:
        file = options.out / "measured" / f"{section.NAME}.json"
        if file.exists():
            measured[section.NAME] = json.loads(file.read_text(encoding="utf-8"))
    sections.show_summary(page, measured)
    page.misses = 0  # Each is told again, and counted, in its own section.
    for section in sections.ALL:
        if section.NAME in measured:
            kept = measured[section.NAME]
            page.section(section.TITLE)
            section.show(page, kept["values"], {n: m["values"] for n, m in measured.items()})
            page.note(f"Measured {time.strftime('%Y-%m-%d %H:%M', time.gmtime(kept['began']))} UTC, "
                      f"--scans {kept['scans']}, in {kept['seconds']:.0f} s; load average before: "
                      f"{kept['load_before']:.1f}.")
    page.write()
    return page


def main(arguments):
    options = parse(arguments)
    if options.check_options:
        return 0
    for section in sections.ALL:
        if section.NAME in options.wanted:
            measure(section, options)
    page = write_report(options)
    print(f"evaluate: {page.misses} targets missed; the report is {options.out}/evaluation.md and "
          "evaluation.html")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
