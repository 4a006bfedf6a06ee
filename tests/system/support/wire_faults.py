"""Faults of the network under a bus, in the test's own network namespace: nftables, and a relay."""

import json
import pathlib
import subprocess
import sys

BUS_PORT = 7667
# The bus's own port, and those of ingests, tilestores and compressors; clients' are let through.
STREAM_PORTS = [BUS_PORT, *(BUS_PORT + offset + index for offset in (100, 200, 300)
                            for index in range(3))]
RELAY_OFFSET, RELAY_MARK = 10000, 7
RELAY = pathlib.Path(__file__).resolve().parent / "relay.py"
TABLE = "inet voxatlas_faults"


class Rules:
    """nftables rules, as long as the block lasts; afterwards `packets` says how many they hit."""

    def __init__(self, chain, rules):
        self.text = "\n".join([f"add table {TABLE}", f"add counter {TABLE} hit",
                               f"add chain {TABLE} faults {{ {chain} }}",
                               *(f"add rule {TABLE} faults {rule}" for rule in rules)])
        self.packets = 0

    def __enter__(self):
        subprocess.run(["nft", "-f", "-"], input=self.text, text=True, check=True)
        return self

    def __exit__(self, *_):
        listed = subprocess.run(["nft", "-j", "list", "counter", *TABLE.split(), "hit"],
                                capture_output=True, text=True, check=True)
        self.packets = json.loads(listed.stdout)["nftables"][-1]["counter"]["packets"]
        subprocess.run(["nft", "delete", "table", *TABLE.split()], check=True)


def drop(percent):
    """Loses so many of a hundred datagrams of the bus, of every kind, chosen at random."""
    return Rules("type filter hook input priority 0;",
                 [f"udp dport {BUS_PORT}-{BUS_PORT + 1000} numgen random mod 100 < {percent} "
                  "counter name hit drop"])


class Relay:
    """Sends every datagram by way of a process that doubles some and lets some overtake others."""

    def __init__(self, duplicated, delayed, delay_ms):
        self.options = [str(duplicated), str(delayed), str(delay_ms)]
        self.rules = Rules(
            "type filter hook output priority 0;",
            [f"udp dport {port} meta mark != {RELAY_MARK} counter name hit udp dport set "
             f"{port + RELAY_OFFSET}" for port in STREAM_PORTS])
        self.process = None
        self.counts = {}

    def __enter__(self):
        self.process = subprocess.Popen([sys.executable, "-B", RELAY, *self.options],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "listening\n"
        self.rules.__enter__()
        return self

    def __exit__(self, *what):
        self.rules.__exit__(*what)
        self.process.terminate()
        said, _ = self.process.communicate()
        self.counts = json.loads(said)
