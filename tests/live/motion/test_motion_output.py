"""Motion requested of a real robot: commands of the simulated arm's controller, sending within limits, and stops."""

from __future__ import annotations

import errno
import json
import threading
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import LiveError, SceneError
from tactile_maps.live.calibration.calibration import GRAVITY, Calibration, ValueMode
from tactile_maps.live.channels.last_heard import FROZEN_SECONDS
from tactile_maps.live.motion.command_latency import latency_text
from tactile_maps.live.motion.input_monitor import LEAST_PRESSURE
from tactile_maps.live.motion.measured_controller import MeasuredController, RequestedMotion, strongest_patch
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import (
    DEADLINE,
    OLDEST_SECONDS,
    VALID_SECONDS,
    WATCHDOG_SECONDS,
    MotionLimits,
    MotionSender,
    StopReason,
)
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.data_age import SETTLE_SECONDS, DataAge
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.facts import tare_doubt
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.session.skin_readings import MOST_PRESSURE
from tactile_maps.session.inputs import ReadingChanged
from tactile_maps.tactile.press import press_skin
from tests.live.channels.test_tare import PRESSED
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
    max_speed: float = np.inf
    settings: ControlSettings = FORWARD
    put: list[dict] = field(default_factory=list)
    now: float = 100.0
    angle: float = 0.3
    live: bool = False
    delays: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        prepared = prepared_bar()
        joints = tuple(replace(joint, max_speed=self.max_speed) for joint in prepared.robot.joints)
        prepared = replace(prepared, robot=replace(prepared.robot, joints=joints))
        self.session = MeasuredSession(as_measured(prepared))
        self.ages = DataAge(live=self.live)
        self.output = MotionOutput(self.session, self.settings, self.ages, clock=self._clock)

    def _clock(self) -> float:
        self.now += self.delays.pop(0) if self.delays else 0.0
        return self.now

    def start(self, **settings) -> None:
        self.output.start_sending(lambda packet: self.put.append(json.loads(packet)), self.limits, **settings)
        assert [packet["why"] for packet in self.put[-2:]] == ["nothing is sent yet"] * 2
        del self.put[-2:]

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
        return self.output.requested

    @property
    def velocities(self) -> list[float]:
        return [packet["velocities"]["hinge"] for packet in self.put]


def test_robot_retreats_from_touch_above_the_goal_and_follows_touch_below_it():
    robot = Robot()
    for _ in range(5):
        requested = robot.read()
    assert np.allclose(requested.velocity, 0.0)  # at the measured posture, not at the model's home
    fled = [robot.read(6.0).velocity[0] for _ in range(20)][-1]
    other = Robot()
    followed = [other.read(1.0).velocity[0] for _ in range(20)][-1]
    assert fled > 0.01  # pressed from above, the bar turns down about y
    assert followed < 0
    assert robot.output.requested.force == pytest.approx(6.0, rel=0.02)


def test_nothing_is_sent_before_the_user_starts_sending():
    robot = Robot()
    for _ in range(5):
        robot.read(5.0)
    assert not robot.put
    robot.start()
    robot.read(5.0)
    assert [packet["state"] for packet in robot.put] == ["moving"]


def test_motion_starts_from_the_posture_measured_at_the_start():
    robot = Robot()
    for _ in range(30):
        robot.read(5.0)  # no robot follows: the requested posture runs ahead
    robot.start()
    robot.read()
    assert robot.velocities == [0.0]


def test_too_fast_motion_is_scaled_uniformly_and_counted():
    sent = []
    sender = MotionSender(("a", "b"), lambda packet: sent.append(json.loads(packet)), MotionLimits(speed=0.1))
    sender.start(0.0)
    del sent[:]
    sender.begin(0.0)
    for now, velocity in ((0.01, [0.4, -0.2]), (0.02, [0.05, 0.0]), (0.03, [-0.4, 0.2])):
        assert sender.show(RequestedMotion(0.0, np.array(velocity), 0.0), now, measured=now)
    assert sent[0]["velocities"] == pytest.approx({"a": 0.1, "b": -0.05})
    assert sent[1]["velocities"] == {"a": 0.05, "b": 0.0}
    assert sent[2]["velocities"] == pytest.approx({"a": -0.1, "b": 0.05})
    assert (sender.state.sent, sender.state.slowed) == (3, 2)
    assert [packet["seq"] for packet in sent] == [2, 3, 4]
    assert all(packet["valid_s"] == VALID_SECONDS for packet in sent)


