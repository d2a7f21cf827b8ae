"""Does a scene simulate only what it needs? Every effect of many scenes is switched, and the outputs are compared.

An output is a signal over the run. Its change is the root mean square of the difference to the scene as decided, as a
share of the size of the signal: for a posture its range of motion, for others their root mean square. The size is at
least ``_LEAST``, so that a change of a negligible signal counts as negligible.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.scene.effect_decision import EffectRow
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene import Scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.studies.base.figures import BarChart
from tactile_maps.studies.base.rows import Case, Row, number, number_or
from tactile_maps.studies.study.study import CaseReplay, Study
from tactile_maps.studies.testbeds.decision_scenes import decision_scenes

TOLERANCE = 0.02
"""Change of a requested output above which an effect matters."""
_SECONDS = 8.0
_QUICK_SECONDS = 1.5
_QUICK = ("poke", "view")
_INSTEAD = {"integrator": ("implicit", "implicitfast"), "skin": ("off", "water-fill")}
"""Alternative values of effects with more choices than on and off; the second one where the first is current."""


class Verdict(StrEnum):
    """Conclusion about the decision for an effect."""

    NEEDED = "on, and needed"
    SPARE = "on, and changes nothing here"
    RIGHTLY_OFF = "off, and changes nothing"
    MISSING = "off, and changes a wanted output"
    NO_OUTPUT = "off, and no wanted output shows it"
    FINE_ENOUGH = "fine enough"
    TOO_COARSE = "too coarse"


def _force(frame: Frame) -> FloatArray:
    return np.array([sum(region.force for region in frame.regions)])


def _centre(frame: Frame) -> FloatArray:
    strongest: Sequence[ContactRegion] = frame.regions[:1]
    return strongest[0].link_position if strongest else np.zeros(3)


Signal = Callable[[Frame], FloatArray]
_SIGNALS: Mapping[str, Signal] = MappingProxyType(
    {
        "posture": lambda frame: frame.posture,
        "pressure": lambda frame: frame.pressures,
        "readings": lambda frame: frame.pressures,
        "pressure_shape": lambda frame: frame.pressures,
        "shear": lambda frame: np.zeros((len(frame.pressures), 2)) if frame.shear is None else frame.shear,
        "force": _force,
        "centre_of_pressure": _centre,
        "joint_torque": lambda frame: frame.command.torque_at(frame.posture, frame.velocity),
    }
)
"""Numbers of each tick, by output."""
_LEAST: Mapping[str, float] = MappingProxyType(
    {
        "posture": 0.01,
        "pressure": 20.0,
        "readings": 20.0,
        "pressure_shape": 20.0,
        "shear": 20.0,
        "force": 0.1,
        "centre_of_pressure": 0.01,
        "joint_torque": 0.05,
    }
)
"""Minimum size of a signal [rad, Pa, N, m, N m]."""


def cases(quick: bool, seed: int) -> list[Case]:
    """Return one case for each scene."""
    names = _QUICK if quick else tuple(decision_scenes())
    seconds = _QUICK_SECONDS if quick else _SECONDS
    return [{"scene": name, "seconds": seconds, "seed": seed} for name in names]


def measure(case: Case) -> list[Row]:
    """Return one row for each effect: its decision, the change when it is switched, and the verdict."""
    scene = replace(decision_scenes()[case["scene"]], seed=case["seed"])
    prepared = prepare_cached(scene)
    decided = outputs_of(prepared, scene, case["seconds"])
    return [_row(prepared, decided, row, case["seconds"]) for row in scene.unattended.rows]


def outputs_of(prepared: PreparedScene, scene: Scene, seconds: float) -> Mapping[str, FloatArray]:
    """Return the requested outputs of an unattended run, each (ticks, numbers).

    Raises:
        TactileMapsError: It cannot be simulated with these effects.
    """
    session = _unattended(prepared, scene)
    frames = [session.tick() for _ in range(round(seconds / scene.tick))]
    if session.failure is not None:
        raise session.failure.error
    return {output: np.array([_SIGNALS[output](frame) for frame in frames]) for output in scene.effective_outputs}


def _unattended(prepared: PreparedScene, scene: Scene) -> Session:
    return Session(replace(prepared, scene=scene), effects=scene.unattended.effects)


def replay(row: Row) -> CaseReplay:
    """Return the run of the scene of a row with its effect switched.

    Raises:
        UsageError: The row does not belong to a scene and effect of this study.
        TactileMapsError: It cannot be simulated with these effects; the note of the row says why.
    """
    try:
        scene = replace(decision_scenes()[str(row["scene"])], seed=int(number_or(row["seed"], 0)))
        (effect,) = (one for one in scene.unattended.rows if one.name == row["effect"])
        seconds = float(number_or(row["seconds"], _SECONDS))
    except (KeyError, ValueError) as error:
        raise UsageError("the row does not belong to a case of this study", value=error) from error
    return CaseReplay(_unattended(prepare_cached(scene), _switched(scene, effect)), round(seconds / scene.tick), {})


def change_of(output: str, decided: FloatArray, switched: FloatArray) -> float:
    """Return the change of an output (ticks, numbers) as a share of its size.

    A centre is compared while both runs have a contact, because without one it is the origin of a link. The change is
    at least the share of ticks in which only one of them has a contact.
    """
    apart = 0.0
    if output == "centre_of_pressure":
        both = decided.any(axis=1) & switched.any(axis=1)
        one = decided.any(axis=1) ^ switched.any(axis=1)
        apart = float(one.mean())
        decided = decided[both]
        switched = switched[both]
    own = decided - decided[0] if output == "posture" else decided
    size = max(_rms(own), _LEAST[output])
    return max(apart, _rms(switched - decided) / size)


def _rms(values: FloatArray) -> float:
    """RMS over time of the largest number at each instant, so that one taxel or joint is not averaged away."""
    return float(np.sqrt(np.mean(np.abs(values).max(axis=1) ** 2))) if values.size else 0.0


def switched_to(row: EffectRow) -> str | float:
    """Return the value to which an effect is switched."""
    entry = EFFECTS[row.name]
    if row.name in _INSTEAD:
        first, second = _INSTEAD[row.name]
        return second if row.value == first else first
    if not entry.words:
        return float(row.value.split()[0]) / 2
    return "off" if row.on else entry.when_on


def _switched(scene: Scene, row: EffectRow) -> Scene:
    return replace(scene, overrides={**scene.overrides, row.name: switched_to(row)})


def _row(prepared: PreparedScene, decided: Mapping[str, FloatArray], row: EffectRow, seconds: float) -> Row:
    scene = prepared.scene
    other = switched_to(row)
    facts: dict[str, str | float | bool | None] = {
        "effect": row.name,
        "decided": row.value,
        "switched": str(other),
        "on": row.on,
        "stated": row.overridden,
    }
    if EFFECTS[row.name].of_sensor and not row.on and "readings" not in scene.effective_outputs:
        return facts | {"change": None, "output": None, "verdict": Verdict.NO_OUTPUT.value, "cpu_s": None}
    began = time.process_time()
    try:
        switched = outputs_of(prepared, _switched(scene, row), seconds)
    except TactileMapsError as error:
        unknown = {"change": None, "output": None, "cpu_s": None}
        return facts | unknown | {"verdict": Verdict.NEEDED.value, "note": str(error)}
    spent = time.process_time() - began
    changes = {output: change_of(output, decided[output], switched[output]) for output in scene.effective_outputs}
    worst = max(changes, key=lambda output: changes[output])
    return facts | {
        "change": changes[worst],
        "output": worst,
        "verdict": verdict_of(row, changes[worst]).value,
        "cpu_s": spent,
    }


def verdict_of(row: EffectRow, change: float) -> Verdict:
    """Return the conclusion from the largest change of an output when this effect is switched."""
    if row.name in ("timestep", "integrator"):
        return Verdict.TOO_COARSE if change > TOLERANCE else Verdict.FINE_ENOUGH
    if row.on:
        return Verdict.NEEDED if change > TOLERANCE else Verdict.SPARE
    return Verdict.MISSING if change > TOLERANCE else Verdict.RIGHTLY_OFF


def figures(rows: Sequence[Row]) -> list[BarChart]:
    """Return for each verdict how often each effect got it."""
    charts = []
    for verdict in Verdict:
        found = [str(row["effect"]).replace("_", " ") for row in rows if row.get("verdict") == verdict.value]
        if found:
            counts: dict[str, float | None] = {name: number(found.count(name)) for name in dict.fromkeys(found)}
            charts.append(BarChart(f"{verdict.value[0].upper()}{verdict.value[1:]}", "scenes", counts))
    return charts


STUDY = Study(
    "needs",
    "Does each scene simulate everything that it needs, and nothing else?",
    "Each shipped scene, and variations with other outputs or objects, runs as decided for an unattended session, and "
    "once more for each effect switched: off instead of on, on instead of off, half the time step, another integrator. "
    "The change is the root mean square over the run of the largest difference of the output, as a share of the size "
    "of the output; above 2 % the effect matters there.",
    cases,
    measure,
    figures,
    replay=replay,
)
