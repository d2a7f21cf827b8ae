"""Theory of sampled loops: limits and times in closed form, and with posture loop and contact.

The closed forms are those of an ideal velocity servo on a spring. ``LinearLoop`` adds the linear effects of the
simulation: a posture loop of finite stiffness and the mass that it moves.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop
from tactile_maps.studies.loop_laws.gantry import MASS
from tactile_maps.studies.testbeds.force_loop import Filter

SETTLING_BAND = 0.02
"""Share of a step that may be left."""
MOST_SAMPLES = 1500
"""Number of samples after which a loop counts as never settling."""


def settling_samples_of(gains: NDArray[np.complex128] | FloatArray, delay: int) -> IntArray:
    """Return the samples (k,) until at most 2 % of a step of the contact are left; more than ``MOST_SAMPLES`` if never.

    For ideal loops; the controller sees the step ``delay`` samples later. (A step of the goal is known without delay
    and settles earlier by as much.)

    Args:
        gains: (k,), complex for corrections with a directional error.
        delay: Delay in samples.
    """
    errors = np.zeros((MOST_SAMPLES + delay + 1, len(gains)), dtype=complex)
    errors[delay] = 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(delay, len(errors) - 1):
            errors[k + 1] = errors[k] - gains * errors[k - delay]
        beyond = ~(np.abs(errors[delay:]) <= SETTLING_BAND)
    return MOST_SAMPLES + 1 - np.argmax(beyond[::-1], axis=0)


def samples_until_within(errors: FloatArray, bound: float) -> int:
    """Return how many of ``errors`` (k,) pass before all others are within ``bound``."""
    beyond = np.flatnonzero(~(np.abs(errors) <= bound))
    return int(beyond[-1]) + 1 if len(beyond) else 0


class LinearLoop:
    """A sampled loop with posture loop, mass and contact.

    Args:
        loop: Plant and sensor.
        controller: The controller.
        slides: Whether it is the loop of the place, without a spring.
    """

    def __init__(self, loop: Loop, controller: Filter, *, slides: bool = False) -> None:
        self._loop = loop
        self._controller = controller
        self._a, self._b, self._c, self._d = _plant(loop, slides)

    def step(self, state: NDArray[np.complex128], *, goal: float = 0.0, noise: float = 0.0) -> NDArray[np.complex128]:
        """Return the state (k,) after a period: plant, target place, its speed, the integral, delayed readings."""
        loop = self._loop
        controller = self._controller
        n = len(self._a)
        x, (target, speed, gathered), late = state[:n], state[n : n + 3], state[n + 3 :]
        late = np.concatenate([[self.reading(state) + noise], late])
        error = goal - late[loop.delay]
        dt = loop.tick
        gain = controller.gain * cmath.exp(1j * controller.angle)
        for _ in range(loop.ticks):
            gathered = gathered + dt * error
            place = x[0] if n else target
            aim = gain * (error + gathered / controller.integral_time) - controller.position_gain * place
            speed = speed + dt / controller.inertia_time * (aim - speed) if controller.inertia_time > dt else aim
            target = target + dt * speed
            x = self._a @ x + self._b * target
        return np.concatenate([x, [target, speed, gathered], late[: loop.delay]])

    def reading(self, state: NDArray[np.complex128]) -> complex:
        """Return the force [N] or place [m] reading of a state."""
        n = len(self._a)
        return complex(self._c @ state[:n] + self._d * state[n])

    @property
    def stable(self) -> bool:
        """Whether errors decay."""
        matrix = np.stack([self.step(row) for row in np.eye(self._size, dtype=complex)], axis=1)
        if math.isinf(self._controller.integral_time):  # the integral has no effect
            kept = np.arange(self._size) != len(self._a) + 2
            matrix = matrix[np.ix_(kept, kept)]
        return bool(np.abs(np.linalg.eigvals(matrix)).max() < 1 - 1e-9)

    def settling(self) -> int:
        """Return the samples until at most 2 % of a step of the contact are left; ``MOST_SAMPLES`` if never."""
        state = np.zeros(self._size, dtype=complex)
        errors = np.zeros(MOST_SAMPLES)
        for k in range(MOST_SAMPLES):
            errors[k] = abs(1 - self.reading(state))
            state = self.step(state, goal=float(k >= self._loop.delay))
        return samples_until_within(errors, SETTLING_BAND)

    def ripple(self) -> float:
        """Return the variance of the true value per variance of white noise in the reading."""
        state = self.step(np.zeros(self._size, dtype=complex), noise=1.0)
        total = 0.0
        for _ in range(MOST_SAMPLES):
            total += abs(self.reading(state)) ** 2
            state = self.step(state)
        return total

    @property
    def _size(self) -> int:
        return len(self._a) + 3 + self._loop.delay


def _plant(loop: Loop, slides: bool) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Transition of the state in a tick (n, n), response to a target place (n,), and the reading as (n,) and scalar.

    MuJoCo's contact with an impedance of one half (``SOLVER_IMPEDANCE``) doubles the effective mass of the body that it
    holds, damps it critically, and carries half of the servo's force and half of that of its spring and damper.
    """
    stiffness = 1.0 if slides else loop.stiffness
    if loop.servo == IDEAL and not loop.lag:
        return np.zeros((0, 0)), np.zeros(0), np.zeros(0), stiffness
    if loop.servo == IDEAL:
        stays = math.exp(-loop.tick / loop.lag)
        return np.array([[stays]]), np.array([1 - stays]), np.array([stiffness]), 0.0
    held = np.array([0.0 if slides else loop.stiffness, 0.0])
    mass = MASS if slides else 2 * MASS
    held[1] = 2 * math.sqrt(mass * held[0])
    servo = MASS * np.array([loop.servo**2, 2 * loop.servo])
    whole = np.zeros((3, 3))
    whole[0, 1] = 1.0
    whole[1, :2] = -(servo + held) / mass
    whole[1, 2] = servo[0] / mass
    moved = expm(whole * loop.tick)
    reads = np.array([1.0, 0.0]) if slides else (held - servo) / 2
    return moved[:2, :2], moved[:2, 2], reads, 0.0 if slides else servo[0] / 2