def test_speed_limits_of_the_model_apply_to_their_joints():
    sent = []
    speeds = [np.inf, 0.05, 0.0]
    sender = MotionSender(
        "abc",
        lambda packet: sent.append(json.loads(packet)["velocities"]),
        MotionLimits(speed=0.1),
        model_speeds=speeds,
    )
    sender.start(0.0)
    del sent[:]
    sender.begin(0.0)
    for velocity in ([0.2, -0.2, 0.0], [0.2, 0.01, 0.0], [0.08, 0.05, 0.0], [0.08, 0.05, 1e-6]):
        assert sender.show(RequestedMotion(0.0, np.array(velocity), 0.0), 0.01, measured=0.01)
    assert sent[0] == pytest.approx({"a": 0.05, "b": -0.05, "c": 0.0})
    assert sent[1] == pytest.approx({"a": 0.1, "b": 0.005, "c": 0.0})
    assert sent[2] == {"a": 0.08, "b": 0.05, "c": 0.0}
    assert sent[3] == {"a": 0.0, "b": 0.0, "c": 0.0}
    assert sender.state.slowed == 3


def test_motion_output_keeps_the_speed_limit_of_the_model_and_states_it():
    robot = Robot(max_speed=0.002)
    for _ in range(5):
        robot.read()
    assert robot.output.speed_limits == ""
    robot.start()
    for _ in range(20):
        robot.read(6.0)
    assert 0 < max(np.abs(robot.velocities)) <= 0.002
    stated = (
        "at most 0.05 rad/s (m/s for slides) in each joint; limited further by the robot's model: hinge 0.002 rad/s"
    )
    assert robot.output.speed_limits == stated


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


def test_contact_above_the_force_limit_stops_motion():
    robot = _moving()
    robot.read(9.0)
    assert _stopped(robot) is StopReason.FORCE
    assert robot.output.sending.detail == "9.0 N, 8 N allowed"


def test_stop_of_the_controller_stops_sending():
    robot = Robot(
        limits=MotionLimits(force=100.0), settings=ControlSettings(controller="hybrid", force_goal=2.0, max_force=10.0)
    )
    robot.read()
    robot.start()
    robot.read(5.0)
    for _ in range(5):
        robot.read(30.0)
    assert _stopped(robot) is StopReason.CONTROLLER


def test_motion_stops_when_the_stream_is_lost_and_does_not_restart_by_itself():
    robot = _moving()
    robot.now += 0.9 * OLDEST_SECONDS
    robot.output.check()
    assert robot.output.sending.sending
    robot.now += 0.2 * OLDEST_SECONDS
    robot.output.check()
    assert _stopped(robot) is StopReason.STALE
    assert robot.output.sending.detail == "none for 0.17 s"


def test_user_stops_and_restarts_motion():
    robot = _moving()
    robot.output.halt()
    assert _stopped(robot) is StopReason.BY_HAND
    robot.start()
    robot.read()
    assert robot.put[-1]["state"] == "moving"


def test_failed_sending_stops_motion_with_the_reason():
    robot = Robot()
    lost = []
    robot.read()

    def put(_packet: bytes) -> None:
        lost.append(len(lost))
        if len(lost) > 2:
            raise OSError(errno.EHOSTUNREACH, "No route to host")

    robot.output.start_sending(put, LIMITS)
    robot.read()
    assert robot.output.sending.stopped is StopReason.FAILED
    assert robot.output.sending.detail == "No route to host; the stop was not sent"
    assert len(lost) == 2 + 1 + 3  # a velocity, and each stop is tried


def test_address_that_rejects_the_first_packets_is_named():
    def put(_packet: bytes) -> None:
        raise ConnectionRefusedError("refused")

    with pytest.raises(LiveError, match="no program receives at the driver's address.*Start the robot's driver first"):
        Robot().output.start_sending(put, LIMITS)


def test_no_motion_is_requested_without_forces():
    robot = Robot()
    robot.start()
    robot.read(5.0, unit=Unit.COUNTS)
    assert robot.output.requested is None
    assert "cannot be controlled" in robot.output.problem
    assert robot.output.sending.stopped is StopReason.UNKNOWN


def test_no_motion_is_requested_without_posture_and_sending_waits_for_it():
    robot = Robot()
    robot.start()
    assert robot.output.sending.waiting == "the first reading"
    robot.read(5.0, joints=False)
    assert robot.output.requested is None
    assert "posture is not known" in robot.output.problem
    assert robot.output.sending.waiting == "joint hinge"
    assert robot.put == []
    robot.read(5.0)
    assert robot.velocities == [0.0]
    assert robot.output.sending.sending


