"""iCub's skin as a stream: channels that share a place, two links with the same rows, a whole body from pyCub."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tactile_maps.live.channels.matching import TaxelMatcher
from tactile_maps.live.readings.readings import Reading
from tactile_maps.live.readings.wire_format import decode
from tactile_maps.robots.library import load_robot
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_widgets.__main__ import main

BRIDGE = Path(__file__).resolve().parents[2] / "assets" / "guide" / "pycub_bridge.py"
PLATE = """<link name="{0}"><visual><origin xyz=".025 .025 0"/><geometry><box size=".07 .07 .02"/></geometry></visual>
<collision><origin xyz=".025 .025 0"/><geometry><box size=".07 .07 .02"/></geometry></collision></link>"""
JOINT = """<joint name="j_{0}" type="revolute"><parent link="base"/><child link="{0}"/><origin xyz="{1} 0 .1"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
LINKS = ("l_plate", "r_plate")
ROWS = 48
SHARED = {13: 12, 14: 12, 27: 26}
"""Rows at the place of another row."""


@pytest.fixture(scope="module")
def robot_and_skin(tmp_path_factory):
    """Files of a robot with two plates, and of a folder of positions with the same rows on both."""
    folder = tmp_path_factory.mktemp("icub")
    base = PLATE.format("base")
    plates = "".join(PLATE.format(link) + JOINT.format(link, 0.2 - 0.4 * k) for k, link in enumerate(LINKS))
    (folder / "robot.urdf").write_text(f'<robot name="two">{base}{plates}</robot>')
    places = [(0.007 * (row % 8), 0.007 * (row // 8), 0.01) for row in range(ROWS)]
    lines = [
        "0 0 0 0 0 0" if row % 12 in (6, 10) else " ".join(map(str, (*places[SHARED.get(row, row)], 0, 0, 1)))
        for row in range(ROWS)
    ]
    (folder / "skin").mkdir()
    for link, name in zip(LINKS, ("left_arm", "right_arm"), strict=True):
        head = f"name {link}\nspatial_sampling taxel\ntaxel2Repr ( {'3 ' * ROWS})\n[calibration]\n"
        (folder / "skin" / f"{name}.txt").write_text(head + "\n".join(lines) + "\n")
    return str(folder / "robot.urdf"), str(folder / "skin")


def table(path, labels, touched):
    """Write 30 readings of one value for each label; the labels ``touched`` are pressed in the last ten."""
    rows = [[200.0 * (label in touched and number >= 20) for label in labels] for number in range(30)]
    lines = [",".join(map(str, [0.02 * number, *row])) for number, row in enumerate(rows)]
    path.write_text("\n".join([",".join(["time", *labels]), *lines, ""]))
    return str(path)


def listened(capsys, readings, robot, skin):
    assert main(["listen", readings, "--robot", robot, "--skin", skin, "--tare", "10", "--json"]) == 0
    captured = capsys.readouterr()
    return json.loads(captured.out), captured.err


def test_touch_on_a_channel_with_a_shared_position_is_detected(robot_and_skin, capsys, tmp_path):
    robot, skin = robot_and_skin
    readings = table(tmp_path / "rows.csv", list(map(str, range(ROWS))), {"13", "14", "27"})
    found, errors = listened(capsys, readings, robot, f"{skin}/left_arm.txt")
    assert (found["contacts"], found["unheard"], found["unknown"], errors) == (2, 0, [], "")


def test_ids_used_on_two_links_require_the_link(robot_and_skin, capsys, tmp_path):
    robot, skin = robot_and_skin
    plain = table(tmp_path / "rows.csv", list(map(str, range(ROWS))), {"13"})
    found, errors = listened(capsys, plain, robot, skin)
    assert (found["contacts"], found["unheard"], found["taxels"]) == (0, 74, 74)
    assert (
        "13 (r_plate:13 or l_plate:13)" in found["ambiguous"] or "13 (l_plate:13 or r_plate:13)" in found["ambiguous"]
    )
    assert "values of ids that several taxels have" in errors
    assert "name them link:id" in errors
    labels = [f"{link}:{row}" for link in LINKS for row in range(ROWS)]
    found, errors = listened(capsys, table(tmp_path / "links.csv", labels, {"l_plate:13"}), robot, skin)
    assert (found["contacts"], found["unheard"], errors) == (1, 0, "")


def test_stream_of_all_rows_of_one_file_is_matched_by_row(robot_and_skin):
    robot, skin = robot_and_skin
    left = TaxelFiles([f"{skin}/left_arm.txt"]).skin(load_robot(robot))
    taxels, values = TaxelMatcher(left).match(Reading(0.0, np.arange(float(ROWS))))
    by_id = dict(zip((left.taxel_name(taxel).id for taxel in taxels.tolist()), values.tolist(), strict=True))
    assert (len(by_id), by_id[0], by_id[12], by_id[26], by_id[47]) == (37, 0.0, 14.0, 27.0, 47.0)


def test_pycub_bridge_sends_the_whole_body_without_a_table_of_ids(robot_and_skin):
    robot, positions = robot_and_skin
    bridge = runpy.run_path(str(BRIDGE))
    ids = bridge["ids_by_link"](Path(positions))
    activations = {link: np.zeros(len(ids[link])) for link in LINKS}
    activations["r_plate"][ids["r_plate"].index("r_plate:14")] = 0.75
    joints = [SimpleNamespace(name=f"j_{link}") for link in LINKS]
    client = SimpleNamespace(skin_activations=activations, joints=joints, get_joint_state=lambda names: [0.1, -0.2])
    first, second = (decode(packet) for packet in bridge["packets"](client, ids, 1.5, 4))
    assert (first.time, first.sequence, second.sequence) == (1.5, 4, 5)
    assert dict(first.joints) == {"j_l_plate": 0.1, "j_r_plate": -0.2}
    skin = TaxelFiles([positions]).skin(load_robot(robot))
    matcher = TaxelMatcher(skin)
    felt = [taxel for reading in (first, second) for taxel, value in zip(*matcher.match(reading), strict=True) if value]
    assert [(skin.patches[skin.patch_of[taxel]].link, skin.taxel_name(taxel).id) for taxel in felt] == [("r_plate", 12)]
    assert (matcher.heard.all(), matcher.unknown, matcher.ambiguous) == (True, set(), set())
