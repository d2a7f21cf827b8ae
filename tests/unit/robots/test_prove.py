"""Robots that would blow up or hold absurd numbers are refused by name."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from app.errors import RobotError
from app.robots.prove import STEPS, prove_alive, refuse_absurd_numbers

PENDULUM = """<mujoco><worldbody><body name="bob" pos="{pos}"><joint axis="1 0 0" {joint}/>
<geom type="sphere" size="{size}" mass="1" pos="0 0 1"/></body></worldbody></mujoco>"""


def model_of(pos: str = "0 0 0", joint: str = "", size: str = "0.1") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(PENDULUM.format(pos=pos, joint=joint, size=size))


def test_a_sound_robot_passes_both() -> None:
    model = model_of()
    refuse_absurd_numbers(model, "bob.xml")
    prove_alive(model, np.zeros(1), "bob.xml")
    assert STEPS > 10


@pytest.mark.parametrize("numbers", [{"pos": "0 0 1e300"}, {"size": "1e9"}, {"pos": "0 -inf 0"}])
def test_absurd_numbers_are_refused_by_the_bodys_name(numbers: dict[str, str]) -> None:
    with pytest.raises(RobotError, match=r"bob\.xml, body bob: .*absurdly large"):
        refuse_absurd_numbers(model_of(**numbers), "bob.xml")


def test_a_robot_that_blows_up_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it stands
    with pytest.raises(RobotError, match="does not survive its first steps"):
        prove_alive(model_of(joint='stiffness="-1e12"'), np.array([0.5]), "bob.xml")