def test_valid_settings_are_applied_and_invalid_ones_rejected():
    robot = Robot()
    robot.read()
    robot.output.use(ControlSettings(controller="impedance"))
    with pytest.raises(SceneError):
        robot.output.use(ControlSettings(controller="hybrid", stiffness=1e9))
    assert robot.read(5.0) is None
    assert "no desired motion" in robot.output.problem


def test_sparse_readings_do_not_count_as_a_stream():
    controller = MeasuredController(prepared_bar().robot, prepared_bar().map, FORWARD)
    robot = Robot()
    robot.read()
    for _ in range(3):
        robot.read(6.0, step=1.0)
        assert np.allclose(controller.command(robot.session.frame, robot.session.facts).velocity, 0.0)


@pytest.mark.parametrize("limits", [{"speed": 0.0}, {"speed": 2.0}, {"force": 0.0}, {"force": float("nan")}])
def test_limits_out_of_range_are_rejected(limits):
    with pytest.raises(LiveError, match="(speed|force) limit is out of range"):
        MotionLimits(**limits)


def test_sending_waits_for_readings_without_a_timeout():
    robot = Robot(live=True)
    robot.start()
    robot.now += 1000.0
    robot.output.check()
    robot.output.check_deadline()
    assert robot.output.sending.waiting == "the first reading"
    assert robot.put == []
    robot.output.halt()
    assert [packet["state"] for packet in robot.put] == ["stopped"] * 3


def test_sending_waits_until_the_ages_have_settled():
    robot = Robot(live=True)
    robot.start()
    awaited = []
    while not robot.put and len(awaited) < 1000:
        awaited.append(robot.output.sending.waiting)
        robot.read(5.0)
    assert len(awaited) == pytest.approx(SETTLE_SECONDS / STEP, abs=2)
    assert set(awaited[1:]) == {"readings that arrive evenly"}
    assert robot.velocities == [0.0]


def _moving_live(**parts) -> Robot:
    robot = Robot(live=True, **parts)
    robot.start()
    for _ in range(1000):
        if not robot.output.sending.sending:
            robot.read(1.0)
    return robot


def test_readings_that_fall_behind_stop_motion_as_too_old():
    robot = _moving_live()
    sent = robot.now
    for _ in range(200):
        sent += 0.5 * STEP  # a queue: half of what happens arrives
        robot.read(1.0, sent=sent)
        if not robot.output.active:
            break
    age = robot.now - sent
    assert OLDEST_SECONDS < age < OLDEST_SECONDS + 2 * STEP
    assert _stopped(robot) is StopReason.BACKLOG
    assert robot.output.sending.detail == "the newest is 0.15 s old"


@pytest.mark.parametrize("by", [-5.0, 5.0])
def test_changed_sender_clock_stops_motion(by):
    robot = _moving_live()
    robot.read(1.0, sent=robot.now + STEP + by)
    assert robot.output.sending.stopped is StopReason.CLOCK


def test_joint_that_is_no_longer_sent_stops_motion_and_is_named():
    robot = _moving()
    for _ in range(30):
        robot.read(1.0, joints=False)
    assert _stopped(robot) is StopReason.NOT_HEARD
    assert robot.output.sending.detail == "joint hinge: not heard for 0.15 s"


def test_taxels_that_are_no_longer_sent_stop_motion_and_are_named():
    robot = _moving()
    for _ in range(30):
        robot.read(1.0, taxels=[taxel for taxel in range(60) if taxel not in (7, 9)])
    assert _stopped(robot) is StopReason.NOT_HEARD
    assert robot.output.sending.detail == "taxel 7, taxel 9: not heard for 0.15 s"


@pytest.mark.long
def test_parts_of_the_skin_may_arrive_in_turn():
    robot = Robot()
    robot.start()
    for number in range(100):
        robot.read(1.0, taxels=range(30) if number % 2 else range(30, 60))
    assert robot.output.sending.sending
    assert robot.output.sending.sent == 99  # all but the first, when half of the skin was not heard yet


@pytest.mark.parametrize(
    ("position", "said"),
    [
        (1e300, "joint hinge: 1e+300. From -1.6 to 1.6"),
        (-1.7, "joint hinge: -1.7. From -1.6 to 1.6"),
        (0.9, "joint hinge: moved by 0.6 in 0.01 s"),
    ],
)
def test_impossible_position_stops_motion_and_names_the_joint(position, said):
    robot = _moving()
    robot.read(1.0, joints={"hinge": position})
    assert _stopped(robot) is StopReason.IMPLAUSIBLE
    assert robot.output.sending.detail == said


