"""Peer processes of the program in ``stop_reaction``: a sender of readings and a robot's driver.

Both are controlled through standard input and record events with times of the monotonic clock.
"""

from __future__ import annotations

import json
import socket
import struct
import sys
import threading
import time
from pathlib import Path


def send_readings(port: int, rate: float, at: int, light: Path, strong: Path) -> None:
    """Send readings until standard input ends; a line starts a force step, an empty line ends it.

    Writes the time of each step's first packet, and at the end the rate. ``at`` is the position of sequence number
    and time in a packet.
    """
    packets = [bytearray(path.read_bytes()) for path in (light, strong)]
    state = {"strong": 0, "ended": False}

    def listen() -> None:
        for line in sys.stdin:
            state["strong"] = int(bool(line.strip()))
        state["ended"] = True

    threading.Thread(target=listen, daemon=True).start()
    start = time.monotonic()
    number = 0
    before = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.connect(("127.0.0.1", port))
        while not state["ended"]:
            strong_now = state["strong"]
            packet = packets[strong_now]
            now = time.monotonic()
            struct.pack_into("<Id", packet, at, number % 2**32, now)
            opened.send(packet)
            if strong_now and not before:
                sys.stdout.write(f"{now!r}\n")
                sys.stdout.flush()
            before = strong_now
            number += 1
            time.sleep(max(start + number / rate - time.monotonic(), 0.0))
        sys.stdout.write(f"rate {number / (time.monotonic() - start)!r}\n")


def be_driver() -> None:
    """Receive packets for the robot until standard input ends; write time and reason of each stop's first packet."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.bind(("127.0.0.1", 0))
        sys.stdout.write(f"{opened.getsockname()[1]}\n")
        sys.stdout.flush()

        def end() -> None:
            sys.stdin.read()
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as last:
                last.sendto(b"end", opened.getsockname())

        threading.Thread(target=end, daemon=True).start()
        moving = False
        while (packet := opened.recv(65536)) != b"end":
            now = time.monotonic()
            said = json.loads(packet)
            if moving and said["state"] == "stopped":
                sys.stdout.write(f"{now!r} {said['why']}\n")
                sys.stdout.flush()
            moving = said["state"] == "moving"


if __name__ == "__main__":
    if sys.argv[1] == "send":
        send_readings(int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), Path(sys.argv[5]), Path(sys.argv[6]))
    else:
        be_driver()
