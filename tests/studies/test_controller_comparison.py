"""Controllers compared on the same stimulus: traces, metrics, and what is kept of the stimulus."""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_SLIDE_SPEED, SpeedScale, joint_speeds
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.errors import UsageError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.inputs import BehavioursChanged, ControlChanged, EffectsChanged, MapEdited, ReadingChanged
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.stimuli.stimulus_kinds import Stroke
from tactile_maps.studies.controller_comparison import (
    MOST_SECONDS,
    TRACE_COLUMNS,
    Contender,
    ControllerTrace,
    TraceRecorder,
    compare_controllers,
    controller_metrics,
    trace_csv,
)
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tests.support.touch import prepared_bar


def test_missing_values_are_nan():
    rows = TraceRecorder(SpeedScale())
    numbers = dict.fromkeys(TRACE_COLUMNS, 1.0) | {"map_error": None}
    rows.add(touched=True, limits=(Limit(LimitKind.JOINT_LIMIT),), **numbers)
    trace = rows.trace("A", ControlSettings(controller="qp"), "")
    assert (len(trace), trace.name, trace.settings.controller, trace.ended) == (1, "A", "qp", "")
    assert np.isnan(trace.map_error[0])
    assert all(getattr(trace, name)[0] == 1.0 for name in TRACE_COLUMNS if name != "map_error")
    assert (list(trace.touched), trace.limits) == ([True], ((Limit(LimitKind.JOINT_LIMIT),),))
    for name in (*TRACE_COLUMNS, "touched"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(trace, name)[0] = 0


TICKS = 1000
OFF_SKIN = Limit(LimitKind.POINT_OFF_SKIN)
TIME = 0.005 * np.arange(1, TICKS + 1)


def trace(*, name="A", controller="qp", touched=True, limits=((),) * TICKS, **columns) -> ControllerTrace:
    nothing = dict.fromkeys(TRACE_COLUMNS, np.full(TICKS, np.nan))
    nothing |= {"time": TIME, "force": np.zeros(TICKS), "joint_speed": np.zeros(TICKS), "control_ms": np.ones(TICKS)}
    columns = {key: np.broadcast_to(value, TICKS) for key, value in (nothing | columns).items()}
    return ControllerTrace(
        name, ControlSettings(controller=controller), **columns, touched=np.broadcast_to(touched, TICKS), limits=limits
    )


def test_metrics_of_errors_force_time_and_limits():
    ramp = np.linspace(0, 0.01, TICKS)
    names = [(Limit(LimitKind.ENERGY_TANK, value=float(k)),) for k in range(300)] + [(OFF_SKIN,)] * 200
    found = controller_metrics(
        trace(
            map_error=ramp,
            body_error=2 * ramp,
            force=3.2 + 0.1 * np.sin(40 * TIME) + 9.0 * (TIME < 0.5),
            force_goal=np.where(TIME > 1.0, 3.0, np.nan),
            control_ms=np.where(np.arange(TICKS) < 940, 0.2, 5.0),
            joint_speed=np.sin(TIME),
            energy=0.5 - TIME,
            limits=(*names, *((),) * 500),
        )
    )
    assert found.map_rms_mm == pytest.approx(10 / np.sqrt(3), rel=1e-2)
    assert found.map_p95_mm == pytest.approx(9.5, rel=1e-2)
    assert (found.body_rms_mm, found.body_p95_mm) == pytest.approx((2 * found.map_rms_mm, 2 * found.map_p95_mm))
    assert found.force_rms_N == pytest.approx(np.hypot(0.2, 0.1 / np.sqrt(2)), rel=1e-2), "while there is a goal"
    assert found.force_std_N == pytest.approx(0.1 / np.sqrt(2), rel=1e-2)
    assert found.force_max_N == pytest.approx(12.2, rel=1e-2)
    assert (found.control_ms, found.control_p95_ms) == (0.2, 5.0)
    assert found.joint_speed_max == pytest.approx(1.0, rel=1e-3)
    assert found.energy_J == pytest.approx(0.495)
    assert (found.seconds, found.limited, found.limit) == (5.0, 0.5, LimitKind.ENERGY_TANK)


def test_adapted_gains_do_not_count_as_limited():
    adapted = Limit(LimitKind.FORCE_GAIN_HELD)
    found = controller_metrics(
        trace(limits=[(adapted, Limit(LimitKind.ENERGY_TANK)) if t < 1 else (adapted,) for t in TIME])
    )
    assert found.limited == pytest.approx(0.2, abs=0.01)
    assert found.limit is LimitKind.ENERGY_TANK


def test_lost_time_is_time_under_a_finger_without_contact_after_the_first():
    force = np.where((TIME > 1) & ((TIME < 2) | (TIME > 2.5)), 3.0, 0.0)
    assert controller_metrics(trace(force=force)).lost == pytest.approx(0.5 / 4.0, abs=0.005)
    assert controller_metrics(trace(force=force, touched=TIME < 2)).lost == pytest.approx(0, abs=0.006), "it was lifted"
    assert controller_metrics(trace(force=force, touched=False)).lost is None, "no finger"
    assert controller_metrics(trace()).lost is None, "never felt"


def test_metrics_without_limits_or_without_a_tick_are_none():
    free = controller_metrics(trace())
    assert (free.limit, free.limited) == (None, 0)
    found = controller_metrics(TraceRecorder(SpeedScale()).trace("A", ControlSettings(), "stopped"))
    assert {found.map_rms_mm, found.force_rms_N, found.force_max_N, found.control_ms, found.limited} == {None}
    assert found.seconds == 0


def test_table_has_a_row_per_tick_and_empty_cells_for_missing_values():
    limits = ((Limit(LimitKind.JOINT_LIMIT, ("elbow",)), Limit(LimitKind.JOINT_SPEED)),) * TICKS
    text = trace_csv([trace(force=1.5), trace(name="B", controller="hybrid", limits=limits)]).decode()
    rows = list(csv.DictReader(text.splitlines()))
    assert len(rows) == 2 * TICKS
    assert (rows[0]["name"], rows[0]["controller"], float(rows[0]["force_N"])) == ("A", "qp", 1.5)
    assert (rows[-1]["name"], rows[-1]["map_error_m"]) == ("B", "")
    assert rows[-1]["limits"] == "joint limit: elbow; joint speed"
    assert float(rows[7]["time_s"]) == TIME[7], "in full precision"


BAR = prepared_bar(stimuli=(Stroke(hold=0.1),))
AT = BAR.skin.taxel_point(30)
HYBRID = ControlSettings(controller="hybrid")
QP = ControlSettings(controller="qp")
EXACT = tuple(name for name in TRACE_COLUMNS if name != "control_ms")


def equal(one, other) -> bool:
    arrays = [np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in EXACT]
    return all(arrays) and one.limits == other.limits and np.array_equal(one.touched, other.touched)


def compare(*settings, prepared=BAR, seconds=0.5, **options):
    contenders = [Contender("AB CD"[k], each) for k, each in enumerate(settings)]
    return compare_controllers(prepared, contenders, seconds=seconds, **options)


def recorded(acts, *, prepared=BAR, settings=HYBRID, seconds=1.0, **options):
    """A session to which these acts were done before the given ticks, and its frames."""
    session = Session(prepared, scripted=False, settings=settings, **options)
    frames = []
    for tick in range(1, round(seconds / prepared.scene.tick) + 1):
        for act in acts.get(tick, ()):
            session.submit(act)
        frames.append(session.tick())
    return session, frames


@cache
def touched():
    """A poke, with the goal raised while it lasts."""
    acts = {3: [PokePressed(1, AT)], 100: [ControlChanged(replace(HYBRID, force_goal=5.0))], 180: [PokeReleased(1)]}
    return recorded(acts)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("inputs", [None, "recorded"])
def test_equal_controllers_give_equal_traces_bit_for_bit(inputs):
    acts = touched()[0].inputs if inputs else None
    one, other = compare(HYBRID, HYBRID, inputs=acts)
    assert one.force.max() > 0.5
    assert equal(one, other)
    (alone,) = compare(HYBRID, inputs=acts)
    assert equal(one, alone), "who else is compared makes no difference"
    different, _ = compare(replace(HYBRID, force_gain=0.03), HYBRID, inputs=acts)
    assert not np.array_equal(different.force, one.force)


@pytest.mark.long
def test_recorded_controller_repeats_the_recorded_frames():
    session, frames = touched()
    (trace,) = compare(HYBRID, inputs=session.inputs, seconds=1.0)
    assert np.array_equal(trace.time, [frame.time for frame in frames])
    assert np.array_equal(trace.force, [max((r.force for r in f.regions), default=0.0) for f in frames])
    assert np.array_equal(trace.joint_speed, [np.abs(frame.velocity).max() for frame in frames])
    assert trace.limits == tuple(frame.why_limited for frame in frames)
    assert np.array_equal(trace.touched, [bool(frame.pokes) for frame in frames])
    assert np.array_equal(trace.energy, [frame.task.energy for frame in frames])
    assert 100 < trace.touched.sum() < 200
    assert (trace.control_ms > 0).all()


LIFT = """<mujoco><worldbody><body><joint name="lift" type="slide" axis="0 0 1" range="-0.5 0.5" damping="1"/>
  <geom type="box" size="0.05 0.05 0.05"/>{more}</body></worldbody></mujoco>"""
HINGE = """<body name="arm" pos="0.1 0 0"><joint name="hinge" axis="0 1 0" range="-1 1" damping="1"/>
  <geom type="box" size="0.05 0.05 0.05"/></body>"""


@pytest.mark.parametrize(
    ("more", "unit", "limit"),
    [("", "m/s", MAX_SLIDE_SPEED), pytest.param(HINGE, "% of limit", 100.0, marks=pytest.mark.long)],
)
def test_speeds_of_slides_have_their_own_unit_and_limit(tmp_path, more, unit, limit):
    path = tmp_path / "lift.xml"
    path.write_text(LIFT.format(more=more))
    prepared = prepare_cached(replace(scene_for(str(path)), cover=CoverSpec(taxels=40)))
    session = Session(prepared, scripted=False)
    limits = joint_speeds(prepared.robot)
    top = int(np.argmax([prepared.skin.normal(prepared.skin.taxel_point(taxel))[2] for taxel in range(40)]))
    session.submit(PokePressed(1, prepared.skin.taxel_point(top)))
    shares = [np.abs(session.tick().velocity / limits).max() for _ in range(100)]
    (trace,) = compare(ControlSettings(), prepared=prepared, inputs=session.inputs)
    figures = controller_metrics(trace)
    assert (trace.speed_unit, trace.speed_limit, figures.speed_unit) == (unit, limit, unit)
    assert figures.joint_speed_max > 0
    assert trace.joint_speed == pytest.approx(limit * np.array(shares))
    column = {"m/s": "joint_speed_m_s", "% of limit": "joint_speed_percent_of_limit"}[unit]
    assert column in trace_csv([trace]).decode().splitlines()[0].split(",")


@pytest.mark.long
def test_change_of_the_goal_is_kept_and_of_the_controller_ignored():
    acts = {
        3: [PokePressed(1, AT)],
        50: [ControlChanged(replace(HYBRID, controller="impedance", force_gain=0.04))],
        100: [ControlChanged(replace(HYBRID, controller="impedance", force_goal=5.0))],
    }
    session, _ = recorded(acts)
    gains = replace(QP, force_gain=0.02, force_goal=1.0)
    (trace,) = compare(gains, inputs=session.inputs, seconds=0.9)
    assert (trace.settings.controller, trace.settings.force_gain) == ("qp", 0.02)
    assert trace.settings.force_goal == 5.0
    goals = trace.force_goal[np.isfinite(trace.force_goal)]
    assert set(goals) == {3.0, 5.0}, "that of the recording's start, then its step"
    assert (np.nanargmax(trace.force_goal) + 1) == 100, "at its tick"


@pytest.mark.long
def test_task_is_taken_from_the_recording_or_the_contender():
    acts = {3: [PokePressed(1, AT)], 60: [ControlChanged(replace(HYBRID, task="hold_point"))]}
    session, _ = recorded(acts)
    path = replace(QP, task="follow_path", path_speed=0.02)
    (recorded_task,) = compare(path, inputs=session.inputs)
    assert recorded_task.settings.task == "hold_point"
    assert np.isnan(recorded_task.map_error[:59]).all(), "first it only kept the force"
    assert np.isfinite(recorded_task.map_error[62:]).any()
    (own,) = compare(path, inputs=session.inputs, own_task=True)
    assert own.settings.task == "follow_path"
    assert np.isfinite(own.map_error[:59]).any()


@pytest.mark.long
def test_body_error_refers_to_the_nearest_contact():
    far = BAR.skin.taxel_point(55)
    acts = {3: [PokePressed(1, AT)], 60: [PokePressed(2, far)]}
    hold = replace(HYBRID, task="hold_point")
    session, frames = recorded(acts, settings=hold)
    assert len(frames[-1].regions) == 2, "two contacts at once"
    (trace,) = compare(hold, inputs=session.inputs, seconds=1.0)
    apart = np.linalg.norm(BAR.skin.position(AT) - BAR.skin.position(far))
    assert np.nanmax(trace.body_error) < 0.3 * apart


START = (0, ControlChanged(HYBRID))
PRESS = (2, PokePressed(1, AT))


def test_state_of_the_start_is_taken_from_the_recording():
    gravity = (0, EffectsChanged(Effects(gravity=True)))
    behaviour = (0, BehavioursChanged((Behaviour(on="touch", then={"controller": "impedance"}),)))
    (trace,) = compare(HYBRID, inputs=[START, gravity, behaviour, PRESS], seconds=0.4)
    (plain,) = compare(HYBRID, inputs=[START, PRESS], seconds=0.4)
    assert trace.touched[2:].all()
    assert trace.settings.controller == "hybrid", "no behaviour may change a contender's controller"
    assert not np.array_equal(trace.joint_speed, plain.joint_speed), "gravity was not simulated"
    deaf = (0, ReadingChanged(ReadingSettings(threshold=1e6)))
    (trace,) = compare(HYBRID, inputs=[START, deaf, PRESS])
    assert (trace.touched.any(), trace.force.any()) == (True, False)


def test_map_at_the_start_is_used():
    """A point drawn on the moved map is on the skin only there."""
    moved = move(MapDocument.of(BAR.map), [0], (3.0, 0.0)).map
    start = (0, ControlChanged(replace(HYBRID, task="hold_point", path=(tuple(map(float, moved.to_map(AT))),))))
    (trace,) = compare(HYBRID, inputs=[start, (0, MapEdited("Move", moved)), PRESS])
    assert trace.force.any()
    assert not any(OFF_SKIN in limits for limits in trace.limits)
    (elsewhere,) = compare(HYBRID, inputs=[start, PRESS])
    assert any(OFF_SKIN in limits for limits in elsewhere.limits)


def test_changes_by_a_behaviour_are_not_copied_from_the_recording():
    by_behaviour = (9, ControlChanged(replace(HYBRID, task="retreat"), by="released"))
    (trace,) = compare(QP, inputs=[START, PRESS, by_behaviour])
    assert trace.settings.task == HYBRID.task


def test_behaviour_changes_the_task_but_not_the_controller():
    retreat = Behaviour(on="touch", then={"task": "retreat", "controller": "impedance", "force_gain": 0.001})
    prepared = prepared_bar(behaviours=({"on": "touch", "then": dict(retreat.then)},))
    session, _ = recorded({3: [PokePressed(1, AT)]}, prepared=prepared)
    assert session.settings.controller == "impedance", "it was triggered"
    (trace,) = compare(QP, prepared=prepared, inputs=session.inputs)
    assert (trace.settings.controller, trace.settings.task, trace.settings.force_gain) == (
        "qp",
        "retreat",
        QP.force_gain,
    )


@pytest.mark.long
def test_divergence_ends_one_trace_with_its_reason_and_no_other():
    unsteady = prepared_bar(tick=0.2, overrides={"integrator": "euler", "timestep": 0.02})
    acts = [START, (10, PokePressed(1, AT, Finger(stiffness=10.0)))]
    stiff = ControlSettings(stiffness=40.0, damping_ratio=3.0)
    torn, whole = compare(stiff, ControlSettings(), prepared=unsteady, inputs=acts, seconds=60.0)
    assert 5 < len(torn) < 300
    assert "diverged" in torn.ended
    assert np.isfinite(torn.joint_speed).all()
    assert (len(whole), whole.ended) == (300, "")


def test_rejected_input_ends_the_trace():
    acts = [START, (40, EffectsChanged(Effects(timestep=0.0007)))]
    (trace,) = compare(HYBRID, inputs=acts)
    assert len(trace) == 39
    assert "whole number of time steps" in trace.ended


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), MOST_SECONDS + 1])
def test_invalid_times_are_rejected(seconds):
    with pytest.raises(UsageError, match="such a time"):
        compare(HYBRID, seconds=seconds)


def test_names_of_contenders_must_differ():
    with pytest.raises(UsageError, match="names"):
        compare_controllers(BAR, [])
    with pytest.raises(UsageError, match="names"):
        compare_controllers(BAR, [Contender("A", HYBRID), Contender("A", QP)])


@pytest.mark.parametrize("scripted", [True, False])
def test_fingers_are_simulated_only_if_the_script_has_some(monkeypatch, scripted):
    begun = []

    class Recorded(Session):
        def __init__(self, *arguments, **started):
            super().__init__(*arguments, **started)
            begun.append(self.effects)

    monkeypatch.setattr("tactile_maps.studies.controller_comparison.Session", Recorded)
    prepared = prepared_bar()
    scene = replace(prepared.scene, stimuli=(Stroke(hold=0.1),) if scripted else ())
    compare_controllers(replace(prepared, scene=scene), [Contender("A", ControlSettings())], seconds=0.02)
    assert [effects.fingers for effects in begun] == [scripted]
