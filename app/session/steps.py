"""How often the physics step in a control tick."""

from __future__ import annotations

from app.errors import SimulationError


def whole_steps(tick: float, timestep: float) -> int:
    """Physics steps in one control tick.

    Raises:
        SimulationError: The tick is not a whole number of them.
    """
    steps = round(tick / timestep) if 1e-5 <= timestep <= tick else 0  # NaN compares false
    if not steps or abs(tick / timestep - steps) > 1e-6:
        raise SimulationError(
            "a tick must be a whole number of time steps",
            place="effects.timestep",
            value=f"{timestep} s",
            remedy=f"Choose a part of {tick} s, of at least 0.00001 s",
        )
    return steps
