"""The last stretch: a spec becomes a robot that runs, or a reason why not."""

from __future__ import annotations

import mujoco
import pytest

from app.errors import RobotError
from app.robots import build
from app.robots.build import build_robot

TWO = """<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom size="0.1"/><body name="arm" pos="0 0 1">
<joint name="slide" type="slide" range="-1 1"/><joint name="free" axis="1 0 0"/>
<geom size="0.1" mass="MASS"/></body></body></worldbody></mujoco>"""


def robot_of(text: str, **options: object) -> build.Robot:
    return build_robot(mujoco.MjSpec.from_string(text), name="two", source="two.xml", assets={}, **options)


def test_kinds_and_limits_of_joints_are_kept() -> None:
    robot = robot_of(TWO.replace("MASS", "1"))
    slide, free = robot.joints
    assert (slide.slide, slide.lower, slide.upper) == (True, -1, 1)
    assert (free.slide, free.lower, free.upper) == (False, -float("inf"), float("inf"))


def test_masses_are_written_out_so_that_later_shapes_do_not_change_them() -> None:
    robot = robot_of(TWO.replace("MASS", "3"))
    assert robot.mjcf.count("<inertial") >= 1
    assert 'mass="3"' in robot.mjcf


def test_a_wished_home_is_taken() -> None:
    assert robot_of(TWO.replace("MASS", "1"), home={"slide": 0.5}).home == pytest.approx([0.5, 0])


def test_too_many_bodies_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "MAX_BODIES", 2)
    with pytest.raises(RobotError, match="more than 2 bodies"):
        robot_of(TWO.replace("MASS", "1"))


def test_a_robot_without_mass_is_refused_in_mujocos_words() -> None:
    with pytest.raises(RobotError, match=r"two\.xml.*cannot build.*mass"):
        robot_of(TWO.replace("MASS", "0"))
