"""How many bytes went over each channel, counted by the kernel: it costs the services nothing."""

import json
import subprocess

BUS_PORT = 7667
PLAIN = ["ACK", "STATUS", "TILE_UPDATE", "MODEL_REQUEST", "TILES_REQUEST", "TILE_REQUEST"]
CLASSES = {"INGEST": 100, "STORE": 200, "COMPRESS": 300}
# Of LCM's short message: the UDP header, magic and number, 8 bytes each, then the channel's name.
NAME_BIT = 8 * (16 + len("VOXATLAS_"))


class ChannelBytes:
    """nftables counters in this network namespace, from its making to read()."""

    def __init__(self, services_of_a_class):
        rules = ["add table inet voxatlas_bench",
                 "add chain inet voxatlas_bench out { type filter hook output priority 0; }"]
        for name in PLAIN:
            rules += self._counted(name, f"@th,{NAME_BIT},{8 * (len(name) + 1)} "
                                   f"0x{(name + chr(0)).encode().hex()}")
        for kind, offset in CLASSES.items():
            for index in range(services_of_a_class):
                rules += self._counted(f"CHUNK_{kind}_{index}",
                                       f"udp dport {BUS_PORT + offset + index}")
        subprocess.run(["nft", "-f", "-"], input="\n".join(rules), text=True, check=True)

    @staticmethod
    def _counted(name, match):
        return [f"add counter inet voxatlas_bench {name}",
                f"add rule inet voxatlas_bench out {match} counter name {name}"]

    @staticmethod
    def read():
        """Bytes by channel, those that carried any; the counters are gone after it."""
        listed = subprocess.run(["nft", "-j", "list", "counters", "table", "inet",
                                 "voxatlas_bench"], capture_output=True, text=True, check=True)
        subprocess.run(["nft", "delete", "table", "inet", "voxatlas_bench"], check=True)
        counters = [item["counter"] for item in json.loads(listed.stdout)["nftables"]
                    if "counter" in item]
        return {c["name"]: c["bytes"] for c in counters if c["bytes"] > 0}
