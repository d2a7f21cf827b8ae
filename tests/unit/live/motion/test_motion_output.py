"""Motion wanted of a real robot: what the simulated arm's controller says, sent within limits, and every stop."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.core.errors import LiveError, SceneError
from app.live.arrival import Arrived
from app.live.data_age import SETTLE_SECONDS, DataAge
from app.live.measured_session import MeasuredSession
from app.live.motion.measured_controller import MeasuredController, WantedMotion
from app.live.motion.motion_output import MotionOutput
from app.live.motion.motion_sender import (
    OLDEST_SECONDS,
    VALID_SECONDS,
    WATCHDOG_SECONDS,
    MotionLimits,
    MotionSender,
    StopReason,
)
from app.live.prepare import as_measured
from app.live.readings import Reading, Unit
from app.tactile.press import press_skin
from tests.support.touch import bar_skin, prepared_bar

STEP = 0.01
FORWARD = ControlSettings(controller="hold_force", force_goal=2.0, force_gain=0.005)
LIMITS = MotionLimits(speed=0.05, force=8.0)


@dataclass
class Robot:
    """A robot whose skin and joint are streamed, and what reaches its driver.

    Attributes:
        put: What was sent to it, decoded.
    """

    limits: MotionLimits = LIMITS
    settings: ControlSettings = FORWARD
    put: list[dict] = field(default_factory=list)
    now: float = 100.0
    angle: float = 0.3
    live: bool = False

    def __post_init__(self) -> None:
        self.session = MeasuredSession(as_measured(prepared_bar()))
        self.ages = DataAge(live=self.live)
        self.output = MotionOutput(self.session, self.settings, self.ages, clock=lambda: self.now)

    def start(self) -> None:
        self.output.start_sending(lambda packet: self.put.append(json.loads(packet)), self.limits)

    def read(self, force=0.0, *, unit=Unit.PASCAL, joints=True, step=STEP, taxels=None, sent=None, values=None):
        """Take one reading, with ``sent`` as the sender's clock; only of ``taxels`` where they are given."""
        self.now += step
        skin = bar_skin()
        if values is None:
            values = press_skin(skin, skin.taxel_point(30), force=force) if force else np.zeros(len(skin))
        sent = self.now if sent is None else sent
        ids = None if taxels is None else np.asarray(taxels)
        part = values if ids is None else values[ids]
        posture = joints if isinstance(joints, dict) else {"hinge": self.angle} if joints else {}
        reading = Reading(sent, part, unit, ids, joints=posture)
        if self.session.apply(Arrived(reading, self.now, self.ages.add(sent, self.now))):
            self.session.make_frame()
            self.output.take()
        else:
            self.output.check()
        return self.output.wanted

    @property
    def velocities(self) -> list[float]:
        return [packet["velocities"]["hinge"] for packet in self.put]


def test_a_touch_above_the_goal_is_fled_and_one_below_is_followed():
    robot = Robot()
    for _ in range(5):
        wanted = robot.read()
    assert np.allclose(wanted.velocity, 0.0)  # where it was found, not the model's home
    fled = [robot.read(6.0).velocity[0] for _ in range(20)][-1]
    other = Robot()
    followed = [other.read(1.0).velocity[0] for _ in range(20)][-1]
    assert fled > 0.01  # pressed from above, the bar turns down about y
    assert followed < 0
    assert robot.output.wanted.force == pytest.approx(6.0, rel=0.02)


def test_nothing_is_sent_before_a_hand_says_so():
    robot = Robot()
    for _ in range(5):
        robot.read(5.0)
    assert not robot.put
    robot.start()
    robot.read(5.0)
    assert [packet["state"] for packet in robot.put] == ["moving"]


def test_motion_starts_from_the_posture_that_is_found_then():
    robot = Robot()
    for _ in range(30):
        robot.read(5.0)  # nothing follows: the wanted posture runs ahead
    robot.start()
    robot.read()
    assert robot.velocities == [0.0]


def test_what_is_too_fast_is_slowed_as_a_whole_and_counted():
    sent = []
    sender = MotionSender(("a", "b"), lambda packet: sent.append(json.loads(packet)), MotionLimits(speed=0.1))
    sender.start()
    sender.begin(0.0)
    for now, velocity in ((0.01, [0.4, -0.2]), (0.02, [0.05, 0.0]), (0.03, [-0.4, 0.2])):
        assert sender.show(WantedMotion(0.0, np.array(velocity), 0.0), now, measured=now)
    assert sent[0]["velocities"] == pytest.approx({"a": 0.1, "b": -0.05})
    assert sent[1]["velocities"] == {"a": 0.05, "b": 0.0}
    assert sent[2]["velocities"] == pytest.approx({"a": -0.1, "b": 0.05})
    assert (sender.state.sent, sender.state.slowed) == (3, 2)
    assert [packet["seq"] for packet in sent] == [0, 1, 2]
    assert all(packet["valid_s"] == VALID_SECONDS for packet in sent)


