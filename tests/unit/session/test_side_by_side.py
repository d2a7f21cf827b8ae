"""Laws beside each other: the same start, the same stimulus, their own gains."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.contacts.reading_settings import ReadingSettings
from app.control.behaviour import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.editing.arrange import move
from app.editing.document import MapDocument
from app.errors import SceneError, UsageError
from app.scene.effects import Effects
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged
from app.session.law_trace import NUMBERS
from app.session.session import Session
from app.session.side_by_side import MOST_SECONDS, Contender, side_by_side
from app.stimuli.stroke import Stroke
from app.touch.poke import Finger, PokePressed, PokeReleased
from tests.touch import prepared_bar

BAR = prepared_bar(stimuli=(Stroke(hold=0.1),))
AT = BAR.skin.taxel_point(30)
HYBRID, QP = ControlSettings(law="hybrid"), ControlSettings(law="qp")
EXACT = tuple(name for name in NUMBERS if name != "control_ms")


def equal(one, other) -> bool:
    arrays = [np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in EXACT]
    return all(arrays) and one.limits == other.limits and np.array_equal(one.touched, other.touched)


def compare(*settings, prepared=BAR, seconds=0.5, **options):
    contenders = [Contender("AB CD"[k], each) for k, each in enumerate(settings)]
    return side_by_side(prepared, contenders, seconds=seconds, **options)


def recorded(acts, *, prepared=BAR, settings=HYBRID, seconds=1.0, **options):
    """A session to which these acts were done before the given ticks, and its frames."""
    session, frames = Session(prepared, scripted=False, settings=settings, **options), []
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


@pytest.mark.parametrize("inputs", [None, "recorded"])
def test_equal_laws_give_equal_traces_bit_for_bit(inputs):
    acts = touched()[0].inputs if inputs else None
    one, other = compare(HYBRID, HYBRID, inputs=acts)
    assert one.force.max() > 0.5
    assert equal(one, other)
    (alone,) = compare(HYBRID, inputs=acts)
    assert equal(one, alone), "who else is compared makes no difference"
    different, _ = compare(replace(HYBRID, force_gain=0.03), HYBRID, inputs=acts)
    assert not np.array_equal(different.force, one.force)


def test_the_law_that_was_recorded_gives_the_frames_that_were_recorded():
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


def test_the_scene_s_own_script_plays_without_a_recording():
    (trace,) = compare(HYBRID)
    assert trace.touched.any()


def test_a_change_of_the_goal_is_kept_and_one_of_the_law_is_not():
    acts = {
        3: [PokePressed(1, AT)],
        50: [ControlChanged(replace(HYBRID, law="impedance", force_gain=0.04))],
        100: [ControlChanged(replace(HYBRID, law="impedance", force_goal=5.0))],
    }
    session, _ = recorded(acts)
    gains = replace(QP, force_gain=0.02, force_goal=1.0)
    (trace,) = compare(gains, inputs=session.inputs, seconds=0.9)
    assert (trace.settings.law, trace.settings.force_gain) == ("qp", 0.02)
    assert trace.settings.force_goal == 5.0
    goals = trace.force_goal[np.isfinite(trace.force_goal)]
    assert set(goals) == {3.0, 5.0}, "that of the recording's start, then its step"
    assert (np.nanargmax(trace.force_goal) + 1) == 100, "at its tick"


def test_the_task_comes_with_the_recording_or_is_the_contenders_own():
    acts = {3: [PokePressed(1, AT)], 60: [ControlChanged(replace(HYBRID, task="hold_point"))]}
    session, _ = recorded(acts)
    path = replace(QP, task="follow_path", path_speed=0.02)
    (theirs,) = compare(path, inputs=session.inputs)
    assert theirs.settings.task == "hold_point"
    assert np.isnan(theirs.map_error[:59]).all(), "first it only kept the force"
    assert np.isfinite(theirs.map_error[62:]).any()
    (own,) = compare(path, inputs=session.inputs, own_task=True)
    assert own.settings.task == "follow_path"
    assert np.isfinite(own.map_error[:59]).any()


def test_the_errors_on_map_and_body_are_of_one_contact():
    session, _ = recorded({3: [PokePressed(1, AT)]}, settings=replace(HYBRID, task="hold_point"))
    (trace,) = compare(replace(HYBRID, task="hold_point"), inputs=session.inputs)
    both = np.isfinite(trace.map_error)
    assert both.sum() > 50
    assert trace.body_error[both] == pytest.approx(trace.map_error[both], rel=0.1, abs=1e-4), "the bar is flat"


def test_the_body_error_is_that_of_the_nearest_contact():
    far = BAR.skin.taxel_point(55)
    acts = {3: [PokePressed(1, AT)], 60: [PokePressed(2, far)]}
    hold = replace(HYBRID, task="hold_point")
    session, frames = recorded(acts, settings=hold)
    assert len(frames[-1].regions) == 2, "two contacts at once"
    (trace,) = compare(hold, inputs=session.inputs, seconds=1.0)
    apart = np.linalg.norm(BAR.skin.position(AT) - BAR.skin.position(far))
    assert np.nanmax(trace.body_error) < 0.3 * apart


def test_effects_and_behaviours_of_the_start_are_taken():
    acts = [
        (0, ControlChanged(HYBRID)),
        (0, EffectsChanged(Effects(gravity=True))),
        (0, BehavioursChanged((Behaviour(on="touch", then={"law": "impedance"}),))),
        (2, PokePressed(1, AT)),
    ]
    (trace,) = compare(HYBRID, inputs=acts, seconds=0.4)
    (plain,) = compare(HYBRID, inputs=[acts[0], acts[-1]], seconds=0.4)
    assert trace.touched[2:].all()
    assert trace.settings.law == "hybrid", "no behaviour may change a contender's law"
    assert not np.array_equal(trace.joint_speed, plain.joint_speed), "gravity was not simulated"


def test_the_reading_of_the_start_is_taken():
    deaf = ReadingChanged(ReadingSettings(threshold=1e6))
    acts = [(0, ControlChanged(HYBRID)), (0, deaf), (2, PokePressed(1, AT))]
    (trace,) = compare(HYBRID, inputs=acts)
    assert trace.touched.any()
    assert not trace.force.any()


def test_the_map_of_the_start_is_taken():
    """A point drawn on the moved map is on the skin only there."""
    moved = move(MapDocument.of(BAR.map), [0], (3.0, 0.0)).map
    place = tuple(map(float, moved.to_map(AT)))
    hold = replace(HYBRID, task="hold_point", path=(place,))
    acts = [(0, ControlChanged(hold)), (0, MapEdited("Move", moved)), (2, PokePressed(1, AT))]
    (trace,) = compare(HYBRID, inputs=acts)
    assert trace.force.any()
    assert not any("not on the skin" in limit for limits in trace.limits for limit in limits)
    (elsewhere,) = compare(HYBRID, inputs=[acts[0], acts[2]])
    assert any("not on the skin" in limit for limits in elsewhere.limits for limit in limits)


def test_what_a_behaviour_did_in_the_recording_is_not_taken():
    acts = [
        (0, ControlChanged(HYBRID)),
        (2, PokePressed(1, AT)),
        (9, ControlChanged(replace(HYBRID, task="retreat"), by="touch")),
    ]
    (trace,) = compare(QP, inputs=acts)
    assert trace.settings.task == HYBRID.task


def test_a_behaviour_changes_the_task_and_not_the_law():
    retreat = Behaviour(on="touch", then={"task": "retreat", "law": "impedance", "force_gain": 0.001})
    prepared = prepared_bar(behaviours=({"on": "touch", "then": dict(retreat.then)},))
    session, _ = recorded({3: [PokePressed(1, AT)]}, prepared=prepared)
    assert session.settings.law == "impedance", "it was triggered"
    (trace,) = compare(QP, prepared=prepared, inputs=session.inputs)
    assert (trace.settings.law, trace.settings.task, trace.settings.force_gain) == ("qp", "retreat", QP.force_gain)


def test_one_that_diverges_ends_there_and_says_why_and_the_others_go_on():
    unsteady = prepared_bar(tick=0.01, wishes={"integrator": "euler", "timestep": 0.01, "gravity": "on"})
    acts = [(0, ControlChanged(HYBRID)), (1, PokePressed(1, AT, Finger(stiffness=10.0)))]
    stiff = ControlSettings(stiffness=40.0, damping_ratio=3.0)
    torn, whole = compare(stiff, ControlSettings(), prepared=unsteady, inputs=acts, seconds=3.0)
    assert 5 < len(torn) < 300
    assert "diverged" in torn.ended
    assert np.isfinite(torn.joint_speed).all()
    assert (len(whole), whole.ended) == (300, "")


def test_an_input_that_is_refused_ends_the_trace():
    acts = [(0, ControlChanged(HYBRID)), (40, EffectsChanged(Effects(timestep=0.0007)))]
    (trace,) = compare(HYBRID, inputs=acts)
    assert len(trace) == 39
    assert "whole number of time steps" in trace.ended


def test_progress_is_told_and_may_cancel():
    told = []
    compare(HYBRID, progress=lambda text, done: told.append((text, done)))
    assert told[0][1] == 0
    assert told[-1][1] == 1
    assert [done for _, done in told] == sorted(done for _, done in told)

    class CancelledError(Exception):
        pass

    def cancel(_text, done):
        if done > 0.3:
            raise CancelledError

    with pytest.raises(CancelledError):
        compare(HYBRID, progress=cancel)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), MOST_SECONDS + 1])
def test_a_time_that_is_none_is_refused(seconds):
    with pytest.raises(UsageError, match="such a time"):
        compare(HYBRID, seconds=seconds)


def test_names_are_needed_to_tell_them_apart():
    with pytest.raises(UsageError, match="names"):
        side_by_side(BAR, [])
    with pytest.raises(UsageError, match="names"):
        side_by_side(BAR, [Contender("A", HYBRID), Contender("A", QP)])


def test_a_gain_out_of_range_is_refused():
    with pytest.raises(SceneError, match="force_gain"):
        compare(replace(HYBRID, force_gain=9.0))


def test_a_trace_is_a_frozen_value_that_crosses_processes():
    (trace,) = compare(HYBRID)
    with pytest.raises(ValueError, match="read-only"):
        trace.force[0] = 1.0
    again = pickle.loads(pickle.dumps(trace))
    assert equal(trace, again)
    assert again.settings == trace.settings
