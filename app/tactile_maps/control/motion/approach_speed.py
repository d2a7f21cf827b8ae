"""Bound on the speed of an approach by the force of the impact that would end it.

A point of the skin that moves outward hits an object that does not yield. The cover is a spring k with the damping
ratio 1 / sqrt(2) for the effective mass m = 1 / (J M^-1 J^T) along the normal, which is about that of simulated covers.
A free mass m would be stopped with the force v sqrt(2 k m). The drives add to it: until the controller has read the
contact, they push on with the torque that balanced their damping, and the desired posture moves on. See
``peak_force``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY, posture_loop
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.skin.model.skin import Skin

_LEAST_MOBILITY = 1e-9
"""Inverse mass below which a point does not move [1/kg]."""
_REACTION = 2 / INNER_FREQUENCY
"""Time in which the joints follow a command [s]; the impact ends so long after the first reading of the contact."""
_STEPS = 20
"""Number of steps in each of these times for which the force is computed."""


@dataclass(frozen=True, eq=False)
class TaxelMotions:
    """Motion of a skin's taxels along their normals. Built once.

    Attributes:
        screws: For each patch its link, and the normals and moments of the normals of its taxels (k, 6), link frame.
    """

    screws: tuple[tuple[str, FloatArray], ...]

    @classmethod
    def of(cls, skin: Skin) -> TaxelMotions:
        """Return the motion of the taxels of a skin."""
        taxels = [(patch.link, patch.taxels.positions, patch.taxels.normals) for patch in skin.patches]
        return cls(tuple((link, np.hstack([normals, np.cross(places, normals)])) for link, places, normals in taxels))


@dataclass(frozen=True, eq=False)
class ApproachSpeed:
    """Bound on joint velocities by the largest impact of any taxel. Parts without taxels are not considered.

    Attributes:
        taxels: Motion of the taxels.
        max_impact: Largest force of an impact [N].
        stiffness: Stiffness of a contact of the cover [N/m].
        latency: Time from a touch to the first command that reads it [s].
    """

    taxels: TaxelMotions
    max_impact: float
    stiffness: float
    latency: float

    def impact(self, configuration: Configuration, speed: FloatArray) -> tuple[float, str]:
        """Return the largest force of an impact at a joint velocity (n,) [N], and its link.

        Of all taxels those are examined whose mass, or whose drives, press hardest.

        Args:
            configuration: The robot at its current posture.
            speed: (n,) joint velocity [rad/s, or m/s for a slide].

        Cost: 1 ms for 1,000 taxels.
        """
        mass = configuration.mass_matrix()
        inverse = np.linalg.inv(mass)
        light = 1 / np.diagonal(mass)
        hardest: dict[int, tuple[float, str, FloatArray]] = {}
        for link, screws in self.taxels.screws:
            twists = configuration.twists(link)
            outward = screws.dot(twists.dot(speed))
            mobility = np.einsum("ij,ij->i", screws.dot(twists.dot(inverse).dot(twists.T)), screws)
            by_drives = np.einsum("ij,ij->i", screws.dot((twists * light).dot(twists.T)), screws)
            moving = (outward > 0) & (mobility > _LEAST_MOBILITY)
            for number, yielding in enumerate((mobility, by_drives / self.stiffness + 1 / INNER_FREQUENCY**2)):
                force = np.where(moving, outward / np.sqrt(np.maximum(yielding, _LEAST_MOBILITY)), 0.0)
                first = int(force.argmax()) if len(force) else 0
                if len(force) and force[first] > hardest.get(number, (0.0,))[0]:
                    hardest[number] = float(force[first]), link, screws[first].dot(twists)
        found = [(self._peak(configuration, mass, row, speed), link) for _, link, row in hardest.values()]
        return max(found, default=(0.0, ""))

    def _peak(self, configuration: Configuration, mass: FloatArray, outward: FloatArray, speed: FloatArray) -> float:
        impedance = posture_loop(configuration)
        return peak_force(
            mass,
            (impedance.stiffness, impedance.damping),
            outward,
            speed,
            stiffness=self.stiffness,
            latency=self.latency,
        )

    def limited(self, configuration: Configuration, speed: FloatArray, limits: ActiveLimits) -> FloatArray:
        """Return the joint velocity (n,), scaled down if an impact would exceed ``max_impact``.

        Args:
            configuration: The robot at its current posture.
            speed: (n,) requested joint velocity [rad/s, or m/s for a slide].
            limits: Collects an ``APPROACH_SPEED`` entry when the speed is reduced.
        """
        impact, link = self.impact(configuration, speed)
        if impact <= self.max_impact:
            return speed
        limits.add(Limit(LimitKind.APPROACH_SPEED, (link,), value=impact, bound=self.max_impact))
        return speed * (self.max_impact / impact)


def peak_force(
    mass: FloatArray,
    impedance: tuple[FloatArray, FloatArray],
    outward: FloatArray,
    speed: FloatArray,
    *,
    stiffness: float,
    latency: float,
) -> float:
    """Return the largest force of an impact on an object that does not yield [N].

    The joints move at a constant speed before the impact. With their displacement q since then, M q'' = K (a + s - q) -
    D q' - J^T f,  where a = D speed / K is the distance of the desired posture, and s grows by ``speed`` until
    ``latency``. The contact has the depth J q and the force f = k J q + c J q'.

    Args:
        mass: (n, n) mass matrix.
        impedance: (n,) stiffness and damping of the joints.
        outward: (n,) outward speed of the point per joint velocity, J.
        speed: (n,) joint velocity [rad/s, or m/s for a slide].
        stiffness: Stiffness of the contact [N/m].
        latency: Time from the touch to the first command that reads it [s].
    """
    spring, damper = impedance
    n = len(speed)
    inverse = np.linalg.inv(mass)
    damping = np.sqrt(2 * stiffness / float(outward.dot(inverse).dot(outward)))
    rates = np.zeros((2 * n + 2, 2 * n + 2))  # of displacement, velocity, the way of the desired posture as time, and 1
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n, :n] = -inverse.dot(np.diag(spring) + stiffness * np.outer(outward, outward))
    rates[n : 2 * n, n : 2 * n] = -inverse.dot(np.diag(damper) + damping * np.outer(outward, outward))
    rates[n : 2 * n, -2] = inverse.dot(spring * speed)
    rates[n : 2 * n, -1] = inverse.dot(damper * speed)
    rates[-2, -1] = 1.0
    state = np.concatenate([np.zeros(n), speed, (0.0, 1.0)])
    force = np.concatenate([stiffness * outward, damping * outward, np.zeros(2)])
    peak = float(force.dot(state))
    for seconds in (latency, _REACTION):
        step = expm(rates * (seconds / _STEPS))
        for _ in range(_STEPS):
            state = step.dot(state)
            peak = max(peak, float(force.dot(state)))
        rates[-2, -1] = 0.0
    return peak
