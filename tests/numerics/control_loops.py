"""Sampled loops around laws: a spring to press on, a place to slide to, readings that come late."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from app.control.command import ControlSettings
from app.control.hybrid import Hybrid
from app.control.laws import build_law
from app.control.map_sight import MapSight
from app.control.reference import PostureReference
from app.control.rule import ArmState
from app.control.task_contact import TaskContact
from app.control.task_keeper import TaskKeeper
from tests.touch import bar, prepared_bar
from tests.unit.control.touched import touch

AT = 0.3
"""Where the bar is touched, from its hinge [m]."""


def limit(delay: int) -> float:
    """Greatest stable gain of a sampled integral loop with ``delay`` samples (theory page, 5.5)."""
    return 2 * np.sin(np.pi / (2 * (2 * delay + 1)))


def onset(is_stable: Callable[[float], bool], low: float, high: float, *, steps: int = 9) -> float:
    """The value between ``low``, stable, and ``high``, not, where it stops being so; in equal ratios."""
    assert is_stable(low)
    assert not is_stable(high)
    for _ in range(steps):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return float(np.sqrt(low * high))


def grows(values: np.ndarray) -> bool:
    """Whether errors are larger in the last quarter than the first of all, where bounds may hold them by then."""
    return bool(np.abs(values[-len(values) // 4 :]).max() > np.abs(values[0]).max())


def pressed_bar(settings: ControlSettings, stiffness: float, *, delay=0, dt=0.005, count=400, off=0.02) -> np.ndarray:
    """Force errors [N] of a law on a bar whose joint does at once what is asked, against a spring.

    Args:
        settings: Of the law.
        stiffness: Of the spring [N/m].
        delay: Samples by which readings come late.
        dt: Of a sample [s].
        count: How many.
        off: The force at first, above the goal [N].
    """
    prepared = prepared_bar()
    law = build_law(settings.law, prepared.robot, TaskKeeper(), MapSight(prepared.map))
    free = (settings.force_goal + off) / stiffness  # the spring's end lies so deep when the bar is level
    posture, still, errors = np.zeros(1), np.zeros(1), []
    seen = deque([settings.force_goal + off] * (delay + 1), maxlen=delay + 1)
    for _ in range(count):
        force = max(stiffness * (free - AT * posture[0]), 1e-9)
        seen.append(force)
        posture = law.command(settings, posture, still, touch(seen[0], x=AT), dt).posture.copy()
        errors.append(force - settings.force_goal)
    return np.array(errors)


def slid_contact(
    gain: float, *, delay=0, dt=0.1, count=300, speed=0.0, feed=0.0, believed=None, start=0.004
) -> np.ndarray:
    """(count, 2) errors on the map [m] of a contact that a point free in space slides over a flat map.

    Args:
        gain: Speed per error [1/s].
        delay: Samples by which the error comes late.
        dt: Of a sample [s].
        count: How many.
        speed: Of the goal, along x [m/s].
        feed: Share of it that the law is told.
        believed: (2, 2) what the law takes for the map's Jacobian; the truth is one.
        start: The error at first, along x [m].
    """
    settings, rule = ControlSettings(law="hybrid", position_gain=gain), Hybrid()
    flat = np.eye(2) if believed is None else np.asarray(believed)
    to_map, up, zero = np.column_stack([flat, np.zeros(2)]), np.array([0.0, 0.0, 1.0]), np.zeros(3)
    arm = ArmState(zero, zero, zero, PostureReference(bar(), np.ones(1)), (), dt)
    error, rows = np.array([start, 0.0]), []
    seen = deque([error] * (delay + 1), maxlen=delay + 1)
    for _ in range(count):
        seen.append(error)
        goal = np.array([speed, 0.0])
        contact = TaskContact(1, 3.0, 0.0, up, zero, np.eye(3), to_map, seen[0], feed * goal)
        [level] = rule.levels(settings, (contact,), arm, [])
        skin = np.linalg.solve(level.rows, level.speed)
        error = error + dt * (goal + skin[:2])  # the contact slides by minus the skin's motion
        rows.append(error)
    return np.array(rows)
