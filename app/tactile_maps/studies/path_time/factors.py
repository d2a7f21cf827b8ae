"""A factor of accuracy: one thing that is known or made less well, its levels, and the conditions each one makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from tactile_maps.maps.model.jacobian import JacobianKind
from tactile_maps.studies.path_time.conditions import Conditions
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

Level: TypeAlias = float | str


@dataclass(frozen=True)
class Factor:
    """One factor.

    Attributes:
        name: As cases and rows have it.
        axis: What a level is, with its unit.
        levels: Those that are tried besides the nominal, rising where they are numbers.
        conditions: Of a level.
        nominal: The level in nominal conditions; None where that has no number or name of its own.
        few: Levels for robots other than our own arm, of which the first is the quick run's; empty where only the arm
            is asked.
        jacobians: With which of them each level is tried; the nominal likewise.
        drawn_zero: Where a level of 0 is drawn: a logarithm knows none.
        note: What has to be said beside its figure.
    """

    name: str
    axis: str
    levels: Sequence[Level]
    conditions: Callable[[Level], Conditions]
    few: Sequence[Level]
    nominal: Level | None = None
    jacobians: Sequence[JacobianKind] = ("smoothed",)
    drawn_zero: float | None = None
    note: str = ""

    @property
    def named(self) -> bool:
        """Whether its levels are names: they are drawn as bars."""
        return isinstance(self.levels[0], str)

    def position(self, level: Level) -> float:
        """Where a level that is a number is drawn."""
        value = float(level)
        return self.drawn_zero if self.drawn_zero is not None and value <= 0 else value


def varied(name: str, unit: float = 1.0) -> Callable[[Level], Conditions]:
    """The nominal conditions with one number at a level, which is in ``unit`` s."""
    return lambda level: _with(Conditions(), {name: unit * float(level)})


def chosen(name: str) -> Callable[[Level], Conditions]:
    """The nominal conditions with one name at a level."""
    return lambda level: _with(Conditions(), {name: str(level)})


def sensing(effect: Callable[[float], SensorEffects]) -> Callable[[Level], Conditions]:
    """The nominal conditions with a sensor that has this effect at a level."""
    return lambda level: replace(Conditions(), sensor=effect(float(level)))


def _with(conditions: Conditions, changes: Mapping[str, object]) -> Conditions:
    return replace(conditions, **changes)  # type: ignore[arg-type]
