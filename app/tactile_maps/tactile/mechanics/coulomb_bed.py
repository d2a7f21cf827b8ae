"""Shear under a body on a bed of springs with Coulomb friction (Cattaneo 1938, Mindlin 1949).

Each point of the bed has a tangential spring in series with a slider, which slides when the force exceeds friction
times the normal force of that point (Johnson, Contact Mechanics, 7.2, with springs instead of a half-space; the brush
model of tyres). The springs remember: the result depends on what happened before.

The total force and the torque about the normal are known, from the physics. ``shear_bed`` finds the one rigid motion of
the body along the bed, two translations and a rotation, after which the forces of all points sum to these totals. It
minimizes a convex function, so Newton's method with a line search finds it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.tactile.mechanics.plane_vectors import ComplexArray

STUCK = 0.95
"""Share of its friction limit below which a point counts as stuck."""
_TOLERANCE = 1e-14
"""Error of the totals at which the iteration ends, as a share of the friction limit of the whole bed."""
_ACCURATE = 1e-12
"""Error of the totals up to which they count as reached."""
_AT_LIMIT = 1e-7
"""Distance from the limit of the whole bed, as a share of it, from which on all points slide.

Closer to the limit the motion is without bound: it grows with the inverse square root of the distance."""
_POINT = 1e-9
"""Size of a bed below which all of its points are at one place [m]."""
_MAX_ITERATIONS = 60
_HALVINGS = 60
_RIDGE = 1e-12
_YIELD = 1e-3
"""Stiffness by which a torque beyond the limit gives way, as a share of the bed's: the torque is then within about this
share of the largest one for the force."""


class Shear(NamedTuple):
    """Tangential forces of a bed.

    Attributes:
        forces: (n,) force on each point [N], as a complex number: its parts along both axes of the bed.
        matched: Whether the forces sum to the totals. Otherwise these exceed what friction can transfer. The torque is
            then nearly the largest one for the force, which is still exact; a force that alone exceeds the limit is
            reduced to it.
        stuck: Share of the friction limit, 0 to 1, on points below ``STUCK`` of theirs.
    """

    forces: ComplexArray
    matched: bool
    stuck: float


def shear_bed(
    before: ComplexArray,
    limits: FloatArray,
    stiffness: FloatArray,
    offsets: ComplexArray,
    force: complex,
    torque: float = 0.0,
) -> Shear:
    """Find the tangential forces of a bed after a rigid motion that leads to known totals.

    f_i = clip(before_i + k_i (d + phi n x r_i)),  sum f_i = force,  sum r_i x f_i = torque,
    where clip shortens a vector to the limit of its point. Vectors in the plane of the bed are complex numbers.

    Args:
        before: (n,) forces before the motion [N]; zero for points that have just been touched.
        limits: (n,) largest force of each point, friction times normal force [N], >= 0.
        stiffness: (n,) tangential stiffness of each point [N/m], > 0.
        offsets: (n,) places of the points along the bed from the centre of the normal forces [m].
        force: Total force along the bed [N].
        torque: Total torque about the normal at the centre of the normal forces [N m]; a bed smaller than a nanometre
            bears none.

    Cost: 15 µs, and 30 µs for each round; 1 to 4 rounds for 200 points that stick or slide partly.
    """
    most = float(limits.sum())
    pull = abs(force)
    if most <= 0.0:
        return Shear(np.zeros_like(before), pull == 0.0 and torque == 0.0, 1.0)
    squares = offsets.real**2 + offsets.imag**2
    size = math.sqrt(float(limits @ squares) / most)
    if size < _POINT:
        size = math.inf  # offsets are rounding errors
        torque = 0.0
    turn = torque / size
    if pull >= (1 - _AT_LIMIT) * most and abs(turn) <= _AT_LIMIT * most:
        # Slightly above the limit means that the friction of the physics is inexact.
        matched = pull <= (1 + _AT_LIMIT) * most
        forces = limits * np.complex128(force / (most if matched else pull))
        return Shear(forces, matched, 0.0)
    # Points whose limit has fallen slide back to it first; else Newton starts where nothing resists.
    before = before * (limits / np.maximum(np.abs(before), limits + 1e-300))
    bed = _Bed(before, limits, stiffness, offsets / size, squares / size**2)
    found = bed.slide(force, turn, most)
    if found.matched:
        return found
    return bed.slide(force, turn, most, gives=_YIELD * float(stiffness.sum()))._replace(matched=False)


class _Bed(NamedTuple):
    """A bed with offsets in multiples of its size, so that torques are forces."""

    before: ComplexArray
    limits: FloatArray
    stiffness: FloatArray
    offsets: ComplexArray
    squares: FloatArray

    def slide(self, force: complex, torque: float, most: float, *, gives: float = 0.0) -> Shear:
        """Return the forces for these totals [N] by Newton's method.

        With ``gives`` > 0 [N/m] the torque is less by that times the turn, so that a solution exists for any torque.
        """
        motion = 0j
        turn = 0.0
        state = self._clip(motion, turn)
        pull = force - state.force
        twist = torque - state.torque
        rounds = 0
        while (error := max(abs(pull), abs(twist))) > _TOLERANCE * most and rounds < _MAX_ITERATIONS:
            rounds += 1
            step, spin = self._step(state, pull, twist, gives)
            # The slope of the convex function along the step may change its sign, but not by more than half.
            enough = -0.5 * _along(pull, twist, step, spin)
            share = 1.0
            for _ in range(_HALVINGS):
                following = self._clip(motion + share * step, turn + share * spin)
                left = force - following.force
                rest = torque - following.torque - gives * (turn + share * spin)
                if _along(left, rest, step, spin) >= enough:
                    break
                share *= 0.5
            if error <= _ACCURATE * most and max(abs(left), abs(rest)) >= error:
                break  # rounding
            motion += share * step
            turn += share * spin
            state, pull, twist = following, left, rest
        matched = error <= _ACCURATE * most
        below = np.abs(state.own) < STUCK * self.limits
        return Shear(state.own, matched, float(self.limits[below].sum()) / most)

    def _clip(self, motion: complex, turn: float) -> _Clipped:
        """Return the forces after a motion [m]; ``turn`` is an angle times the size of the bed."""
        free = self.before + self.stiffness * (motion + (1j * turn) * self.offsets)
        lengths = np.abs(free)
        shares = self.limits / np.maximum(lengths, self.limits + 1e-300)
        own = shares * free
        return _Clipped(free, lengths, shares, own, complex(own.sum()), float(np.vdot(self.offsets, own).imag))

    def _step(self, state: _Clipped, pull: complex, twist: float, gives: float) -> tuple[complex, float]:
        """Return the Newton step for what is missing; a sliding point resists only a change of direction."""
        rigid = self.stiffness * state.shares
        lost = np.divide(rigid, state.lengths**2, out=np.zeros_like(rigid), where=state.shares < 1.0)
        moment = (self.offsets.conj() * state.free).imag
        weighted = lost * state.free
        whole = float(rigid.sum())
        slid = complex(weighted @ state.free)  # sums of x² - y² and of 2 x y
        both = float(np.vdot(weighted, state.free).real)
        lever = complex(rigid @ self.offsets)
        turned = complex(weighted @ moment)
        ridge = _RIDGE * whole
        a = whole - 0.5 * (both + slid.real) + ridge
        b = -0.5 * slid.imag
        c = whole - 0.5 * (both - slid.real) + ridge
        d = -lever.imag - turned.real
        e = lever.real - turned.imag
        f = float(rigid @ self.squares) - float((lost * moment) @ moment) + ridge + gives
        x, y, z = np.linalg.solve(
            np.array([[a, b, d], [b, c, e], [d, e, f]]), np.array([pull.real, pull.imag, twist])
        ).tolist()
        return complex(x, y), z


class _Clipped(NamedTuple):
    """Forces (n,) before clipping, their lengths, the shares that are left, forces after clipping, and the totals."""

    free: ComplexArray
    lengths: FloatArray
    shares: FloatArray
    own: ComplexArray
    force: complex
    torque: float


def _along(pull: complex, twist: float, step: complex, spin: float) -> float:
    """Return the scalar product of what is missing and a step."""
    return pull.real * step.real + pull.imag * step.imag + twist * spin
