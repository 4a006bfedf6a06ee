"""The main job end to end, on a fresh model: scans in, a durable model, pictures out, and a proof.

scripts/demo sets up, builds, and runs this in a network namespace of its own.
"""

import argparse
import json
import pathlib
import shutil
import signal
import sys
import tempfile
import time

from bus import BusError
from service_set import ServiceSet, SetError

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
VIEWS = ("street", "oblique")
REST_LOOKS, LOOK_SECONDS, PATIENCE_SECONDS = 4, 2, 180
STAGES = ("wait_ms", "fetch_ms", "draw_ms", "shade_ms", "encode_ms")


def default_out():
    """In a source tree with what is built there; installed, where one stands."""
    built = ROOT / "build"
    return built / "demo" if (ROOT / "CMakeLists.txt").exists() else pathlib.Path("voxatlas-demo")


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="demo", allow_abbrev=False, description="The main job of voxatlas, end to end, on a "
        "fresh model. Without --data the scans are a simulated drive.")
    parser.add_argument("--data", metavar="DIR", type=pathlib.Path,
                        help="scans in KITTI's form: velodyne/NNNNNN.bin and times.txt")
    parser.add_argument("--poses", metavar="FILE", help="12 numbers a line, ecef_from_sensor; "
                        "looked up in DIR first")
    parser.add_argument("--origin", metavar="LAT,LON,HEIGHT",
                        help="where the poses' local frame lies on Earth, if they are not ECEF")
    parser.add_argument("--sigma", metavar="METRES", help="standard deviation of the scans' points")
    parser.add_argument("--scans", metavar="N", type=int, default=30,
                        help="scans of the simulated drive [%(default)s]")
    parser.add_argument("--stores", metavar="N", type=int, default=1, help="tile stores [1]")
    parser.add_argument("--ingest", metavar="M", type=int, default=1, help="ingests [1]")
    parser.add_argument("--store", metavar="S", help="keep the model elsewhere than in OUT: "
                        "rados:CONF,POOL[,MODEL], a new one in the Ceph cluster of that ceph.conf")
    parser.add_argument("--cache-mb", metavar="B", type=int, default=512,
                        help="budget of each tile store's memory, MiB [%(default)s]")
    parser.add_argument("--size", default="1280x720", help="of the pictures [%(default)s]")
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, default=default_out(),
                        help="where pictures, hashes and logs go [%(default)s]")
    parser.add_argument("--json", metavar="FILE", type=pathlib.Path,
                        help="the figures of the table, for programs")
    parser.add_argument("--keep-model", action="store_true", help="leave the model in OUT")
    parser.add_argument("--check-options", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if bool(options.data) != bool(options.poses):
        parser.error("--data and --poses go together")
    if options.data and not options.data.is_dir():
        parser.error(f"--data {options.data}: no such folder")
    if options.origin and not options.data:
        parser.error("--origin belongs to --data: the simulated drive knows where it is")
    for name in ("scans", "stores", "ingest", "cache_mb"):
        if getattr(options, name) < 1:
            parser.error(f"--{name.replace('_', '-')} must be above 0")
    return options


def say(text):
    print(f"demo: {text}", flush=True)


def started(services):
    """The services of a set, in a sentence."""
    say(f"{', '.join(service.name for service in services.services)} ready on "
        f"{services.bus.url} ({services.bus.how})")


def publish(services, options):
    """Publishes all scans and returns the command's figures once each is durable."""
    if options.data:
        source = [options.data, "--poses", options.poses]
        source += ["--origin", options.origin] if options.origin else []
        source += ["--sigma", options.sigma] if options.sigma else []
    else:
        source = ["--simulate", options.scans]
    return json.loads(services.run("publish", *source, "--ingests", options.ingest, "--json"))


def draw(services, options):
    """Asks for each picture; returns what the renderer says of each."""
    frames = {}
    for view in VIEWS:
        file = options.out / f"{view}.png"
        frames[view] = json.loads(services.run(
            "render", "--view", view, "--size", options.size, "--out", file, "--json"))
        frames[view]["file"] = str(file)
        say(f"drawn: {file}")
    return frames


def peak_memory(service):
    """The most memory a process held resident so far, bytes."""
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024


def stat(services, hashes):
    return json.loads(services.run("stat", "--hashes", hashes, "--json"))


def stat_at_rest(services, hashes):
    """The model once the compressor has been over it: its bytes have stopped to fall."""
    last, same, until = stat(services, hashes), 0, time.monotonic() + PATIENCE_SECONDS
    while same < REST_LOOKS and time.monotonic() < until:
        time.sleep(LOOK_SECONDS)
        now = stat(services, hashes)
        same = same + 1 if now["encoded_bytes"] == last["encoded_bytes"] else 0
        last = now
    if same < REST_LOOKS:
        say(f"the model's bytes still change after {PATIENCE_SECONDS} s")
    return last


def new_set(model, options):
    return ServiceSet(model, stores=options.stores, ingests=options.ingest,
                      store_options=["--cache-mb", options.cache_mb], store=options.store)


def run(options, model):
    """The whole job. Returns its figures and what went wrong, in words."""
    before, after = options.out / "hashes.txt", options.out / "hashes_after_restart.txt"
    with new_set(model, options) as services:
        started(services)
        published = publish(services, options)
        say("every scan is durable")
        fresh_bytes = stat(services, before)["encoded_bytes"]
        frames = draw(services, options)
        model_stat = stat_at_rest(services, before)
        memory = max(peak_memory(s) for s in services.services if s.kind == "tilestore")
    say("all stopped; starting again on the same model")
    restart = time.monotonic()
    with new_set(model, options) as services:
        started(services)
        restart = time.monotonic() - restart
        stat(services, after)
    figures = {"published": published, "frames": frames, "model": model_stat,
               "encoded_bytes_before_compression": fresh_bytes,
               "restart_seconds": restart, "tilestore_peak_bytes": memory,
               "cache_bytes": options.cache_mb << 20}
    return figures, list(losses(figures, before, after))


def losses(figures, before, after):
    published = figures["published"]
    if published["scans"] < 1:
        yield "no scan was published"
    if published["durable"] != published["scans"]:
        yield f"{published['durable']} of {published['scans']} scans are durable"
    if figures["model"]["tiles"] < 1:
        yield "the model is empty"
    for view, frame in figures["frames"].items():
        if frame["tiles_missing"] > 0:
            yield f"the {view} picture lacks {frame['tiles_missing']} tiles"
    differing = set(before.read_text().splitlines()) ^ set(after.read_text().splitlines())
    if differing:
        yield f"tiles differ after the restart: {len(differing)} lines, such as {min(differing)}"


def number(value):
    return f"{value:,.0f}".replace(",", " ")


def rows(figures):
    published, model = figures["published"], figures["model"]
    yield "scans, each durable", number(published["scans"])
    yield "rays", number(published["rays"])
    yield "rays/s, to durable", number(published["rays"] / published["seconds"])
    yield "tiles", number(model["tiles"])
    for state in ("occupied", "free"):
        yield f"voxels {state}", number(model[f"{state}_voxels"])
        yield f"leaves {state}", number(model[f"{state}_leaves"])
    yield "bytes on disk", number(model["disk_bytes"])
    yield "bytes of encoded tiles", number(model["encoded_bytes"])
    if model["occupied_voxels"]:
        for when, size in (("as written", figures["encoded_bytes_before_compression"]),
                           ("compressed", model["encoded_bytes"])):
            per_cell = size / model["occupied_voxels"]
            yield f"encoded bytes per occupied voxel, {when}", f"{per_cell:.2f}"
    yield "tile store, peak resident bytes", number(figures["tilestore_peak_bytes"])
    for view, frame in figures["frames"].items():
        stages = ", ".join(f"{stage[:-3]} {frame[stage]:.1f}" for stage in STAGES)
        yield f"{view} picture, ms", stages
    yield "stopped and started again, s", f"{figures['restart_seconds']:.1f}"


def print_table(figures):
    lines = list(rows(figures))
    width = max(len(name) for name, _ in lines)
    for name, value in lines:
        print(f"  {name:{width}}  {value}")


def interrupted(number_, _frame):
    raise SetError(f"stopped by {signal.Signals(number_).name}")


def main(arguments):
    options = parse(arguments)
    if options.check_options:
        return 0
    for asked in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(asked, interrupted)
    options.out.mkdir(parents=True, exist_ok=True)
    model = pathlib.Path(tempfile.mkdtemp(prefix="model-", dir=options.out))
    try:
        figures, lost = run(options, model)
    except (SetError, BusError) as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    finally:
        if (model / "logs").is_dir():
            shutil.copytree(model / "logs", options.out / "logs", dirs_exist_ok=True)
        if options.store:
            say(f"the model is in {options.store}")
        if options.keep_model:
            say(f"the model is in {model}")
        else:
            shutil.rmtree(model)
    figures["lost"] = lost
    if options.json:
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    print_table(figures)
    for line in lost:
        print(f"demo: LOST: {line}", file=sys.stderr)
    if not lost:
        say("nothing was lost: every tile is the same after the restart")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