def test_impossible_value_stops_motion_and_names_the_taxel():
    robot = _moving()
    values = np.zeros(60)
    values[13] = -1.1 * MOST_PRESSURE
    robot.read(values=values)
    assert _stopped(robot) is StopReason.IMPLAUSIBLE
    assert robot.output.sending.detail == "taxel 13: -1.1e+07 Pa. At most 1e+07 Pa"


def test_frozen_part_of_the_skin_stops_motion():
    robot = _moving()
    random = np.random.default_rng(0)
    for _ in range(220):
        robot.read(values=random.normal(0.0, 5.0, 60))
    assert robot.output.sending.sending
    still = random.normal(0.0, 5.0, 60)
    began = robot.now
    for _ in range(200):
        if robot.output.active:
            robot.read(values=still)
    assert robot.now - began == pytest.approx(FROZEN_SECONDS, abs=2 * STEP)
    assert _stopped(robot) is StopReason.FROZEN
    assert robot.output.sending.detail == "patch top for 0.50 s"


def test_tare_stops_motion():
    robot = _moving()
    robot.session.tare(10)
    robot.read(1.0)
    assert _stopped(robot) is StopReason.UNKNOWN
    assert "tared" in robot.output.sending.detail


BROAD = 30 * PRESSED
"""Pressures of a touch of several taxels [Pa]."""


def _tared(values: FloatArray) -> Robot:
    """Robot whose skin was tared with these values."""
    robot = Robot(limits=MotionLimits(force=100.0))
    robot.session.tare(20)
    for _ in range(20):
        robot.read(values=values)
    return robot


def _fall(robot: Robot) -> None:
    """Read values that fall below their baseline until this is noticed, or sending ends."""
    for _ in range(10):
        robot.read(values=-BROAD)


def test_readings_that_fall_below_their_baseline_stop_motion():
    robot = _tared(0 * BROAD)
    robot.start()
    robot.read(3.0)
    assert robot.put[-1]["state"] == "moving"
    _fall(robot)
    assert _stopped(robot) is StopReason.DOUBTFUL_TARE
    assert robot.put[-1]["why"] == "the tare is doubtful"
    assert robot.output.sending.detail.startswith("Readings of taxel ")
    assert robot.output.sending.detail.endswith(
        "fall below their baseline: they are inverted, or something touched the skin during the tare"
    )


def test_doubtful_tare_ends_waiting_before_motion_is_sent():
    robot = Robot()
    robot.session.tare(20)
    robot.start()
    for _ in range(19):
        robot.read(values=BROAD)
    assert robot.output.sending.waiting == "the end of the tare"
    assert robot.put == []
    robot.read(values=BROAD)
    assert _stopped(robot) is StopReason.DOUBTFUL_TARE
    assert "something seems to have touched taxel " in robot.output.sending.detail
    assert robot.output.sending.sent == 0
    robot.session.tare(20)
    for _ in range(21):
        robot.read()
    assert not robot.output.active, "a stop does not end by itself"


@pytest.mark.parametrize("every", [False, True])
def test_accepted_doubt_does_not_stop_motion_but_another_one_does(every):
    robot = _tared(BROAD)
    doubt = tare_doubt(robot.session.facts)
    assert doubt.startswith("During the tare something seems to have touched taxel ")
    robot.start(accepted=None if every else doubt)
    for _ in range(3):
        robot.read(values=BROAD)
    assert robot.put[-1]["state"] == "moving"
    _fall(robot)
    assert tare_doubt(robot.session.facts) != doubt
    assert robot.output.sending.sending is every
    assert every or _stopped(robot) is StopReason.DOUBTFUL_TARE


def test_strongest_contact_is_compared_with_the_force_limit():
    robot = _moving()
    skin = bar_skin()
    along = skin.patches[0].taxels.positions[:, 0]
    ends = skin.taxel_point(int(np.argmin(along))), skin.taxel_point(int(np.argmax(along)))
    robot.read(values=press_skin(skin, ends[0], force=9.0) + press_skin(skin, ends[1], force=1.0))
    assert len(robot.session.frame.regions) == 2
    assert _stopped(robot) is StopReason.FORCE


def _moving_with_threshold(threshold: float) -> Robot:
    robot = _moving()
    robot.session.submit(ReadingChanged(ReadingSettings(threshold=threshold)))
    robot.session.apply_inputs()
    return robot


