"""Linear model of an arm that presses on a spring, with the largest gain of a stable sampled force loop around it.

A stiff impedance, coupled by the arm's inertia, holds the joints at the desired posture. A controller moves the desired
posture by readings that are infrequent and late. All of this is a frequency response, so the limit is a gain margin,
and no eigenvalues have to be computed for each gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.force_loop.normal_motion import LEAST_TILT, bearable_tilt
from tactile_maps.control.force_loop.sampled_loop import sampled_loop_limit
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import JointImpedance
from tactile_maps.control.motion.task_priority import singular_directions
from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.robots.kinematics import Configuration

_ANGLES = np.pi * np.geomspace(2e-3, 1.0, 100)
"""Frequencies at which the loop is evaluated [rad a sample], with linear interpolation between them."""
_RANK = 1e-6
"""Singular values below this share of the largest count as zero."""
_ALIASES = np.arange(-10, 11)[:, None]
"""Sampling folds the plant's response. The terms left out are 2 % for ideal joints, and less for others."""


@dataclass(frozen=True)
class LoopFilter:
    """Force controller along the contact's normal without its force gain.

    Attributes:
        integral_time: Integral time [s]; inf without an integral.
        position_gain: Gain with which the point is drawn back along the normal [1/s].
        inertia_time: Time constant of the speed [s].
    """

    integral_time: float = math.inf
    position_gain: float = 0.0
    inertia_time: float = 0.0

    @classmethod
    def of(cls, settings: ControlSettings) -> LoopFilter:
        """Return the filter of the controller in ``settings``."""
        lags = settings.controller in ("admittance", "parallel")
        return cls(
            integral_time=math.inf if settings.controller == "admittance" else settings.integral_time,
            position_gain=settings.position_gain if settings.controller == "parallel" else 0.0,
            inertia_time=settings.inertia_time if lags else 0.0,
        )


@dataclass(frozen=True, eq=False)
class PressedArm(ArrayFields):
    """Response of the contact point along its normal to a desired displacement.

    Attributes:
        squares: (n,) squared frequencies of the modes of the arm under its impedance [rad²/s²].
        damping: (n,) damping of the modes [1/s].
        outward: (n,) displacement of the point per mode.
        pushed: (n,) excitation of each mode per desired displacement.
        stiffness: Contact stiffness [N/m].
        sticking_stiffness: Force per desired displacement while friction holds the contact point [N/m]; inf without
            friction.
    """

    squares: FloatArray
    damping: FloatArray
    outward: FloatArray
    pushed: FloatArray
    stiffness: float
    sticking_stiffness: float = math.inf

    def response(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return displacement per desired displacement at complex frequencies ``s`` [1/s], of any shape."""
        each = 1 / (s[..., None] * (s[..., None] + self.damping) + self.squares)
        free = each.dot(self.outward * self.pushed)
        gives = each.dot(self.outward**2)
        return np.asarray(free / (1 + self.stiffness * gives))

    @property
    def series_stiffness(self) -> float:
        """Stiffness of the contact and the joints in series [N/m]."""
        return self.stiffness * float(self.response(np.zeros(1, complex)).real[0])

    def sampled_limit(self, readings: SensorTiming) -> float:
        """Return the force gain [m/s/N] above which the force would oscillate with ideal joints.

        It is that of a sampled integral loop, k_f k T < 2 sin(pi / (2 (2 d + 1))), k of joints and contact in series;
        inf for a point that no joint moves.
        """
        series = self.series_stiffness
        limit = sampled_loop_limit(readings.delay / readings.period)
        return limit / (series * readings.period) if series > 0 else math.inf

    def gain_limit(self, controller: LoopFilter, readings: SensorTiming, tick: float) -> float:
        """Return the force gain [m/s/N] above which the force oscillates; inf if the loop is stable with any gain.

        The controller moves the desired posture once a ``tick`` [s] by the latest reading. Cost: 0.4 ms.
        """
        period = max(readings.period, tick)
        s = 1j * (_ANGLES + 2 * np.pi * _ALIASES) / period
        arrival = readings.delay
        mean = np.ones_like(s)
        if readings.averaged:
            arrival = max(arrival - period / 2, 0.0)
            mean = (1 - np.exp(-period * s)) / (period * s)
        late = round(arrival / tick) * tick - tick / 2  # a desired posture is held from the start of a tick
        way = self.response(s)
        taken = min(tick / max(controller.inertia_time, tick), 1.0)
        lag = taken / (1 - (1 - taken) * np.exp(-tick * s))
        desired = lag / (s + controller.position_gain * lag * way)  # per speed that the force error requests
        held = mean * np.exp(-late * s) * (1 - np.exp(-period * s)) / s
        loop = (held * (1 + 1 / controller.integral_time / s) * desired * self.stiffness * way).sum(axis=0) / period
        return _gain_margin(loop)


def _gain_margin(loop: NDArray[np.complex128]) -> float:
    """Return the smallest gain that brings an open loop (k,), up to the Nyquist frequency, through -1."""
    real = loop.real
    imaginary = loop.imag
    turns = np.flatnonzero(imaginary[:-1] * imaginary[1:] < 0)
    share = imaginary[turns] / (imaginary[turns] - imaginary[turns + 1])
    crossed = np.append(real[turns] + share * (real[turns + 1] - real[turns]), real[-1])
    most = -float(crossed.min())
    return 1 / most if most > 0 else math.inf


def pressed_arm(
    configuration: Configuration, impedance: JointImpedance, region: ContactRegion, stiffness: float, *, slides: bool
) -> PressedArm:
    """Return the model of the arm at its current posture for one contact.

    Args:
        configuration: The robot at its current posture.
        impedance: Impedance that holds the desired posture.
        region: Contact on which the arm presses.
        stiffness: Contact stiffness [N/m].
        slides: Whether the contact point may move sideways when it is moved outward, if that is not far.

    Cost: 0.1 ms.
    """
    normal = configuration.pose(region.link).rotation @ region.link_normal
    move = configuration.jacobian(region.link, region.link_position)
    outward = normal @ move
    freely = slides and bearable_tilt(outward, move) >= LEAST_TILT
    push = _least_motion(outward[None], np.ones(1)) if freely else _least_motion(move, normal)
    joint_stiffness = impedance.stiffness
    damping = impedance.damping
    root = np.linalg.inv(np.linalg.cholesky(configuration.mass_matrix()))
    squares, modes = np.linalg.eigh((root * joint_stiffness) @ root.T)
    shapes = root.T @ modes
    # The cover shears about as stiffly as it is pressed: the point moves by  J push - J K^-1 J^T f = f / stiffness.
    compliance = (move / joint_stiffness) @ move.T + np.eye(3) / stiffness
    return PressedArm(
        squares=squares,
        damping=np.einsum("ji,j,ji->i", shapes, damping, shapes),
        outward=outward @ shapes,
        pushed=(joint_stiffness * push) @ shapes,
        stiffness=stiffness,
        sticking_stiffness=float(normal @ np.linalg.solve(compliance, move @ push)),
    )


def _least_motion(rows: FloatArray, speed: FloatArray) -> FloatArray:
    """Return the least joint velocity (n,) for a speed (m,). Controllers do not damp speeds this small."""
    left, gains, right = singular_directions(rows)
    shares = np.divide(speed @ left, gains, out=np.zeros_like(gains), where=gains > _RANK * gains.max(initial=0.0))
    return np.asarray(shares @ right)
