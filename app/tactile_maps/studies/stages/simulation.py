"""Integrator and time step of the physics, with the user's own robot and cover."""

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
"""Note of a trial whose contact is unsteady."""
ERRORS = (
    ErrorKind(
        "posture_mrad",
        "Posture",
        "mrad",
        "Error of the joint positions while a probe presses the robot, root "
        "mean square, against a time step of 0.05 ms.",
        1e-4,
    ),
    ErrorKind("force_percent", "Held force", "%", "Error of the mean force once the press is held.", 1e-6),
    ErrorKind("ripple_percent", "Ripple of the force", "%", "Standard deviation of the held force over steps.", 1e-6),
    ErrorKind(
        "lost_percent", "Contact lost", "% of the time", "Share of steps without contact once the press is held.", 1e-1
    ),
)


def settings(subject: Subject) -> list[Setting]:
    """Return every integrator at every time step; none without a robot."""
    if subject.prepared is None:
        return []
    return [Setting("simulation", name, {"timestep_ms": step}) for name in INTEGRATORS for step in STEPS_MS]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield the pressed robot at one time step, with the time for a simulated second [ms]."""
    if subject.prepared is None:
        raise SimulationError("no robot to press", remedy="Open a robot")
    (arm, fine), layer = _pressed_and_reference(subject.prepared), subject.prepared.scene.layer
    yield replace(step_trial(setting, arm, layer, fine), limit=_limit(arm, _integrator(setting.method), layer))


def step_trial(setting: Setting, arm: PressedRobot, layer: ElasticLayer, fine: PressRun) -> Trial:
    """Press a robot with one integrator at one time step; the time is that of a simulated second.

    Args:
        setting: Integrator and time step.
        arm: The robot.
        layer: Its cover.
        fine: Reference run.

    Raises:
        SimulationError: The run stops early, or the integrator is unknown.
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
    """The robot and its reference run. Cost: 1 s for our own arm."""
    arm = press_robot(prepared.robot, prepared.skin)
    return arm, run_press(arm, REFERENCE_EFFECTS, prepared.scene.layer)


@lru_cache(maxsize=len(INTEGRATORS))
def _limit(arm: PressedRobot, integrator: Integrator, layer: ElasticLayer) -> StabilityLimit | None:
    """Longest stable time step for the contact with the probe; None without a known limit. Cost: 0.1 to 1 s."""
    effects = replace(REFERENCE_EFFECTS, integrator=integrator)
    model = assemble(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=layer)
    pressed = {arm.skin.link(arm.at), arm.probe.spec.name}
    steps = [step for names, step in stable_timesteps(model, layer).items() if set(names) == pressed]
    return StabilityLimit("Stability limit", _SOURCE, "timestep_ms", 1e3 * min(steps)) if steps else None


_SOURCE = (
    "longest stable time step of the contact, h < 0.83 / sqrt(k), with k the stiffness of the cover by the mass of the "
    "pair as the solver sees it (predicted; servos are left out)"
)


def _integrator(name: str) -> Integrator:
    for known in INTEGRATORS:
        if known == name:
            return known
    raise SimulationError("unknown integrator", value=name, remedy=f"Choose among: {', '.join(INTEGRATORS)}")


def fingerprint(subject: Subject) -> str:
    """Return a digest of the robot, the stiffness of its cover, and the place of its skin."""
    if subject.prepared is None:
        return ""
    digest = hashlib.blake2b(subject.prepared.robot.mjcf.encode(), digest_size=8)
    digest.update(repr(subject.prepared.scene.layer).encode())
    for patch in subject.prepared.skin.patches:
        digest.update(patch.surface.vertices.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """Return the approximate duration of all trials [s]."""
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
    "One deterministic press: there is no interval, and errors of other presses differ.",
)
