#!/usr/bin/env python3
"""A bad road for datagrams: relay.py DUPLICATED DELAYED DELAY_MS, shares of 1.

Listens where nftables sends the bus's datagrams (wire_faults.py) and passes each on to where it was
meant to go: some twice, some late, so that others overtake them. Ends on SIGTERM, saying what it did.
"""

import heapq
import json
import random
import select
import signal
import socket
import struct
import sys
import time

from wire_faults import RELAY_MARK, RELAY_OFFSET, STREAM_PORTS

GROUP = "239.255.76.67"
BUFFER_BYTES = 64 << 20
SO_RCVBUFFORCE, SO_MARK = 33, 36


def listen(port):
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, BUFFER_BYTES)
    receiver.bind((GROUP, port))
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                        struct.pack("4sL", socket.inet_aton(GROUP), socket.INADDR_ANY))
    receiver.setblocking(False)
    return receiver


def main(duplicated, delayed, delay_ms):
    receivers = {listen(port + RELAY_OFFSET): port for port in STREAM_PORTS}
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sender.setsockopt(socket.SOL_SOCKET, SO_MARK, RELAY_MARK)
    counts = {"passed": 0, "duplicated": 0, "delayed": 0}
    going = []
    signal.signal(signal.SIGTERM, lambda *_: going.append("home"))
    print("listening", flush=True)
    late = []  # (when, tie-breaker, port, datagram)
    while not going:
        now = time.monotonic()
        wait = max(0.0, min(0.1, late[0][0] - now)) if late else 0.1
        for receiver in select.select(list(receivers), [], [], wait)[0]:
            port, datagram = receivers[receiver], receiver.recv(65536)
            counts["passed"] += 1
            copies = 1 + (random.random() < duplicated)
            counts["duplicated"] += copies - 1
            for _ in range(copies):
                if random.random() >= delayed:
                    sender.sendto(datagram, (GROUP, port))
                    continue
                counts["delayed"] += 1
                when = time.monotonic() + random.random() * delay_ms / 1000
                heapq.heappush(late, (when, counts["delayed"], port, datagram))
        while late and late[0][0] <= time.monotonic():
            _, _, port, datagram = heapq.heappop(late)
            sender.sendto(datagram, (GROUP, port))
    print(json.dumps(counts))


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
