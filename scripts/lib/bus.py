"""Finds a bus that works here, as DESIGN says: multicast, else with a route on lo, else the hub.

Multicast needs a route, and a fresh machine or container may have none. `Bus.find` probes the URL
for real (the hub program's --probe: subscribe, send 60 kB to itself); if nothing comes back it adds
the route on `lo` where it may; if that fails too it starts the bundled TCP hub on 127.0.0.1.
"""

import os
import subprocess

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"
ROUTE = ["224.0.0.0/4", "dev", "lo"]


class BusError(Exception):
    """No bus could be made to work; the message says what was tried."""


class Bus:
    """A URL that works, and what was done for it. `url` is None where a hub has to run first.

    leave() may be called at any moment, also when find() was interrupted: a route counts as ours
    from before it is added, if there was none.
    """

    def __init__(self):
        self.url = None
        self.how = "not looked for yet"
        self.route_is_ours = False

    def find(self, bin_dir, url=None, hub=False):
        """`url`: this one and no other. `hub`: the hub at once. Neither: whatever works."""
        if hub:
            self.how = "the hub, as asked"
        elif url is None and os.environ.get("VOX_NAMESPACE") == "0":
            self.how = "the hub, for want of a network namespace"
        else:
            self._try(bin_dir, url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL,
                      may_be_hub=url is None)

    def _try(self, bin_dir, wanted, may_be_hub):
        reason = probe(bin_dir, wanted)
        if reason is None:
            self.url, self.how = wanted, "probed"
            return
        if wanted.startswith("udpm:") and self._add_route():
            if probe(bin_dir, wanted) is None:
                self.url, self.how = wanted, "probed, after adding a multicast route on lo"
                return
            self.leave()
        if not may_be_hub:
            raise BusError(f"no message comes back on {wanted}: {reason}")
        self.how = f"the hub, as no message comes back on {wanted}: {reason}"

    def _add_route(self):
        """Whether a multicast route on lo could be added. Never takes the place of another."""
        if route_is_there() or not _ip("link", "set", "lo", "up"):
            return False
        self.route_is_ours = True
        self.route_is_ours = _ip("route", "add", *ROUTE)
        return self.route_is_ours

    def hub_runs(self, port):
        self.url = f"tcpq://127.0.0.1:{port}"

    def leave(self):
        """Undoes what find() did to the machine."""
        if self.route_is_ours:
            _ip("route", "del", *ROUTE)
            self.route_is_ours = False


def probe(bin_dir, url):
    """None where the bus works, else the reason, in the probe's words."""
    done = subprocess.run([bin_dir / "voxatlas-hub", "--probe", url], capture_output=True,
                          text=True, check=False)
    if done.returncode == 0:
        return None
    words = (done.stderr.strip() or done.stdout.strip() or f"exit code {done.returncode}")
    return words.splitlines()[-1]


def route_is_there():
    try:
        shown = subprocess.run(["ip", "route", "show", "exact", ROUTE[0]], capture_output=True,
                               check=False)
    except FileNotFoundError:
        return False
    return bool(shown.stdout.strip())


def _ip(*arguments):
    try:
        return subprocess.run(["ip", *arguments], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False
