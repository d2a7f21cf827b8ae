"""What does accuracy cost in time stepping: which integrator holds which contact at which time step?"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import get_args

import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.experiments.experiment import Experiment
from app.experiments.plot import Figure, Panel
from app.experiments.pressed_arm import PRESS, pressed_arm
from app.experiments.sweep import Case, Row
from app.simulation.effects import Effects, Integrator
from app.simulation.simulation import Simulation
from app.touch.layer import Layer

STEPS_MS = (0.5, 1.0, 2.0, 4.0, 8.0)
STIFFNESSES = (1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7)
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
_FINE_MS, _SAMPLE_MS = 0.05, 8.0
_SETTLING, _HOLDING = 0.8, 0.4
_TAXELS = 300
_STEADY = 0.05


@dataclass(frozen=True, eq=False)
class Run:
    """What a run showed.

    Attributes:
        postures: (k, joints) every 8 ms while it settled [rad].
        forces: (n,) of the contact at every step after that [N].
        seconds: (k,) wall time of each 8 ms of stepping.
        stopped: Why it ended before its time; empty when it did not.
    """

    postures: FloatArray
    forces: FloatArray
    seconds: FloatArray
    stopped: str = ""


def cases(quick: bool, seed: int) -> list[Case]:
    """Every integrator at every time step against every stiffness."""
    steps, stiffnesses = ((1.0, 4.0), (1e4, 1e6)) if quick else (STEPS_MS, STIFFNESSES)
    return [
        {"integrator": integrator, "timestep_ms": step, "stiffness": stiffness, "seed": seed}
        for stiffness in stiffnesses
        for step in steps
        for integrator in INTEGRATORS
    ]


def measure(case: Case) -> list[Row]:
    """One row: verdict, errors against a fine step, and the wall time of a simulated second."""
    fine = _fine(case["stiffness"], case["seed"])
    run = press(case["integrator"], case["timestep_ms"], case["stiffness"], case["seed"])
    if run.stopped:
        nothing = dict.fromkeys(("force_percent", "waver_percent", "lost_percent", "posture_mrad", "ms"))
        return [{"verdict": "diverges", **nothing, "stopped": run.stopped}]
    wanted = float(fine.forces.mean())
    off, waver = abs(float(run.forces.mean()) - wanted) / wanted, float(run.forces.std()) / wanted
    lost = float((run.forces <= 0).mean())
    steady = off < _STEADY and waver < _STEADY and not lost
    return [
        {
            "verdict": "steady" if steady else "bounces",
            "force_percent": 1e2 * off,
            "waver_percent": 1e2 * waver,
            "lost_percent": 1e2 * lost,
            "posture_mrad": 1e3 * float(np.sqrt(np.mean((run.postures - fine.postures) ** 2))),
            "ms": 1e6 * float(np.median(run.seconds)) / _SAMPLE_MS,
            "stopped": "",
        }
    ]


def press(integrator: Integrator, timestep_ms: float, stiffness: float, seed: int) -> Run:
    """Let the probe press the arm for 1.2 s: first timed and looked at every 8 ms, then felt at every step.

    A contact that bounces does so from step to step; looked at now and then it may seem to be still.
    """
    arm = pressed_arm(_TAXELS, seed)
    effects = Effects(gravity="off", contact="probe", fingers=False, integrator=integrator, timestep=1e-3 * timestep_ms)
    simulation = Simulation(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=Layer(stiffness=stiffness))
    postures: list[FloatArray] = []
    forces: list[float] = []
    seconds: list[float] = []
    stopped = ""
    try:
        for _ in range(round(1e3 * _SETTLING / _SAMPLE_MS)):
            start = time.perf_counter()
            simulation.step(round(_SAMPLE_MS / timestep_ms), arm.command)
            seconds.append(time.perf_counter() - start)
            postures.append(simulation.posture)
        for _ in range(round(1e3 * _HOLDING / timestep_ms)):
            simulation.step(1, arm.command)
            forces.append(float(simulation.sense() @ arm.skin.areas))
    except SimulationError as error:
        stopped = str(error)
    return Run(np.array(postures), np.array(forces), np.array(seconds), stopped)


@lru_cache(maxsize=len(STIFFNESSES))
def _fine(stiffness: float, seed: int) -> Run:
    """The truth: a step of 0.05 ms with the one integrator that no stiffness upsets."""
    return press("discrete", _FINE_MS, stiffness, seed)


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Errors of posture and force against the wall time of a simulated second; along a curve the step shrinks."""
    asked = {
        "posture_mrad": ("Posture, root mean square while it gives way", "mrad", 1e-4),
        "waver_percent": ("Waver of the held force", "% of the force", 1e-4),
    }
    return [
        Figure(title, "milliseconds for a simulated second", unit, _panels(rows, key), least=least)
        for key, (title, unit, least) in asked.items()
    ]


def _panels(rows: Sequence[Row], key: str) -> list[Panel]:
    stiffnesses = dict.fromkeys(row["stiffness"] for row in rows)
    return [
        Panel(
            f"contact of {stiffness:g} N/m",
            {
                integrator: [
                    (_number(row["ms"]), _number(row[key]))
                    for row in rows
                    if (row["integrator"], row["stiffness"]) == (integrator, stiffness)
                ]
                for integrator in dict.fromkeys(str(row["integrator"]) for row in rows)
            },
        )
        for stiffness in stiffnesses
    ]


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan


EXPERIMENT = Experiment(
    "step-cost",
    "Which integrator holds a contact of which stiffness, at which time step, and what does that cost?",
    f"A probe of 0.1 kg presses the forearm of our own arm, held at home, with {PRESS:g} N for 1.2 s. Steady: over the "
    "last 0.4 s the force is within 5 % of that of a run at 0.05 ms, wavers by less than 5 % (standard deviation over "
    "all steps), and contact is never lost. Diverges: the run was stopped by name. Postures are compared over the "
    "first 0.8 s; times are medians over every 8 ms of these.",
    cases,
    measure,
    figures,
)
