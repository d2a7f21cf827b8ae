"""Bodies that are too deep, fast, light, heavy, stiff or confined obey physics, or stop with a replayable named error.

If the user insists on an unsuitable integrator, a warning of the session is also accepted.
"""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import save_failure_report
from tactile_maps.recording.verify import verify
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tests.hard_cases.touch import EXACT, INTEGRATORS, JAM, MODELS, SPRING, dropped, jammed, teleported, whip
from tests.hard_cases.touch_checks import Run, check_numbers, check_repeats, play, spring_force

GRAVITY = 9.81
STEPS = (0.0005, 0.001, 0.002, 0.004, 0.008)
STIFFNESSES = (1e3, 1e4, 1e5, 1e6, 1e7)
SOLVED = tuple(name for name in EXACT if name != "foundation")
"""Models whose contact is the physics engine's own."""
_FAST = 40.0
_FALL = _FAST**2 / (2 * GRAVITY)


def warned(run: Run) -> bool:
    """Whether it was said that contacts may be unstable: of the scene, before it ran, or of its bodies."""
    said = any(finding.kind == "unstable-time-step" for finding in run.prepared.scene.decision.warnings)
    return said or any(note.kind is ContactNoteKind.UNSTABLE for frame in run.frames for note in frame.notes)


def stops_again(run: Run, path) -> None:
    """A stopped run has a name, a place and a time, and its report stops at the same tick with the same words."""
    assert run.failure is not None
    assert run.failure.tick == len(run.frames) + 1
    assert " s: " in run.failure.problem, "it says when"
    check_repeats(run, play(run.prepared, len(run.frames) * run.prepared.scene.tick + 1.0))
    outcome = verify(RecordingPlayer(save_failure_report(run.session, path)))
    assert outcome.identical
    assert outcome.stopped == run.failure.problem


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", STEPS)
def test_weight_is_carried_or_bouncing_is_reported(integrator, timestep, tmp_path):
    """0.1 kg let fall by 5 mm: in the end all steps feel m g, at whatever stiffness."""
    steady = []
    for stiffness in STIFFNESSES:
        run = play(dropped(0.1, above=0.005, stiffness=stiffness, integrator=integrator, timestep=timestep), 0.8)
        check_numbers(run)
        if run.failure:
            stops_again(run, tmp_path / f"{stiffness:g}.mcap")
        else:
            held = np.abs(run.forces[run.at(0.6) :] / (0.1 * GRAVITY) - 1).max() < 0.05
            assert held or warned(run)
            steady.append(held)
    if integrator == "discrete" or timestep < 0.001:
        assert all(steady[:3])
    assert any(steady)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("mass", "stiffness"), [(0.1, 1e3), (0.1, 1e5), (2.0, 1e4), (50.0, 1e6)])
def test_depth_of_a_weight_follows_from_the_stated_stiffness(mass, stiffness):
    run = play(dropped(mass, stiffness=stiffness, timestep=0.0005, integrator="discrete"), 1.6)
    sunk = run.prepared.objects[0].spec.at[2] - run.heights[-1, 0]
    assert sunk == pytest.approx(mass * GRAVITY / stiffness, rel=1e-3)


@pytest.mark.long
def test_weight_of_two_grams_with_a_coarse_integrator_gives_a_warning(tmp_path):
    """An explicit contact spring throws off such a light body; it is used only on request and with a warning."""
    run = play(dropped(0.002, above=0.001, integrator="euler", timestep=0.001), 0.8)
    check_numbers(run)
    assert warned(run)
    assert not warned(play(dropped(0.002, above=0.001, integrator="discrete", timestep=0.001), 0.1))


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", MODELS)
def test_foundation_rejects_bodies_that_it_would_throw_out(model, tmp_path):
    """The layer's own springs are explicit: 2 g on them need a shorter step, and that is said."""
    run = play(dropped(0.002, above=0.001, skin=model, integrator="discrete"), 0.8)
    check_numbers(run)
    assert (run.failure is not None) == (model == "foundation")
    if run.failure:
        assert "too stiff for the time step" in run.failure.problem
        stops_again(run, tmp_path / "report.mcap")


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit"])
def test_impulse_on_the_skin_is_the_change_of_momentum(integrator):
    """Read at every step, the sum of force and time is the weight's momentum: m g t, to rounding, bounce or not."""
    run = play(dropped(0.5, above=0.01, integrator=integrator, timestep=0.001, tick=0.001), 0.5)
    assert run.forces.max() > 2 * 0.5 * GRAVITY, "it struck"
    speed = run.speeds[-1, 0]
    assert 0.001 * run.forces.sum() == pytest.approx(0.5 * (GRAVITY * 0.5 + speed), rel=1e-6)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("mass", "stiffness"), [(0.02, 2e4), (0.1, 2e5), (0.1, 1e6)])
def test_impact_rebounds_like_a_critically_damped_contact(mass, stiffness):
    """The motion  x" = -w² x - 2 w x'  lets go at t = 2 / w with exp(-2) of its speed, whatever mass and stiffness."""
    run = play(dropped(mass, above=2.0, stiffness=stiffness, timestep=1e-5, tick=1e-3, integrator="euler"), 0.8)
    assert -run.speeds.min() == pytest.approx(np.sqrt(2 * GRAVITY * 2.0), rel=0.01), "it struck"
    assert run.speeds.max() / -run.speeds.min() == pytest.approx(np.exp(-2), rel=0.04)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", [0.0005, 0.001])