def _stopped(robot) -> str:
    """Why, once it is shown that three stops were sent and nothing after them."""
    assert [packet["state"] for packet in robot.put[-3:]] == ["stopped"] * 3
    assert robot.velocities[-3:] == [0.0] * 3
    count = len(robot.put)
    for _ in range(3):
        robot.read(3.0)
    assert len(robot.put) == count
    assert not robot.output.sending.sending
    assert robot.put[-1]["why"] == robot.output.sending.stopped.value
    return robot.output.sending.stopped


def _moving() -> Robot:
    robot = Robot()
    robot.read()
    robot.start()
    for _ in range(3):
        robot.read(5.0)
    assert robot.put[-1]["state"] == "moving"
    return robot


def test_a_contact_beyond_the_limit_stops():
    robot = _moving()
    robot.read(9.0)
    assert _stopped(robot) is StopReason.FORCE
    assert "8 N allowed" in robot.output.sending.detail


def test_the_controllers_own_stop_stops():
    robot = Robot(
        limits=MotionLimits(force=100.0), settings=ControlSettings(controller="hybrid", force_goal=2.0, max_force=10.0)
    )
    robot.read()
    robot.start()
    robot.read(5.0)
    for _ in range(5):
        robot.read(30.0)
    assert _stopped(robot) is StopReason.CONTROLLER


def test_a_stream_that_ceases_stops_and_one_that_comes_again_does_not_start():
    robot = _moving()
    robot.now += 0.9 * OLDEST_SECONDS
    robot.output.check()
    assert robot.output.sending.sending
    robot.now += 0.2 * OLDEST_SECONDS
    robot.output.check()
    assert _stopped(robot) is StopReason.STALE
    assert robot.output.sending.detail == "none for 0.17 s"


def test_a_hand_stops_and_starts_again():
    robot = _moving()
    robot.output.halt()
    assert _stopped(robot) is StopReason.BY_HAND
    robot.start()
    robot.read()
    assert robot.put[-1]["state"] == "moving"


def test_what_cannot_be_sent_stops_and_says_why():
    robot = Robot()
    robot.read()

    def fail(_packet: bytes) -> None:
        raise OSError("no route")

    robot.output.start_sending(fail, LIMITS)
    robot.read()
    assert robot.output.sending.stopped is StopReason.FAILED
    assert "no route" in robot.output.sending.detail
    assert "the stop was not sent" in robot.output.sending.detail


def test_without_forces_nothing_is_wanted():
    robot = Robot()
    robot.start()
    robot.read(5.0, unit=Unit.COUNTS)
    assert robot.output.wanted is None
    assert "no force is known" in robot.output.problem
    assert robot.output.sending.stopped is StopReason.UNKNOWN


def test_without_posture_nothing_is_wanted_and_sending_waits_for_it():
    robot = Robot()
    robot.start()
    assert robot.output.sending.waiting == "the first reading"
    robot.read(5.0, joints=False)
    assert robot.output.wanted is None
    assert "posture is not known" in robot.output.problem
    assert robot.output.sending.waiting == "joint hinge"
    assert robot.put == []
    robot.read(5.0)
    assert robot.velocities == [0.0]
    assert robot.output.sending.sending


def test_other_settings_are_taken_and_bad_ones_are_not():
    robot = Robot()
    robot.read()
    robot.output.use(ControlSettings(controller="impedance"))
    with pytest.raises(SceneError):
        robot.output.use(ControlSettings(controller="hybrid", stiffness=1e9))
    assert robot.read(5.0) is None
    assert "impedance yields" in robot.output.problem


def test_readings_far_apart_are_no_stream():
    controller = MeasuredController(prepared_bar().robot, prepared_bar().map, FORWARD)
    robot = Robot()
    robot.read()
    for _ in range(3):
        robot.read(6.0, step=1.0)
        assert np.allclose(controller.command(robot.session.frame, robot.session.facts).velocity, 0.0)


@pytest.mark.parametrize("limits", [{"speed": 0.0}, {"speed": 2.0}, {"force": 0.0}, {"force": float("nan")}])
def test_limits_out_of_range_are_refused(limits):
    with pytest.raises(LiveError, match="out of range"):
        MotionLimits(**limits)
