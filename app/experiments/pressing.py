"""A run of a pressed robot at one time step: how it gives way, how the contact holds then, and what stepping costs."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.experiments.pressed_arm import PressedArm
from app.scene.effects import Effects, Integrator
from app.simulation.simulation import Simulation
from app.touch.layer import Layer

SETTLING, HOLDING = 0.8, 0.4
"""How long it gives way, and how long it is held then [s]."""
LOOK_MS = 8.0
"""From one look at the posture to the next, while it gives way [ms]; a multiple of every time step."""
STEADY = 0.05
"""Share of the force by which a steady contact may be off or waver."""
FINE = Effects(gravity="off", contact="probe", fingers=False, integrator="discrete", timestep=5e-5)
"""The truth: a short step by the one integrator that no stiffness upsets."""


@dataclass(frozen=True, eq=False)
class Run:
    """What a run showed.

    Attributes:
        postures: (k, joints) every 8 ms while it gives way [rad].
        forces: (n,) of the contact at every step after that [N].
        seconds: (k,) wall time of each 8 ms of stepping.
        stopped: Why it ended before its time; empty when it did not.
    """

    postures: FloatArray
    forces: FloatArray
    seconds: FloatArray
    stopped: str = ""

    @property
    def ms(self) -> float:
        """Wall milliseconds of a simulated second, the median over the looks."""
        return 1e6 * float(np.median(self.seconds)) / LOOK_MS

    @property
    def lost(self) -> float:
        """Share of the steps at which nothing touched."""
        return float((self.forces <= 0).mean())

    def posture_off(self, fine: Run) -> float:
        """Root mean square over time and joints [rad]; nan where there are no joints."""
        return float(np.sqrt(np.mean((self.postures - fine.postures) ** 2))) if self.postures.size else float("nan")

    def force_off(self, fine: Run) -> tuple[float, float]:
        """By how much the mean force is off, and how much the force wavers (standard deviation), of the true force."""
        wanted = float(fine.forces.mean())
        return abs(float(self.forces.mean()) - wanted) / wanted, float(self.forces.std()) / wanted

    def steady(self, fine: Run) -> bool:
        """Whether the contact holds as it should."""
        return not self.stopped and max(self.force_off(fine)) < STEADY and not self.lost


def press(arm: PressedArm, effects: Effects, layer: Layer) -> Run:
    """Let the probe press the robot for 1.2 s: first timed and looked at every 8 ms, then felt at every step.

    A contact that bounces does so from step to step; looked at now and then it may seem to be still.

    Args:
        arm: What is pressed.
        effects: With the time step and the integrator; a whole number of steps are 8 ms.
        layer: The cover.
    """
    simulation = Simulation(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=layer)
    postures: list[FloatArray] = []
    forces: list[float] = []
    seconds: list[float] = []
    stopped = ""
    try:
        for _ in range(round(1e3 * SETTLING / LOOK_MS)):
            start = time.perf_counter()
            simulation.step(round(1e-3 * LOOK_MS / effects.timestep), arm.command)
            seconds.append(time.perf_counter() - start)
            postures.append(simulation.posture)
        for _ in range(round(HOLDING / effects.timestep)):
            simulation.step(1, arm.command)
            forces.append(float(simulation.sense() @ arm.skin.areas))
    except SimulationError as error:
        stopped = str(error)
    return Run(np.array(postures), np.array(forces), np.array(seconds), stopped)


def at_step(integrator: Integrator, timestep_ms: float) -> Effects:
    """The effects of a run by one integrator at one time step."""
    return replace(FINE, integrator=integrator, timestep=1e-3 * timestep_ms)