def test_impact_at_40_m_s_does_not_rebound_faster(integrator, timestep):
    run = play(dropped(1.0, above=_FALL, radius=0.05, stiffness=1e6, integrator=integrator, timestep=timestep), 4.2)
    check_numbers(run)
    assert run.failure is None
    assert -run.speeds.min() == pytest.approx(_FAST, rel=0.01)
    assert 0.05 * _FAST < run.speeds.max() < 0.5 * _FAST, "it came back, and slower"
    assert run.heights.min() > -0.05, "not through the link"


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", [0.002, 0.004, 0.008])
def test_body_moving_farther_than_its_thickness_in_one_step_stops_the_run(integrator, timestep, tmp_path):
    """0.08 m and more at once pass the middle of 0.14 m of body and link, and could come out on the far side."""
    overrides = {"integrator": integrator, "timestep": timestep}
    run = play(dropped(1.0, above=_FALL, radius=0.05, stiffness=1e6, **overrides), 4.2)
    check_numbers(run)
    assert run.heights.min() > 0, "not at the link yet"
    assert run.failure is not None
    assert "weight near bar" in run.failure.problem
    assert "too fast for the time step" in run.failure.problem
    stops_again(run, tmp_path / "report.mcap")


@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", SOLVED)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", [0.001, 0.004])
def test_body_that_starts_deep_gains_at_most_the_energy_stored_in_the_cover(integrator, timestep, model):
    """A start 15 mm too deep releases at most ½ K d², and the body finally rests with its weight."""
    run = play(dropped(0.5, above=-0.015, skin=model, integrator=integrator, timestep=timestep), 1.0)
    check_numbers(run)
    assert run.failure is None
    stored = 0.5 * 2e4 * 0.015**2
    assert 0.5 * 0.5 * run.speeds.max() ** 2 <= stored
    assert run.heights.max() - run.heights[0, 0] <= stored / (0.5 * GRAVITY) + 0.015
    assert run.forces[-10:] == pytest.approx(0.5 * GRAVITY, rel=0.02)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", EXACT)
def test_teleported_probe_is_held_by_the_cover_or_stops_the_run_by_name(model, tmp_path):
    """The target of the motors jumps 70 mm deeper: cover and motors act as springs in series, or the layer fails."""
    run = play(teleported(skin=model), 0.5)
    check_numbers(run)
    if run.failure:
        assert model == "foundation"
        stops_again(run, tmp_path / "report.mcap")
    else:
        series = 0.067 / (1 / SPRING + 1 / 2e4)
        assert run.forces[-1] == pytest.approx(series, rel=1e-3)
        assert run.forces[-1] == pytest.approx(spring_force(run.prepared, run.frames[-1]), rel=1e-3)
        assert np.abs(run.speeds).max() < 2.0


@pytest.mark.long
def test_pressing_through_the_cover_is_reported(tmp_path):
    """50 kg on a foam of 4 mm: a bed of springs that a body is deeper in than it is thick would lose it."""
    run = play(dropped(50.0, above=0.001, skin="foundation"), 1.0)
    check_numbers(run)
    assert run.failure is not None
    assert "weight on bar" in run.failure.problem
    assert "pressed through" in run.failure.problem
    stops_again(run, tmp_path / "report.mcap")


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", STEPS)
def test_teleported_probe_is_held_or_stops_the_run_or_gives_a_warning(integrator, timestep, tmp_path):
    for stiffness in (2e4, 1e6):
        run = play(teleported(stiffness=stiffness, integrator=integrator, timestep=timestep), 0.5)
        check_numbers(run)
        if run.failure:
            stops_again(run, tmp_path / f"{stiffness:g}.mcap")
        elif not warned(run):
            assert run.forces[-1] == pytest.approx(spring_force(run.prepared, run.frames[-1]), rel=1e-3)
            assert np.abs(run.speeds).max() < 3.0


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", STEPS)
def test_jammed_link_stays_and_carries_the_force_of_its_cover(integrator, timestep, tmp_path):
    """4 mm too tight on each side: K d from the side that feels; the walls' sum on the link is nothing."""
    for stiffness in (2e4, 1e6):
        run = play(jammed(stiffness=stiffness, integrator=integrator, timestep=timestep), 0.4)
        check_numbers(run)
        if run.failure:
            stops_again(run, tmp_path / f"{stiffness:g}.mcap")
        elif not warned(run):
            assert abs(run.frames[-1].posture[0]) < 1e-5
            assert run.forces[-1] == pytest.approx(stiffness * JAM, rel=2e-3)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("model", MODELS)
def test_force_on_a_jammed_link_is_measured(model):
    run = play(jammed(skin=model), 0.3)
    check_numbers(run)
    assert run.failure is None
    if model in SOLVED:
        assert run.forces[-1] == pytest.approx(2e4 * JAM, rel=1e-3)
        assert any(note.kind is ContactNoteKind.OUTSIDE_SKIN for note in run.frames[-1].notes), "one side has no skin"


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("timestep", STEPS)
def test_joints_without_armature_or_damping_are_stable_or_stop_the_run(integrator, timestep, tmp_path):
    """A tip of 2 g is tapped, and comes to rest again."""
    run = play(whip(integrator=integrator, timestep=timestep), 1.6)
    check_numbers(run)
    if run.failure:
        assert run.failure.problem.startswith("joint ")
        stops_again(run, tmp_path / "report.mcap")
    else:
        assert run.forces.max() > 0, "it was tapped"
        assert np.abs(run.frames[-1].velocity).max() < 0.05
        assert np.abs(run.frames[-1].posture).max() < 0.05