def test_force_below_the_contact_threshold_can_stop_motion():
    robot = _moving_with_threshold(1e6)
    robot.read(9.0)
    assert robot.session.frame.regions == ()
    assert _stopped(robot) is StopReason.FORCE
    assert robot.output.sending.detail == (
        "9.0 N, 8 N allowed; 9.0 N below the contact threshold on patch top: tare again or lower the threshold"
    )
    robot = _moving_with_threshold(1e6)
    robot.read(7.0)
    assert robot.output.sending.sending


def test_force_is_known_at_once_when_pressures_are_shown_again():
    robot = Robot()
    robot.session.tare(20)
    random = np.random.default_rng(5)
    touch = press_skin(bar_skin(), bar_skin().taxel_point(30), force=9.0)

    def read(count):
        for _ in range(count):
            robot.read(values=0.05 * touch + random.normal(0, 1.0, 60), unit=Unit.COUNTS)

    robot.read(values=random.normal(0, 1.0, 60), unit=Unit.COUNTS)
    for _ in range(20):
        robot.read(values=random.normal(0, 1.0, 60), unit=Unit.COUNTS)
    read(1)
    robot.session.weights.weigh(9.0 / GRAVITY)
    read(2)
    assert robot.output.requested.force == pytest.approx(9.0, rel=0.05)
    robot.session.readings.request_mode(ValueMode.BASELINE)
    read(2)
    robot.session.readings.request_mode(ValueMode.PRESSURE)
    read(1)
    assert robot.output.requested.force == pytest.approx(9.0, rel=0.05)
    robot.start()
    read(200)
    assert _stopped(robot) is StopReason.FORCE
    assert "below the contact threshold" not in robot.output.sending.detail


def test_contact_threshold_inside_a_press_does_not_split_its_force():
    values = press_skin(bar_skin(), bar_skin().taxel_point(30), force=7.0) + 100.0  # 0.038 m² more of it: 3.8 N
    robot = _moving()
    robot.read(values=values)
    assert 0 < robot.session.frame.regions[0].force < LIMITS.force
    assert _stopped(robot) is StopReason.FORCE


def test_noise_of_the_skin_does_not_count_as_force():
    skin = bar_skin()
    noise = TaxelNoise(np.full(60, 100.0), np.full(60, 1e6))
    robot = Robot()
    sd = 100.0 * float(np.sqrt((skin.areas**2).sum()))
    even = skin.areas / (skin.areas**2).sum()  # a pressure that adds up to 1 N
    for deviations, found in ((2.9, 0.0), (4.0, sd)):
        robot.read(values=deviations * sd * even)
        assert strongest_patch(robot.session.frame, skin, noise) == ("top", pytest.approx(found), pytest.approx(found))
    assert strongest_patch(robot.session.frame, skin, None).total == pytest.approx(4.0 * sd)
    robot.read(values=-even)
    assert strongest_patch(robot.session.frame, skin, None).total == 0.0


def test_tare_measures_the_noise():
    robot = Robot()
    assert robot.session.readings.noise is None
    robot.session.tare(20)
    random = np.random.default_rng(0)
    for _ in range(20):
        robot.read(values=random.normal(0.0, 100.0, 60))
    assert robot.session.readings.noise.sd.mean() == pytest.approx(100.0, rel=0.1)


@pytest.mark.parametrize("pressure", [1.1 * LEAST_PRESSURE, 1.1 * MOST_PRESSURE])
def test_pressure_made_impossible_by_calibration_stops_motion_and_names_the_taxel(pressure):
    robot = Robot(limits=MotionLimits(force=200.0))
    robot.session = MeasuredSession(
        as_measured(prepared_bar()), calibration=Calibration(np.full(60, 1e4), np.zeros(60))
    )
    robot.output = MotionOutput(robot.session, FORWARD, robot.ages, clock=robot._clock)
    robot.read(unit=Unit.COUNTS)
    robot.start()
    robot.read(unit=Unit.COUNTS)
    assert robot.output.sending.sending
    values = np.zeros(60)
    values[13] = 1e-4 * pressure
    robot.read(unit=Unit.COUNTS, values=values)
    assert robot.output.sending.stopped is StopReason.IMPLAUSIBLE
    assert robot.output.sending.detail == f"taxel 13: {pressure:g} Pa after calibration. From -100000 to 1e+07 Pa"


