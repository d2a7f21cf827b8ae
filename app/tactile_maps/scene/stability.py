"""Measured stability of contacts by time step and stiffness, and warnings outside the stable range.

The table is the result of the study ``step-cost``: the shipped arm pressed by a probe, with every integrator at every
time step and stiffness. Between two rows the worse one counts.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeAlias

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import Finding
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

Verdict: TypeAlias = Literal["steady", "bounces", "diverges"]
PROBE_MASS = 0.1
"""Mass of the probe that pressed the arm when the table was measured [kg]."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class StabilityResult:
    """Measurement of one combination.

    Attributes:
        integrator: Integrator of MuJoCo.
        timestep: Time step [s].
        stiffness: Contact stiffness [N/m].
        verdict: ``steady``: the force stays within 5 % and contact is never lost. ``bounces``: finite, but without such
            a force. ``diverges``: the run was stopped.
    """

    integrator: Integrator
    timestep: float
    stiffness: float
    verdict: Verdict


@lru_cache(maxsize=1)
def stability_table() -> tuple[StabilityResult, ...]:
    """Return all measurements; ``study step-cost`` writes them to ``assets/stability.json``."""
    rows = json.loads(asset("stability.json").read_text(encoding="utf8"))["rows"]
    return tuple(
        StabilityResult(row["integrator"], 1e-3 * row["timestep_ms"], row["stiffness"], row["verdict"]) for row in rows
    )


def stability_warning(effects: Effects, layer: ElasticLayer, *, objects: Sequence[ObjectSpec] = ()) -> Finding | None:
    """Return the known instability of these effects with this cover, and the nearest stable settings; None if steady.

    Args:
        effects: Effects with integrator and time step.
        layer: Cover with the contact stiffness.
        objects: Objects that touch it; light ones need shorter steps.
    """
    if effects.contact == "off" or not effects.dynamics or effects.skin == "foundation":
        return None  # the foundation model itself rejects unstable settings
    stiffness = equivalent_stiffness(layer, objects)
    found = measured_stability(effects.integrator, effects.timestep, stiffness)
    if found is not None and found.verdict == "steady":
        return None
    fate = "has not been measured" if found is None else found.verdict
    where = f"{effects.integrator} at {1e3 * effects.timestep:g} ms, contacts of {layer.stiffness:.3g} N/m"
    return Finding("unstable-time-step", where, f"Contact {fate} there: {_way_out(effects, stiffness)}")


def equivalent_stiffness(layer: ElasticLayer, objects: Sequence[ObjectSpec]) -> float:
    """Return the stiffness [N/m] at which the table's probe is as unsteady as the lightest object on this cover.

    Stability depends on stiffness over mass times the squared step. Heavier objects count as the probe, because the arm
    that carries them is not heavier.
    """
    lightest = min((spec.moving_mass for spec in objects), default=PROBE_MASS)
    return layer.stiffness * max(PROBE_MASS / lightest, 1.0)


def measured_stability(integrator: Integrator, timestep: float, stiffness: float) -> StabilityResult | None:
    """Return the row with the next longer step and the next stiffer contact; None outside the table."""
    worse = [
        row
        for row in stability_table()
        if row.integrator == integrator
        and row.timestep >= timestep * (1 - _ROUNDING)
        and row.stiffness >= stiffness * (1 - _ROUNDING)
    ]
    return min(worse, key=lambda row: (row.timestep, row.stiffness), default=None)


def _way_out(effects: Effects, stiffness: float) -> str:
    """Return the remedy: the longest steady step of this integrator, and the integrators steady at this step."""
    steps = sorted({row.timestep for row in stability_table() if row.timestep < effects.timestep})
    shorter = [step for step in steps if _steady(effects.integrator, step, stiffness)]
    integrators = {row.integrator: None for row in stability_table()}
    others = [name for name in integrators if _steady(name, effects.timestep, stiffness)]
    ways = [f"a time step of {1e3 * shorter[-1]:g} ms"] if shorter else []
    ways += [f"the integrator {' or '.join(others)}"] if others else []
    return f"choose {' or '.join(ways)}" if ways else "choose a softer cover"


def _steady(integrator: Integrator, timestep: float, stiffness: float) -> bool:
    row = measured_stability(integrator, timestep, stiffness)
    return row is not None and row.verdict == "steady"
