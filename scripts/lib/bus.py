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
    """A URL that works, and what was done for it. `url` is None where a hub has to run first."""

    def __init__(self, url, how, route_added=False):
        self.url = url
        self.how = how
        self.route_added = route_added

    @staticmethod
    def find(bin_dir, url=None, hub=False):
        """`url`: this one and no other. `hub`: the hub at once. Neither: whatever works."""
        if hub:
            return Bus(None, "the hub, as asked")
        if url is None and os.environ.get("VOX_NAMESPACE") == "0":
            return Bus(None, "the hub, for want of a network namespace")
        wanted = url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
        reason = probe(bin_dir, wanted)
        if reason is None:
            return Bus(wanted, "probed")
        if wanted.startswith("udpm:") and add_route():
            if probe(bin_dir, wanted) is None:
                return Bus(wanted, "probed, after adding a multicast route on lo", route_added=True)
            remove_route()
        if url is not None:
            raise BusError(f"no message comes back on {wanted}: {reason}")
        return Bus(None, f"the hub, as no message comes back on {wanted}: {reason}")

    def hub_runs(self, port):
        self.url = f"tcpq://127.0.0.1:{port}"

    def leave(self):
        """Undoes what find() did to the machine."""
        if self.route_added:
            remove_route()
            self.route_added = False


def probe(bin_dir, url):
    """None where the bus works, else the reason, in the probe's words."""
    done = subprocess.run([bin_dir / "voxatlas-hub", "--probe", url], capture_output=True,
                          text=True, check=False)
    if done.returncode == 0:
        return None
    words = (done.stderr.strip() or done.stdout.strip() or f"exit code {done.returncode}")
    return words.splitlines()[-1]


def add_route():
    """Whether a multicast route on lo could be added. Never takes the place of another route."""
    return _ip("link", "set", "lo", "up") and _ip("route", "add", *ROUTE)


def remove_route():
    return _ip("route", "del", *ROUTE)


def _ip(*arguments):
    try:
        return subprocess.run(["ip", *arguments], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False
