"""What does accuracy cost in time stepping: which integrator is stable for which contact and time step?"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from tactile_maps.core.errors import SimulationError
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.stages.simulation import BOUNCES, ERRORS, INTEGRATORS, STEPS_MS, step_trial
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.study.work_precision import Setting, trial_row, work_precision_figures
from tactile_maps.studies.testbeds.pressed_robot import (
    PRESS_FORCE,
    REFERENCE_EFFECTS,
    PressRun,
    pressed_arm,
    run_press,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

STIFFNESSES = (1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6, 3e6, 1e7)
_TAXELS = 300


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every integrator at every time step and stiffness."""
    steps, stiffnesses = ((1.0, 4.0), (1e4, 1e6)) if quick else (STEPS_MS, STIFFNESSES)
    return [
        {"integrator": integrator, "timestep_ms": step, "stiffness": stiffness, "seed": seed}
        for stiffness in stiffnesses
        for step in steps
        for integrator in INTEGRATORS
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: verdict, errors against a fine step, and the wall time of a simulated second."""
    setting = Setting("simulation", case["integrator"], {"timestep_ms": case["timestep_ms"]})
    arm = pressed_arm(_TAXELS, case["seed"])
    layer = ElasticLayer(stiffness=case["stiffness"])
    fine = _reference_run(case["stiffness"], case["seed"])
    try:
        trial = step_trial(setting, arm, layer, fine)
    except SimulationError as error:
        nothing = dict.fromkeys(("ms", *(kind.key for kind in ERRORS)))
        return [{"verdict": "diverges", **nothing, "note": str(error)}]
    return [{"verdict": "bounces" if trial.note == BOUNCES else "steady", **trial_row(trial)}]


@lru_cache(maxsize=len(STIFFNESSES))
def _reference_run(stiffness: float, seed: int) -> PressRun:
    return run_press(pressed_arm(_TAXELS, seed), REFERENCE_EFFECTS, ElasticLayer(stiffness=stiffness))


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return errors of posture and force against the wall time of a simulated second; the step falls along a curve."""
    return work_precision_figures(
        rows,
        (kind for kind in ERRORS if kind.key in ("posture_mrad", "ripple_percent")),
        panel=lambda row: f"contact of {row['stiffness']:g} N/m",
        method=lambda row: str(row["integrator"]),
        x_name="milliseconds for a simulated second",
    )


STUDY = Study(
    "step-cost",
    "Up to which contact stiffness and time step is each integrator stable, and what does it cost?",
    f"A probe of 0.1 kg presses the forearm of our own arm, at home, with {PRESS_FORCE:g} N for 1.2 s. Steady: over"
    " the last 0.4 s the force is within 5 % of a run at 0.05 ms, varies by less than 5 % (standard deviation over"
    " all steps), and contact is never lost. Diverges: the run stopped with an error. Postures are compared over the "
    "first 0.8 s; times are medians over every 8 ms of these.",
    cases,
    measure,
    figures,
)
