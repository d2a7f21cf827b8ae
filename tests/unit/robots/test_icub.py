"""iCub: torso and left arm under the names its taxel files use, or a clear word where the wheel is absent."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import pytest

from app.errors import RobotError
from app.robots import icub
from app.robots.icub import icub_folder, load_icub

needs_icub = pytest.mark.skipif(icub_folder() is None, reason="the wheel icub-models is not installed")


@pytest.mark.robots
@needs_icub
def test_torso_and_left_arm_keep_their_names() -> None:
    robot = load_icub()
    assert [joint.name for joint in robot.joints][:4] == ["torso_pitch", "torso_roll", "torso_yaw", "l_shoulder_pitch"]
    assert len(robot.joints) == 10
    for name in ("chest", "l_upper_arm", "l_forearm", "l_hand"):
        assert robot.link(name).mesh is not None
    assert robot.link("l_forearm_dh_frame").mesh is None
    assert not any(link.name.startswith("r_") or "skin" in link.name for link in robot.links)


@pytest.mark.robots
@needs_icub
def test_overlapping_shells_are_excluded_and_said() -> None:
    findings = {finding.kind: finding.count for finding in load_icub().findings}
    assert findings["touching-links"] >= 4
    assert findings["armature"] == 10


def test_without_the_wheel_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def absent(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(icub.sys, "prefix", str(tmp_path))
    monkeypatch.setattr(icub.metadata, "files", absent)
    assert icub_folder() is None
    with pytest.raises(RobotError, match=r"icub-models.*pip install"):
        load_icub()
