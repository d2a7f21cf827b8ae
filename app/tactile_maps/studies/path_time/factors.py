"""A factor of accuracy: one property of the skin or of its knowledge, its levels, and the conditions at each level."""

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
    """A factor of the study.

    Attributes:
        name: Name in cases and rows.
        axis: Meaning of a level, with its unit.
        levels: Levels other than the nominal one, rising where they are numbers.
        conditions: Returns the conditions at a level.
        few: Levels for robots other than our own arm, the first of which is also that of the quick run; empty if only
            the arm is measured.
        nominal: Level in nominal conditions; None if that has no number or name.
        jacobians: Jacobians with which each level, and the nominal one, is measured.
        drawn_zero: Position at which a level of 0 is drawn on the logarithmic axis.
        note: Explanation next to its figure.
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
        """Whether its levels are names, which are drawn as bars."""
        return isinstance(self.levels[0], str)

    def position(self, level: Level) -> float:
        """Return the position at which a numeric level is drawn."""
        value = float(level)
        return self.drawn_zero if self.drawn_zero is not None and value <= 0 else value


def varied(name: str, unit: float = 1.0) -> Callable[[Level], Conditions]:
    """Return the nominal conditions with one number at a level, in multiples of ``unit``."""
    return lambda level: _with(Conditions(), {name: unit * float(level)})


def chosen(name: str) -> Callable[[Level], Conditions]:
    """Return the nominal conditions with one name at a level."""
    return lambda level: _with(Conditions(), {name: str(level)})


def sensing(effect: Callable[[float], SensorEffects]) -> Callable[[Level], Conditions]:
    """Return the nominal conditions with a sensor that has an effect at a level."""
    return lambda level: replace(Conditions(), sensor=effect(float(level)))


def _with(conditions: Conditions, changes: Mapping[str, object]) -> Conditions:
    return replace(conditions, **changes)  # type: ignore[arg-type]
