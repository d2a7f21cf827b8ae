"""Which time steps hold which contacts, as it was measured; whoever is about to leave that range is told before.

The table is that of the study ``step-cost``: our own arm pressed by a probe, every integrator at every time step and
stiffness. Between its rows the next worse one counts.
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
    """One combination, measured.

    Attributes:
        integrator: MuJoCo's.
        timestep: [s].
        stiffness: Of the contact [N/m].
        verdict: ``steady``: the force holds within 5 % and contact is never lost. ``bounces``: it is finite, but no
            such force. ``diverges``: the run was stopped.
        force_percent: How far the mean force is from that of a fine step; None where it diverged.
        ms: Wall milliseconds of a simulated second, on the machine that made the table; likewise None.
    """

    integrator: Integrator
    timestep: float
    stiffness: float
    verdict: Verdict
    force_percent: float | None
    ms: float | None


@lru_cache(maxsize=1)
def stability_table() -> tuple[StabilityResult, ...]:
    """All that was measured; ``assets/stability.json`` is the table that ``study step-cost`` writes."""
    rows = json.loads(asset("stability.json").read_text(encoding="utf8"))["rows"]
    return tuple(
        StabilityResult(
            row["integrator"],
            1e-3 * row["timestep_ms"],
            row["stiffness"],
            row["verdict"],
            row["force_percent"],
            row["ms"],
        )
        for row in rows
    )


def stability_warning(effects: Effects, layer: ElasticLayer, *, objects: Sequence[ObjectSpec] = ()) -> Finding | None:
    """What is known to go wrong with these effects and this cover, and the nearest way out; None where nothing is.

    Args:
        effects: Integrator, time step, and whether bodies touch at all.
        layer: Its contact stiffness.
        objects: What touches it; light things need shorter steps.
    """
    if effects.contact == "off" or not effects.dynamics or effects.skin == "foundation":
        return None  # the foundation refuses by itself what it cannot hold
    stiffness = equivalent_stiffness(layer, objects)
    found = measured_stability(effects.integrator, effects.timestep, stiffness)
    if found is not None and found.verdict == "steady":
        return None
    fate = "has not been measured" if found is None else found.verdict
    where = f"{effects.integrator} at {1e3 * effects.timestep:g} ms, contacts of {layer.stiffness:.3g} N/m"
    return Finding("unstable-time-step", where, f"Contact {fate} there: {_way_out(effects, stiffness)}")


def equivalent_stiffness(layer: ElasticLayer, objects: Sequence[ObjectSpec]) -> float:
    """The stiffness [N/m] at which the table's probe is as unsteady as the lightest of ``objects`` on this cover.

    What counts is stiffness over mass times the step squared. Heavier things are as unsteady as the probe is: the arm
    that bears them is not heavier.
    """
    lightest = min((thing.moving_mass for thing in objects), default=PROBE_MASS)
    return layer.stiffness * max(PROBE_MASS / lightest, 1.0)


def measured_stability(integrator: Integrator, timestep: float, stiffness: float) -> StabilityResult | None:
    """The row that answers for a combination: the next longer step and the next stiffer contact; None beyond them."""
    worse = [
        row
        for row in stability_table()
        if row.integrator == integrator
        and row.timestep >= timestep * (1 - _ROUNDING)
        and row.stiffness >= stiffness * (1 - _ROUNDING)
    ]
    return min(worse, key=lambda row: (row.timestep, row.stiffness), default=None)


def _way_out(effects: Effects, stiffness: float) -> str:
    """The longest steady step of this integrator, and the integrators that are steady at this step."""
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