def test_force_that_is_not_finite_stops_motion():
    sent = []
    sender = MotionSender(("a",), sent.append, LIMITS)
    sender.start(0.0)
    del sent[:]
    sender.check_force(float("nan"), 0.0)
    assert sender.state.stopped is StopReason.FORCE


def test_force_limit_is_checked_before_the_controller_runs():
    robot = Robot()
    robot.read()
    robot.output.use(ControlSettings(controller="impedance"))  # refuses to work
    robot.start()
    robot.read(9.0)
    assert robot.output.sending.stopped is StopReason.FORCE


def test_slow_controller_sends_nothing():
    robot = _moving()
    robot.delays = [0.0, VALID_SECONDS + 0.01]  # the second time is read after the controller has run
    robot.read(1.0)
    assert robot.output.sending.stopped is StopReason.OVERRUN
    assert [packet["state"] for packet in robot.put[-4:]] == ["moving", "stopped", "stopped", "stopped"]
    assert robot.output.latency.figures.largest < VALID_SECONDS


def test_watchdog_stops_motion_and_nothing_is_sent_afterwards():
    robot = _moving()
    robot.now += WATCHDOG_SECONDS - 0.01
    robot.output.check_deadline()
    assert robot.output.sending.sending
    robot.now += 0.02
    robot.output.check_deadline()
    assert _stopped(robot) is StopReason.OVERRUN


def test_commands_are_timed_and_late_ones_counted():
    robot = _moving()
    before = robot.output.latency.figures
    assert (before.largest, before.misses) == (0.0, 0)
    robot.delays = [0.0, 0.0, DEADLINE + 0.01]
    robot.read(1.0)
    figures = robot.output.latency.figures
    assert figures.largest == pytest.approx(DEADLINE + 0.01)
    assert (figures.median, figures.misses) == (0.0, 1)
    assert "1 later than 50 ms" in latency_text(figures)


def test_velocities_that_are_not_finite_are_not_sent():
    sent = []
    sender = MotionSender(("a",), lambda packet: sent.append(json.loads(packet)), LIMITS)
    sender.start(0.0)
    del sent[:]
    sender.begin(0.0)
    assert not sender.show(RequestedMotion(0.0, np.array([np.nan]), 0.0), 0.0, measured=0.0)
    assert [packet["state"] for packet in sent] == ["stopped"] * 3


def test_waiting_state_reports_rejected_readings():
    robot = Robot()
    robot.start()
    for step in (STEP, STEP, 2 * OLDEST_SECONDS):
        robot.now += step - STEP
        robot.read(joints={"hinge": 9.0})
        assert robot.output.sending.waiting == "readings that are possible"
    robot.now += 2 * OLDEST_SECONDS
    robot.output.check()
    assert robot.output.sending.waiting == "a reading that fits the skin"
    robot.read()
    assert robot.output.sending.sending


def test_nothing_is_sent_after_a_stop_from_another_thread():
    sent = []
    sender = MotionSender(("a",), lambda packet: sent.append(json.loads(packet)["state"]), LIMITS)
    sender.start(0.0)
    del sent[:]
    sender.begin(0.0)
    moving = threading.Event()
    requested = RequestedMotion(0.0, np.zeros(1), 0.0)

    def command():
        while sender.show(requested, 0.0, measured=0.0):
            if len(sent) == 100:
                moving.set()

    thread = threading.Thread(target=command)
    thread.start()
    assert moving.wait(10.0)
    sender.stop(0.0)
    thread.join()
    assert sent[-3:] == ["stopped"] * 3
    assert "stopped" not in sent[:-3]


def test_watchdog_names_a_missing_joint_while_readings_arrive():
    robot = _moving()
    robot.now += WATCHDOG_SECONDS - 0.01
    robot.session.apply(Arrived(Reading(robot.now, np.zeros(60), Unit.PASCAL), robot.now))
    robot.output.check_deadline()
    assert robot.output.sending.sending
    robot.now += 0.02
    robot.output.check_deadline()
    assert robot.output.sending.stopped is StopReason.NOT_HEARD
    assert robot.output.sending.detail == "joint hinge: not heard for 0.18 s"


def test_parts_of_the_skin_with_equal_times_do_not_restart_the_controller():
    robot = _moving()
    velocity = robot.output.requested.velocity
    assert velocity[0] > 0
    sent = robot.session.frame.measured.sent
    robot.read(6.0, taxels=range(30), sent=sent, step=0.001)
    assert robot.output.requested.velocity == velocity
    robot.read(20.0, taxels=range(30, 60), sent=sent, step=0.001)
    assert robot.output.sending.stopped is StopReason.FORCE
