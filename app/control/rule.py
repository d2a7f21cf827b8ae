"""The one question on which the laws with a task differ: how errors become joint velocities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.levels import Level, solve_levels
from app.control.reference import PostureReference, at_limit, slowed
from app.control.task_contact import TaskContact


@dataclass(frozen=True, eq=False)
class ArmState:
    """The arm a rule moves.

    Attributes:
        start: (n,) the wanted posture until now.
        home: (n,) joint velocity that would take it back to rest.
        speed: (n,) joint velocity wanted at the tick before.
        reference: Its limits.
        touched: All contacts, wanted or not.
        dt: To the next tick [s].
    """

    start: FloatArray
    home: FloatArray
    speed: FloatArray
    reference: PostureReference
    touched: tuple[TaskContact, ...]
    dt: float


class Rule(Protocol):
    """How a law with a task answers. Mutable; ``reset`` forgets the past."""

    def reset(self) -> None:
        """Forget everything."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """What is wanted of the contacts now, the most wanted first; asked once a tick."""

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """(n,) joint velocity for the levels."""


def solve_freely(
    levels: Sequence[Level],
    reference: PostureReference,
    start: FloatArray,
    limits: list[str],
    *,
    rest: FloatArray | None = None,
) -> FloatArray:
    """(n,) joint velocity by damped least squares; joints at a limit leave the work to the others.

    Args:
        levels: The most wanted first.
        reference: The arm's limits.
        start: (n,) the wanted posture until now.
        limits: Told what bounds the answer.
        rest: (n,) joint velocity where the levels leave it free; none by default.
    """
    rest = np.zeros_like(start) if rest is None else rest
    moving = np.ones(len(start), dtype=bool)
    for _ in range(len(start)):
        speed, weak = solve_levels(levels, rest)
        stuck = at_limit(reference, start, speed) & moving
        if not stuck.any():
            break
        moving &= ~stuck
        levels, rest = [Level(level.rows * moving, level.speed) for level in levels], rest * moving
        limits += [] if "joint limit" in limits else ["joint limit"]
    else:
        return np.zeros_like(start)
    limits += ["the arm can hardly move along this contact"] if weak else []
    return slowed(speed, limits)


def in_space(contact: TaskContact, velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows (k, n) and speeds (k,) that give a contact's point a ``velocity`` (3,); its normal part if it may slide."""
    if contact.error is None:
        return contact.outward[None], np.array([contact.normal @ velocity])
    return contact.move, velocity


def one_level(parts: Sequence[tuple[FloatArray, FloatArray]]) -> list[Level]:
    """All rows wanted alike."""
    return [Level(np.concatenate([rows for rows, _ in parts]), np.concatenate([speed for _, speed in parts]))]
