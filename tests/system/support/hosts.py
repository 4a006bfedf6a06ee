"""Several hosts in one: network namespaces with an interface each, joined by a bridge.

The test's own namespace is on the bridge, too, as 10.77.0.1. Each host has lo, eth0 and the one
route that several machines need: multicast through eth0.
"""

import subprocess

BRIDGE, NET = "br77", "10.77.0"
HERE = f"{NET}.1"


def _run(*command):
    subprocess.run([str(part) for part in command], check=True, stdin=subprocess.DEVNULL)


class Host:
    def __init__(self, number):
        self.address = f"{NET}.{number + 2}"
        self.port = f"vox{number}"
        self.keeper = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo there; exec cat"],
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.keeper.stdout.readline()  # Its namespace is there.
        _run("ip", "link", "add", self.port, "type", "veth", "peer", "name", "eth0", "netns",
             self.keeper.pid)
        _run("ip", "link", "set", self.port, "master", BRIDGE, "up")
        for words in (["link", "set", "lo", "up"],
                      ["address", "add", f"{self.address}/24", "dev", "eth0"],
                      ["link", "set", "eth0", "up"],
                      ["route", "add", "224.0.0.0/4", "dev", "eth0"]):
            _run(*self.enter("ip", *words))

    def enter(self, *command):
        """The command that runs `command` on this host."""
        return ["nsenter", f"--net=/proc/{self.keeper.pid}/ns/net", "--", *command]

    def cut_off(self):
        _run("ip", "link", "set", self.port, "down")

    def come_back(self):
        _run("ip", "link", "set", self.port, "up")

    def remove(self):
        self.keeper.kill()
        self.keeper.communicate()


class Hosts:
    """`hosts[i]`; gone after the block."""

    def __init__(self, count):
        self.count = count
        self.hosts = []

    def __enter__(self):
        _run("ip", "link", "add", BRIDGE, "type", "bridge", "mcast_snooping", "0")
        _run("ip", "address", "add", f"{HERE}/24", "dev", BRIDGE)
        _run("ip", "link", "set", BRIDGE, "up")
        _run("ip", "route", "replace", "224.0.0.0/4", "dev", BRIDGE)
        self.hosts = [Host(number) for number in range(self.count)]
        return self.hosts

    def __exit__(self, *_):
        for host in self.hosts:
            host.remove()
        _run("ip", "link", "del", BRIDGE)
        _run("ip", "route", "replace", "224.0.0.0/4", "dev", "lo")
