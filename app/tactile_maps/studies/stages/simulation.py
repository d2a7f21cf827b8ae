"""Numerical integrator of the physics: which integrator, and how long a step, on the user's own robot and cover."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import get_args

from tactile_maps.core.errors import SimulationError
from tactile_maps.scene.effects import Integrator
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.simulation.model.contact_stiffness import stable_timesteps
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.studies.base.rows import scaled
from tactile_maps.studies.study.work_precision import ErrorKind, Setting, StabilityLimit, Stage, Subject, Trial
from tactile_maps.studies.testbeds.pressed_robot import (
    REFERENCE_EFFECTS,
    PressedRobot,
    PressRun,
    effects_at_step,
    press_robot,
    run_press,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

STEPS_MS = (0.5, 1.0, 2.0, 4.0, 8.0)
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
BOUNCES = "the contact bounces"
"""Note of a trial whose contact does not hold as it should."""
ERRORS = (
    ErrorKind("posture_mrad", "Posture", "mrad", "Error of the joint positions while a probe presses the robot, root "
              "mean square, against a time step of 0.05 ms.", 1e-4),
    ErrorKind("force_percent", "Held force", "%", "Error of the mean force once the press is held.", 1e-6),
    ErrorKind("ripple_percent", "Ripple of the force", "%", "Standard deviation of the held force over "
              "steps.", 1e-6),
    ErrorKind("lost_percent", "Contact lost", "% of the time", "Share of steps without contact once the press is "
              "held.", 1e-1),
)  # fmt: skip


def settings(subject: Subject) -> list[Setting]:
    """Every integrator at every time step; none where there is no robot."""
    if subject.prepared is None:
        return []
    return [Setting("simulation", name, {"timestep_ms": step}) for name in INTEGRATORS for step in STEPS_MS]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """The robot pressed at one time step, and the milliseconds of a simulated second."""
    if subject.prepared is None:
        raise SimulationError("there is no robot to press", remedy="Open a robot")
    (arm, fine), layer = _pressed_and_reference(subject.prepared), subject.prepared.scene.layer
    yield replace(step_trial(setting, arm, layer, fine), limit=_limit(arm, _integrator(setting.method), layer))


def step_trial(setting: Setting, arm: PressedRobot, layer: ElasticLayer, fine: PressRun) -> Trial:
    """A robot pressed with one integrator at one time step; the milliseconds are those of a simulated second.

    Args:
        setting: Integrator and time step.
        arm: What is pressed.
        layer: Its cover.
        fine: The run that counts as the truth.

    Raises:
        SimulationError: It does not hold until the end, or there is no such integrator.
    """
    step = float(setting.values["timestep_ms"])
    run = run_press(arm, effects_at_step(_integrator(setting.method), step), layer)
    if run.stopped:
        raise SimulationError(f"{step:g} ms: {run.stopped}")
    off, ripple = run.force_errors(fine)
    errors = {
        "posture_mrad": scaled(run.posture_error(fine), 1e3),
        "force_percent": 1e2 * off,
        "ripple_percent": 1e2 * ripple,
        "lost_percent": 1e2 * run.lost,
    }
    note = "" if run.steady(fine) else BOUNCES
    return Trial(setting, f"{step:g}\u202fms", run.ms, errors, note, p95_ms=run.p95_ms)


@lru_cache(maxsize=1)
def _pressed_and_reference(prepared: PreparedScene) -> tuple[PressedRobot, PressRun]:
    """The robot and the truth about it. Cost: 1 s for our own arm."""
    arm = press_robot(prepared.robot, prepared.skin)
    return arm, run_press(arm, REFERENCE_EFFECTS, prepared.scene.layer)


@lru_cache(maxsize=len(INTEGRATORS))
def _limit(arm: PressedRobot, integrator: Integrator, layer: ElasticLayer) -> StabilityLimit | None:
    """The longest time step that the contact with the probe bears; None where there is none. Cost: 0.1 to 1 s."""
    effects = replace(REFERENCE_EFFECTS, integrator=integrator)
    model = assemble(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=layer)
    pressed = {arm.skin.link(arm.at), arm.probe.spec.name}
    steps = [step for names, step in stable_timesteps(model, layer).items() if set(names) == pressed]
    return StabilityLimit("Stability limit", _SOURCE, "timestep_ms", 1e3 * min(steps)) if steps else None


_SOURCE = (
    "the longest time step that the contact bears, h < 0.83 / sqrt(k), with k the cover's stiffness by the mass of the "
    "pair as the solver sees it (predicted; servos are left out)"
)


def _integrator(name: str) -> Integrator:
    for known in INTEGRATORS:
        if known == name:
            return known
    raise SimulationError("there is no such integrator", value=name, remedy=f"Choose among: {', '.join(INTEGRATORS)}")


def fingerprint(subject: Subject) -> str:
    """The robot, its cover's stiffness, and where its skin is."""
    if subject.prepared is None:
        return ""
    digest = hashlib.blake2b(subject.prepared.robot.mjcf.encode(), digest_size=8)
    digest.update(repr(subject.prepared.scene.layer).encode())
    for patch in subject.prepared.skin.patches:
        digest.update(patch.surface.vertices.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """About how long all of it takes."""
    joints = 0 if subject.prepared is None else len(subject.prepared.robot.joints)
    return 5 + 0.5 * joints


STAGE = Stage(
    "simulation",
    "Simulation",
    "How accurate is each integrator and time step, and how long does it take?",
    INTEGRATORS,
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    "One press, in which nothing is random: there is no interval, and another press errs otherwise.",
)
