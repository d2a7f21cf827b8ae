"""A quadratic program: force and place as well as bounds on speed, acceleration, joints and forces let it.

min over joint velocities of w |outward speed - push|² + |sliding - wanted|² + e |speed - rest|², in a box, with weak
directions damped as least squares have it. A contact whose force would pass its cap within a tick, by a nominal
stiffness, is pushed less whatever the rest wants: not a box, so it comes as a heavy term, for those contacts only that
need it.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.levels import Level, damping, directions
from app.control.priority import Priority
from app.control.reference import MAX_JOINT_SPEED, MAX_SPEED
from app.control.rule import ArmState
from app.control.task_contact import TaskContact

MAX_ACCELERATION = 30.0
"""Of any joint [rad/s²]."""
DAMPER = 0.2
"""Distance from a joint's limit at which its speed towards it is bounded [rad]."""
CAP_SHARE = 0.8
"""Share of the greatest force, at which the arm stops, that contacts may reach."""
_FORCE_WEIGHT, _CAP_WEIGHT, _REST_WEIGHT = 100.0, 1e4, 1e-3
_STIFFNESS = 2e4
"""Of a contact [N/m], nominal: the stiffer, the sooner the cap acts."""
_ROUNDS = 3


class QuadraticProgram(Priority):
    """The errors of ``Priority``, in one program with bounds."""

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """MuJoCo's box-constrained solver, again with the caps that the first answer would break."""
        lower, upper = self._box(arm)
        hessian, gradient = _quadratic(levels, arm.home)
        cap, held = CAP_SHARE * settings.max_force, set[int]()
        for _ in range(_ROUNDS):
            speed = _solve_box(hessian, gradient, lower, upper, arm.speed)
            over = [c for c in arm.touched if c.id not in held and _next_force(c, speed, arm.dt) > cap]
            if not over:
                break
            for contact in over:
                held.add(contact.id)
                row, most = contact.outward, max((cap - contact.force) / (_STIFFNESS * arm.dt), -MAX_SPEED)
                hessian = hessian + _CAP_WEIGHT * np.outer(row, row)
                gradient = gradient - _CAP_WEIGHT * most * row
        _tell(speed, lower, upper, arm, limits)
        limits += ["force cap"] if held else []
        return speed

    def _box(self, arm: ArmState) -> tuple[FloatArray, FloatArray]:
        """Bounds (n,) of the speed: greatest speed, greatest change, and slower towards a limit that is near."""
        change, full = MAX_ACCELERATION * arm.dt, MAX_JOINT_SPEED
        near = full / DAMPER
        upper = np.minimum(np.minimum(full, arm.speed + change), near * np.maximum(arm.reference.upper - arm.start, 0))
        lower = np.maximum(np.maximum(-full, arm.speed - change), near * np.minimum(arm.reference.lower - arm.start, 0))
        return np.minimum(lower, upper), np.maximum(lower, upper)


def _quadratic(levels: Sequence[Level], rest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Hessian (n, n) and gradient (n,), with the damping of weak directions; see ``levels``."""
    hessian, gradient = np.diag(np.full(len(rest), _REST_WEIGHT)), -_REST_WEIGHT * rest
    for weight, level in zip((_FORCE_WEIGHT, 1.0), levels, strict=False):
        _, gains, right = directions(level.rows)
        damped = np.array([gain**2 + damping(gain) for gain in gains.tolist()])
        hessian += weight * (right.T * damped).dot(right)
        gradient -= weight * level.speed.dot(level.rows)
    return hessian, gradient


def _solve_box(
    hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray, warm: FloatArray
) -> FloatArray:
    """(n,) the minimum in the box; without joints it is empty."""
    n = len(warm)
    answer = np.minimum(np.maximum(warm, lower), upper)
    if n:
        factor = np.zeros((n, n + 7))
        rank = mujoco.mju_boxQP(answer, factor, None, np.ascontiguousarray(hessian), gradient, lower, upper)
        answer = answer if rank >= 0 else np.zeros(n)
    return answer


def _next_force(contact: TaskContact, speed: FloatArray, dt: float) -> float:
    return contact.force + _STIFFNESS * dt * float(contact.outward @ speed)


def _tell(speed: FloatArray, lower: FloatArray, upper: FloatArray, arm: ArmState, limits: list[str]) -> None:
    at = (speed <= lower + 1e-9) | (speed >= upper - 1e-9)
    if not at.any():
        return
    if (np.abs(speed[at]) >= MAX_JOINT_SPEED - 1e-6).any():
        limits.append("joint speed")
    slow = at & (np.abs(speed) < MAX_JOINT_SPEED - 1e-6)
    changing = np.abs(np.abs(speed - arm.speed) - MAX_ACCELERATION * arm.dt) < 1e-6
    limits += ["joint acceleration"] if (slow & changing).any() else []
    limits += ["joint limit"] if (slow & ~changing).any() else []
