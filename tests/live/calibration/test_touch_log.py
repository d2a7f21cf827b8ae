"""Logs of touches of a robot by another of its links: the place follows from the joints, mistakes are named."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.touch_log import read_touch_log
from tactile_maps.robots.load import load_robot_file
from tactile_maps.skin.model.taxel_set import TaxelSet

ROBOT = """<mujoco><worldbody><body name="base">
  <geom type="box" size=".02 .02 .02"/>
  <body name="pad" pos="0 .1 0"><joint name="turn" axis="0 0 1" range="-90 90"/><geom type="box" size=".02 .02 .01"/>
    <body name="plate" pos="0 0 .02"><geom type="box" size=".02 .02 .01"/></body></body>
  <body name="tip" pos="0 -.1 0"><joint name="reach" type="slide" axis="0 1 0" range="0 .3"/>
    <geom type="sphere" size=".01"/>
    <body name="nail" pos="0 .02 0"><joint name="bend" range="-90 90"/><geom type="sphere" size=".01"/></body></body>
</body></worldbody></mujoco>"""
HEAD = "link,touching_link,x,y,z,joint:turn,joint:reach,100\npad,,,,,,,0\n"


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    path = tmp_path_factory.mktemp("robot") / "robot.xml"
    path.write_text(ROBOT)
    return load_robot_file(path)


@pytest.fixture
def log_of(tmp_path, robot):
    """Return the log of a text, of touches of one taxel on the pad."""
    taxels = TaxelSet("pad", "pad", np.zeros(1, dtype=np.int64), np.zeros((1, 3)), ids=np.array([100]))

    def read(text, robot=robot):
        (tmp_path / "log.csv").write_text(text)
        return read_touch_log(tmp_path / "log.csv", taxels, robot=robot)

    return read


def test_place_is_on_the_touched_link_at_the_posture_of_the_row(log_of):
    turned = np.pi / 2 - 1e-9
    log = log_of(f"{HEAD}pad,tip,0.01,0.02,0.03,{turned},0.15,7\n,tip,0.01,0.02,0.03,0,0.2,7\ntip,tip,0,0,0,,,0\n")
    # The tip is at y = -0.1 + reach, the pad at y = 0.1: from the pad the point has y = reach - 0.18, before its turn.
    assert np.allclose(log.places, [[-0.03, -0.01, 0.03], [0.01, 0.02, 0.03]], atol=1e-8)
    assert log.changes.tolist() == [[7.0], [7.0]]


@pytest.mark.parametrize(
    ("rows", "problem"),
    [
        ("pad,tipp,0,0,0,0,0,9", "line 3, touching_link: unknown link .found: tipp.. Did you mean tip[?]"),
        ("pad2,tip,0,0,0,0,0,9", "line 3, link: unknown link .found: pad2.. Did you mean pad[?]"),
        ("pad,,0,0,0,0,0,9", "line 3, touching_link: a place has no touching link. Name the link that touches"),
        ("pad,pad,0,0,0,0,0,9", "line 3, touching_link: no joint is between .* .found: pad.. Touch with a link that"),
        ("pad,plate,0,0,0,0,0,9", "line 3, touching_link: no joint is between .* .found: plate."),
        ("pad,nail,0,0,0,0,0,9", "line 3, touching_link: columns of joints are missing .found: bend.. Add joint:NAME"),
        ("pad,tip,0,0,0,90,0,9", "line 3, joint:turn: .* out of range .found: 90.0.. State -1.571 to 1.571 rad"),
        ("pad,tip,0,0,0,0,300,9", "line 3, joint:reach: .* out of range .found: 300.0.. State 0 to 0.3 m"),
        ("pad,tip,0,0,0,,0,9", "line 3, joint:turn: the joint position is missing or out of range .found: nan."),
        ("pad,tip,0,0,0,0,up,9", "line 3, joint:reach: expected a number .found: up."),
    ],
)
def test_invalid_touch_by_another_link_is_reported(log_of, rows, problem):
    with pytest.raises(LiveError, match=problem) as caught:
        log_of(HEAD + rows + "\n")
    assert re.search(r"log\.csv, line 3, \w", str(caught.value))


def test_touching_link_and_robot_must_be_given_together(log_of):
    with pytest.raises(LiveError, match=r"header: the place of a touching link needs a robot.*--robot"):
        log_of(HEAD, robot=None)
    with pytest.raises(LiveError, match=r"header: a column is missing: touching_link .*omit --robot"):
        log_of("x,y,z,100\n,,,0\n")
