"""The set of services as processes: starts them, sees that they live, stops them in order.

Used by scripts/up, scripts/demo and tests/system. A service leads a session of its own (a Ctrl-C on
the terminal reaches only the one who supervises), it gets SIGTERM if its supervisor dies, and all
it prints goes to DATA_DIR/logs/NAME.log. Waiting is for facts: a process that ends, and the
services' own word on the bus that they are ready.
"""

import os
import pathlib
import queue
import signal
import subprocess
import tempfile
import threading

from bus import Bus

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Those that send stop before those that receive, and the bus last; they start the other way round.
STOP_ORDER = ["ingest", "render", "compress", "tilestore", "hub"]
STOP_SECONDS = 60
# A signal that comes just before Python begins to wait is only seen after the wait: so none is long.
LONGEST_WAIT_SECONDS = 0.5
READY_SECONDS = 60


class SetError(Exception):
    """The set cannot go on; the message is for a person."""


def default_bin_dir():
    """VOX_BIN_DIR, else what was built here, else PREFIX/bin beside PREFIX/share/voxatlas."""
    here = ROOT / "build" / "release" if (ROOT / "CMakeLists.txt").exists() else ROOT.parent.parent
    return pathlib.Path(os.environ.get("VOX_BIN_DIR") or here / "bin")


def start_process(command, env, ended, **options):
    """Starts a process that ends with its parent and puts itself into `ended` when it ends."""
    # setpriv asks for the signal, not a preexec_fn: Python code between fork and exec may wait for
    # ever for what a thread of the parent held, and a Ctrl-C there ends in a traceback.
    process = subprocess.Popen(["setpriv", "--pdeathsig", "TERM", "--", *map(str, command)],
                               env=env, stdin=subprocess.DEVNULL, **options)

    def tell():
        process.wait()
        ended.put(process)

    threading.Thread(target=tell, daemon=True).start()
    return process


def end_in_words(process):
    if process.returncode < 0:
        return f"was ended by {signal.Signals(-process.returncode).name}"
    return f"ended with exit code {process.returncode}"


class Service:
    """One process of the set."""

    def __init__(self, kind, index, command, log_path, env):
        self.kind = kind
        self.name = f"{kind} {index}"
        self.command = command
        self.log_path = log_path
        self.env = env
        self.process = None

    def start(self, ended, stdout=None):
        """`stdout`: where that goes, if not into the log as stderr does.

        In a process group of its own, so that Ctrl-C is for who started the set, but in one session
        with the others: the kernel shares processors out among sessions first (autogroups), and a
        service's niceness would count for nothing.
        """
        with open(self.log_path, "ab") as log:
            self.process = start_process(self.command, self.env, ended, stdout=stdout or log,
                                         stderr=log, process_group=0)

    def is_running(self):
        return self.process is not None and self.process.poll() is None

    def signal(self, number):
        if self.is_running():
            os.kill(self.process.pid, number)

    def kill(self):
        """Ends it at once, as a crash would, and waits until it is gone."""
        self.process.kill()
        self.process.wait()

    def obituary(self, count=12):
        lines = self.log_path.read_text(encoding="utf-8", errors="replace").splitlines()[-count:]
        quoted = "\n".join(f"    {line}" for line in lines)
        return f"{self.name} {end_in_words(self.process)}; last in {self.log_path}:\n{quoted}"


