"""The simulation stage: the user's own robot, errors that shrink with the step, and a word where contact bounces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.studies.stages import simulation as simulation_stage
from tactile_maps.studies.stages.simulation import INTEGRATORS, STAGE, STEPS_MS
from tactile_maps.studies.study.work_precision import Setting, Subject, diagram, run_trials
from tactile_maps.studies.testbeds.pressed_robot import effects_at_step, run_press
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.touch import prepared_bar


@pytest.fixture(scope="module")
def subject():
    prepared = prepared_bar(layer=ElasticLayer(stiffness=1e4))
    return Subject.of(prepared.map, prepared=prepared)


@pytest.fixture
def coarse_reference(monkeypatch):
    """A reference run of four times the usual step, for tests that do not depend on its accuracy."""
    usual = simulation_stage.REFERENCE_EFFECTS
    with monkeypatch.context() as patching:
        patching.setattr(simulation_stage, "REFERENCE_EFFECTS", replace(usual, timestep=4 * usual.timestep))
        simulation_stage._pressed_and_reference.cache_clear()
        yield
    simulation_stage._pressed_and_reference.cache_clear()


def trial(subject, integrator, timestep_ms):
    (found,) = STAGE.trials(subject, Setting("simulation", integrator, {"timestep_ms": timestep_ms}))
    return found


def test_every_integrator_at_every_step_is_tried(subject):
    requested = STAGE.settings(subject)
    assert {(s.method, s.values["timestep_ms"]) for s in requested} == {(i, t) for i in INTEGRATORS for t in STEPS_MS}
    assert STAGE.current(subject) is None
    assert STAGE.recipes is None
    assert STAGE.seconds(subject) > 0


@pytest.mark.long
def test_longer_step_is_cheaper_and_less_accurate(subject):
    found = [trial(subject, "discrete", step) for step in (0.5, 2.0, 8.0)]
    off = [each.errors["posture_mrad"] for each in found]
    assert off == sorted(off)
    assert off[0] < off[-1]
    took = [each.milliseconds for each in found]
    assert took == sorted(took, reverse=True)
    for each in found:
        assert each.note == ""
        assert max(each.errors["force_percent"], each.errors["ripple_percent"]) < 1.0


@pytest.mark.long
def test_bouncing_contacts_are_noted(subject):
    found = trial(subject, "implicitfast", 4.0)
    assert found.note == "the contact bounces"
    assert max(found.errors["force_percent"], found.errors["ripple_percent"]) > 5.0
    assert found.name.startswith("4")


@pytest.mark.long
def test_failed_trials_are_reported_without_stopping_the_others(subject):
    requested = [Setting("simulation", name, {"timestep_ms": 1.0}) for name in ("discrete", "leapfrog")]
    done, refused = run_trials(replace(STAGE, settings=lambda _: requested), subject, progress=lambda *_: None)
    assert done.usable
    assert not refused.usable
    assert "unknown integrator" in refused.note


def test_stage_without_a_robot_has_no_trials(subject):
    alone = replace(subject, prepared=None)
    assert list(STAGE.settings(alone)) == []
    assert STAGE.fingerprint(alone) == ""
    with pytest.raises(SimulationError, match="no robot to press"):
        trial(alone, "discrete", 1.0)


def test_measurement_depends_on_robot_and_cover(subject):
    assert STAGE.fingerprint(subject) == STAGE.fingerprint(replace(subject, patches=()))
    stiffer = replace(subject, prepared=prepared_bar(layer=ElasticLayer(stiffness=2e4)))
    still = replace(subject, prepared=prepared_bar(hinged=False, layer=ElasticLayer(stiffness=1e4)))
    assert len({STAGE.fingerprint(each) for each in (subject, stiffer, still)}) == 3


LIMITS = {"implicitfast": (0.93, 1.07), "implicit": (0.93, 1.07)}
"""Shares of it."""


@pytest.mark.usefixtures("coarse_reference")
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", LIMITS)
def test_contact_is_stable_exactly_up_to_the_predicted_limit(subject, integrator):
    """The prediction against the simulation itself, at steps just below and just beyond."""
    arm, fine = simulation_stage._pressed_and_reference(subject.prepared)
    layer = subject.prepared.scene.layer
    limit = trial(subject, integrator, 0.5).limit
    assert limit.key == "timestep_ms"
    below, beyond = (
        run_press(arm, effects_at_step(integrator, share * limit.value), layer) for share in LIMITS[integrator]
    )
    assert below.steady(fine)
    assert not beyond.steady(fine)


@pytest.mark.long
def test_implicit_solver_has_no_limit(subject):
    assert trial(subject, "discrete", 2.0).limit is None
    assert "discrete" not in {INTEGRATORS[line.number] for line in diagram(STAGE, _few(subject)).limits}


def _few(subject):
    return [trial(subject, name, step) for name in ("implicitfast", "discrete") for step in (0.5, 1.0)]


@pytest.mark.usefixtures("coarse_reference")
def test_limit_is_placed_on_the_curve_at_its_time_step(subject):
    trials = _few(subject)
    (line,) = diagram(STAGE, trials).limits
    (half, whole) = (one.milliseconds for one in trials if one.setting.method == "implicitfast")
    slope = np.log2(whole / half)
    assert line.milliseconds == pytest.approx(whole * trials[0].limit.value ** slope, rel=1e-9)
