"""MuJoCo's own warnings become findings: nothing is printed and no log file is written."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.build import smoke_test
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.mujoco_warnings import collect_warnings, warning_findings
from tactile_maps.robots.model.robot import Robot

EQUAL = "joint 'j' has equal lower and upper limits, limit ignored"
INERTIA = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
VISUAL = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
BALL = """<mujoco><worldbody><body><joint name="j" stiffness="{stiffness}"/><geom size="0.1"/></body></worldbody>
</mujoco>"""


@pytest.fixture(autouse=True)
def _silent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Iterator[None]:
    """Each test runs in an empty folder, in which MuJoCo writes no log; nothing is printed."""
    monkeypatch.chdir(tmp_path)
    yield
    assert capfd.readouterr() == ("", "")
    assert not Path("MUJOCO_LOG.TXT").exists()


def urdf_text(limits: str, kind: str = "revolute") -> str:
    return (
        f'<robot name="r"><link name="a">{INERTIA}{VISUAL}</link><link name="b">{INERTIA}{VISUAL}</link>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{limits}</joint></robot>'
    )


def load(name: str, text: str) -> Robot:
    path = Path(name)
    path.write_text(text)
    return load_robot_file(path)


def limit_findings_of(robot: Robot) -> list[Finding]:
    assert "mujoco-warning" not in {finding.kind for finding in robot.findings}
    return [finding for finding in robot.findings if finding.kind == "joint-limits"]


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_equal_limits_in_urdf_are_reported_with_place_value_and_remedy(kind):
    robot = load("r.urdf", urdf_text('<limit lower="0.5" upper="0.5"/>', kind))
    (finding,) = limit_findings_of(robot)
    assert finding.where == "joint j (0.5 to 0.5)"
    assert "state two different limits, or make the joint fixed" in finding.action
    assert finding.action.endswith(f"MuJoCo: {EQUAL}")
    assert robot.joints[0].upper == np.inf


def test_limits_of_zero_to_zero_in_urdf_are_reported():
    (finding,) = limit_findings_of(load("r.urdf", urdf_text('<limit lower="0" upper="0"/>')))
    assert finding.where == "joint j (0 to 0)"


def test_reversed_limits_in_urdf_are_reported_without_warning_of_mujoco():
    (finding,) = limit_findings_of(load("r.urdf", urdf_text('<limit lower="0.5" upper="0.2"/>')))
    assert finding.where == "joint j (0.5 to 0.2)"
    assert "MuJoCo" not in finding.action


@pytest.mark.parametrize("limits", ['<limit lower="-1" upper="0.5"/>', '<limit effort="1"/>', ""])
def test_valid_and_missing_limits_in_urdf_are_not_reported(limits):
    assert limit_findings_of(load("r.urdf", urdf_text(limits))) == []


def chain(joints: list[str]) -> str:
    bodies = "".join(f'<body pos="{i} 0 0"><joint {joint}/><geom size="0.1"/></body>' for i, joint in enumerate(joints))
    return f'<mujoco><default><joint range="3 3"/></default><worldbody><body>{bodies}</body></worldbody></mujoco>'


def test_ignored_limits_in_mjcf_are_reported_also_from_defaults_and_for_unnamed_joints():
    stated = ['name="turned" range="2 1"', 'name="inherits"', "", 'name="sound" range="1 2"', 'range="0 0"']
    (finding,) = limit_findings_of(load("r.xml", chain([*stated, 'range="2 1" limited="false"'])))
    assert finding.where == "joint turned (2 to 1), inherits (3 to 3), unnamed (3 to 3)"
    assert finding.count == 3


def test_finding_of_many_joints_names_the_first_ones():
    (finding,) = limit_findings_of(load("r.xml", chain([f'name="j{i}"' for i in range(7)])))
    assert finding.where.endswith("j4 (3 to 3), …")
    assert finding.count == 7


def test_other_warnings_of_the_parser_are_reported_with_their_element():
    findings = list[Finding]()
    text = urdf_text('<mimic joint="k"/>')
    parse_spec(text, {}, source="r.urdf", findings=findings)
    (finding,) = findings
    assert (finding.kind, finding.where) == ("mujoco-warning", "joint j")
    assert finding.action.startswith("MuJoCo warns of this; check it in the file. MuJoCo: <mimic> on joint 'j' ignored")


def test_repeated_warnings_are_counted_and_located_in_the_file_without_an_element():
    (finding,) = warning_findings(["too  much\n", "too  much\n"], source="r.xml")
    assert finding == Finding(
        "mujoco-warning", "r.xml", "MuJoCo warns of this; check it in the file. MuJoCo: too much", 2
    )


def test_unstable_robot_is_rejected_with_the_message_of_mujoco():
    model = mujoco.MjModel.from_xml_string(BALL.format(stiffness="-1e12"))
    with pytest.raises(RobotError, match=r"unstable \(found: Nan, Inf or huge value in Q\w+ at DOF 0"):
        smoke_test(model, np.array([0.5]), "ball.xml")


def test_warnings_of_stable_steps_are_findings():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option gravity="0 0 0"/><worldbody><body><joint/><geom size="0.1"/><body pos="1 0 0"><joint/>'
        '<geom size="0.1"/></body></body></worldbody></mujoco>'
    )
    assert smoke_test(model, np.zeros(2), "chain.xml") == []
    model.body_mass[:] = model.body_inertia[:] = 0
    (finding,) = smoke_test(model, np.zeros(2), "chain.xml")
    assert (finding.kind, finding.where) == ("mujoco-warning", "chain.xml")
    assert "singular" in finding.action


def warn() -> None:
    """Let MuJoCo warn in this thread."""
    parse_spec(urdf_text('<limit lower="0.5" upper="0.5"/>'), {}, source="r.urdf")


def step_from_nan() -> None:
    model = mujoco.MjModel.from_xml_string(BALL.format(stiffness="0"))
    data = mujoco.MjData(model)
    data.qpos[0] = np.nan
    mujoco.mj_step(model, data)


def in_thread(work: object) -> None:
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_warnings_of_other_threads_reach_the_previous_handler_which_is_restored():
    own = list[str]()
    mujoco.set_mju_user_warning(own.append)
    try:
        with collect_warnings() as outer:
            in_thread(step_from_nan)
            in_thread(warn)  # collects for itself, and ends before the outer one
            with collect_warnings() as inner:
                step_from_nan()
            assert (len(outer), len(inner), len(own)) == (0, 1, 1)
            step_from_nan()
            assert (len(outer), len(inner), len(own)) == (1, 1, 1)
        step_from_nan()
        assert (len(outer), len(own)) == (1, 2)
        with pytest.raises(ZeroDivisionError), collect_warnings():
            raise ZeroDivisionError
        step_from_nan()
        assert len(own) == 3
    finally:
        mujoco.set_mju_user_warning(None)


def test_warnings_of_another_thread_go_to_the_log_of_mujoco_without_handler():
    log = Path("MUJOCO_LOG.TXT")
    with collect_warnings() as texts:
        in_thread(step_from_nan)
    assert texts == []
    assert "QPOS" in log.read_text()
    log.unlink()