class ServiceSet:
    """`with ServiceSet(DIR) as services:` all are ready inside the block and stopped after it."""

    def __init__(self, data_dir, bin_dir=None, url=None, hub=False, stores=1, ingests=1,
                 compressors=1, renders=1, store_options=(), ready_seconds=READY_SECONDS,
                 compress_options=(), store=None):
        self.data_dir = pathlib.Path(data_dir).absolute()
        self.bin_dir = pathlib.Path(bin_dir or default_bin_dir())
        self.counts = {"tilestore": stores, "compress": compressors, "ingest": ingests,
                       "render": renders}
        self.store_options = list(store_options)
        self.place = ["--store", store] if store else ["--data-dir", self.data_dir]
        self.compress_options = list(compress_options)
        self.ready_seconds = ready_seconds
        self.wanted = {"url": url, "hub": hub}
        self.bus = None
        self.services = []
        self.ended = queue.SimpleQueue()

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, kind, value, trace):
        failed = self.stop()
        if failed and kind is None:
            raise SetError("\n".join(failed))

    # --- start ---

    def start(self):
        """Starts all and returns when each has said on the bus that it is ready."""
        if not (self.bin_dir / "voxatlas-hub").exists():
            raise SetError(f"no programs in {self.bin_dir}: run scripts/build first")
        try:
            (self.data_dir / "logs").mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SetError(f"data folder {self.data_dir}: {error.strerror}") from error
        self.bus = Bus()
        self.bus.find(self.bin_dir, **self.wanted)
        if self.bus.url is None:
            self._start_hub()
        services = self._services()
        self.services += services
        for service in services:
            service.start(self.ended)
        self.wait_until_ready()

    def _start_hub(self):
        """The hub takes a free port and says which, once it listens."""
        hub = self._service("hub", 0, "--port", 0)
        hub.start(self.ended, subprocess.PIPE)
        self.services.append(hub)
        said = hub.process.stdout.readline().decode().split()
        if len(said) != 2 or said[0] != "ready":
            hub.kill()
            raise SetError(hub.obituary())
        self.bus.hub_runs(said[1])
        hub.command[-1] = said[1]  # Started again, it comes back where its clients look for it.

    def _services(self):
        stores = self.counts["tilestore"]
        services = [
            self._service("tilestore", shard, "--url", self.bus.url, *self.place,
                          "--shard", shard, "--shards", stores, "--compressors",
                          self.counts["compress"], *self.store_options)
            for shard in range(stores)]
        for kind, more in (("compress", self.compress_options), ("ingest", ["--ingests", self.counts["ingest"]]),
                           ("render", [])):
            services += [self._service(kind, index, "--url", self.bus.url, "--index", index,
                                       "--stores", stores, *more)
                         for index in range(self.counts[kind])]
        return services

    def _service(self, kind, index, *options):
        return Service(kind, index, [self.bin_dir / f"voxatlas-{kind}", *options],
                       self.data_dir / "logs" / f"{kind}-{index}.log", self.env())

    def env(self):
        """What each program of the set, and each that talks to it, sees."""
        url = {"LCM_DEFAULT_URL": self.bus.url} if self.bus.url else {}
        return {**os.environ, **url}

    def wait_until_ready(self):
        self.run("watch", "status", "--until-ready", len(self.services), "--timeout",
                 self.ready_seconds, quiet=True)

    # --- while it runs ---

    def find(self, kind, index=0):
        return next(service for service in self.services if service.name == f"{kind} {index}")

    def begin(self, *arguments, **options):
        """Starts the command line, `voxatlas ARGUMENTS...`, on this set's bus."""
        return start_process(self.command(*arguments), self.env(), self.ended, **options)

    def command(self, *arguments):
        return [self.bin_dir / "voxatlas", *arguments]

    def run(self, *arguments, quiet=False):
        """Runs `voxatlas ARGUMENTS...` to its end and returns what it printed.

        quiet:  what it says on stderr is shown only if it fails.
        Errors: SetError where it fails, and as soon as a service ends beside it.
        """
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            process = self.begin(*arguments, stdout=out, stderr=err if quiet else None)
            self.wait_for(process)
            out.seek(0)
            err.seek(0)
            if process.returncode != 0:
                command = " ".join(map(str, ["voxatlas", *arguments]))
                raise SetError(f"{command} {end_in_words(process)}\n{err.read()}".rstrip())
            return out.read()

    def wait_for(self, process):
        """Returns when `process` has ended; ends it, with SetError, when a service ends first."""
        try:
            while process.poll() is None:
                self.check_alive()
                self.wait_for_an_end()
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()

    def wait_for_an_end(self, seconds=LONGEST_WAIT_SECONDS):
        """Returns when a process has ended, or a little later: look what is true now."""
        try:
            self.ended.get(timeout=min(seconds, LONGEST_WAIT_SECONDS))
        except queue.Empty:
            pass

    def check_alive(self):
        for service in self.services:
            if not service.is_running():
                raise SetError(service.obituary())

    # --- stop ---

    def stop(self):
        """Stops all, in order, and waits for each. Returns what did not end well, in words."""
        failed = []
        for kind in STOP_ORDER:
            running = [s for s in self.services if s.kind == kind and s.is_running()]
            for service in running:
                service.signal(signal.SIGTERM)
            for service in running:
                failed += self._wait_for_stop(service)
                if service.process.stdout:
                    service.process.stdout.close()
        self.services = []
        if self.bus:
            self.bus.leave()
        return failed

    @staticmethod
    def _wait_for_stop(service):
        try:
            service.process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            service.kill()
            return [f"{service.name} did not stop within {STOP_SECONDS} s and was killed"]
        return [] if service.process.returncode == 0 else [service.obituary()]
