"""Decoration goes without a word, soft bodies and absurd amounts go with one, before MuJoCo sees either."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest

from app.errors import RobotError
from app.robots.mjcf_cut import cut_mjcf

FILE = Path("robot.xml")


@pytest.mark.parametrize(
    ("element", "problem"),
    [
        ('<replicate count="1000000000"/>', "too many copies"),
        ('<replicate count="100"><replicate count="100"/></replicate>', "too many copies"),
        ('<replicate count="inf"/>', "too many copies"),
        ('<replicate count="many"/>', "not a number"),
        ('<mesh builtin="supersphere" params="2000 1 1"/>', "too fine"),
        ('<mesh builtin="supersphere" params="nan 1 1"/>', "too fine"),
        ('<composite type="cable"/>', "not supported"),
        ('<flexcomp file="x"/>', "not supported"),
        ('<model file="x"/>', "not supported"),
    ],
)
def test_absurd_and_soft_things_are_refused(element: str, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        cut_mjcf(fromstring(f"<mujoco><worldbody><body>{element}</body></worldbody></mujoco>"), FILE)


def test_a_few_copies_are_welcome() -> None:
    root = fromstring('<mujoco><worldbody><replicate count="10"/></worldbody></mujoco>')
    cut_mjcf(root, FILE)
    assert root.find(".//replicate") is not None


def test_files_for_show_are_not_asked_for() -> None:
    root = fromstring(
        '<mujoco><asset><texture file="a.png"/><hfield file="b.png"/><mesh file="c.stl"/>'
        '<material name="m" texture="t"><layer texture="t"/></material></asset>'
        '<worldbody><geom type="hfield"/><geom hfield="h"/><geom size="1"><plugin/></geom></worldbody>'
        "<option/><actuator/><keyframe/></mujoco>"
    )
    cut_mjcf(root, FILE)
    assert [element.tag for element in root.iter()] == [
        "mujoco", "asset", "mesh", "material", "worldbody", "geom", "keyframe",
    ]  # fmt: skip
    assert root.find(".//material").attrib == {"name": "m"}
