"""What became of one law: its trace over time, and the few figures that say how well it did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import BoolArray, FloatArray, readonly
from app.control.command import ControlSettings

NUMBERS = ("time", "force", "force_goal", "map_error", "body_error", "joint_speed", "energy", "control_ms")
"""Traces that are numbers, in the order of a file's columns."""


@dataclass(frozen=True, eq=False)
class LawTrace:
    """One run, tick by tick; NaN where there was no such thing.

    Attributes:
        name: Of the contender.
        settings: At the end: law and gains, and the task as it was last.
        time: (n,) [s].
        force: (n,) of the strongest contact [N], 0 without one.
        force_goal: (n,) wanted [N].
        map_error: (n,) from the contact to where it is wanted, on the map [m].
        body_error: (n,) the same straight across, on the body [m]; of the nearest contact, as it was read.
        joint_speed: (n,) of the fastest joint [rad/s].
        energy: (n,) net energy given to contacts [J].
        control_ms: (n,) wall time of the law [ms]; no part of what is equal between equal laws.
        touched: (n,) whether a finger was there to touch.
        limits: (n) what bounded the law, in words.
        ended: Why it stopped before the time was over; empty where it did not.
    """

    name: str
    settings: ControlSettings
    time: FloatArray
    force: FloatArray
    force_goal: FloatArray
    map_error: FloatArray
    body_error: FloatArray
    joint_speed: FloatArray
    energy: FloatArray
    control_ms: FloatArray
    touched: BoolArray
    limits: tuple[tuple[str, ...], ...]
    ended: str = ""

    def __post_init__(self) -> None:
        for name in NUMBERS:
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "touched", readonly(self.touched, np.bool_))

    def __len__(self) -> int:
        return len(self.time)


class TraceRows:
    """Collects a trace. Mutable: ``add`` a tick, then ``trace``."""

    def __init__(self) -> None:
        self._rows: list[tuple[float | None, ...]] = []
        self._touched: list[bool] = []
        self._limits: list[tuple[str, ...]] = []

    def add(self, *, touched: bool, limits: tuple[str, ...], **numbers: float | None) -> None:
        """Keep a tick: each of ``NUMBERS``, None where there is no such thing."""
        self._rows.append(tuple(numbers[name] for name in NUMBERS))
        self._touched.append(touched)
        self._limits.append(limits)

    def trace(self, name: str, settings: ControlSettings, ended: str) -> LawTrace:
        """All that was kept, as a value."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, len(NUMBERS))
        columns = dict(zip(NUMBERS, table.T.copy(), strict=True))
        touched = np.array(self._touched, dtype=np.bool_)
        return LawTrace(name, settings, **columns, touched=touched, limits=tuple(self._limits), ended=ended)
