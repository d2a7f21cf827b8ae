"""Shear of contacts from the tractions of all taxels, friction of sliding contacts, and friction in use by taxel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.detection.regions import ContactRegion, ring_shares, shared_readings
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.tactile.mechanics.coulomb_bed import STUCK
from tactile_maps.tactile.mechanics.plane_vectors import ComplexArray, as_complex, plane_of, turned_into
from tactile_maps.tactile.sensors.sensor_effects import Misorientation

SLIDING = 0.95
"""Friction usage from which a contact slides."""
INCIPIENT = 0.7
"""Share of the friction limit on taxels that stick, below which slip is incipient: a ball uses 0.8 of its friction."""
TAXEL_SLIPS = STUCK
"""Friction in use from which a taxel slips."""
_MOVING = 0.005
"""Speed of the centre along the skin above which a contact may slide [m/s]."""
_NEAR_HIGHEST = 0.95
"""Share of the highest ratio of forces from which a moving contact counts as sliding."""
_UNEVEN = 0.1
"""Share of the forces by which those of a sliding contact may differ from the same friction on all taxels.

A contact that rolls moves too, but its shear is not proportional to its pressure."""
_RISES = 1.01
"""Ratio of the force to that at the last reading from which a contact is being loaded: its centre moves too, and under
an oblique load its shear is proportional to its pressure."""
_ENOUGH = 10
"""Readings while sliding after which the measured coefficient is used."""


@dataclass
class _Sliding:
    """Statistics of the ratio of forces of one contact while its centre moves. Mutable."""

    at: FloatArray
    time: float
    force: float
    highest: float = 0.0
    count: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def raise_to(self, ratio: float) -> None:
        """Note a ratio of the forces: if friction bears a higher one than it did while sliding, that was no sliding."""
        self.highest = max(self.highest, ratio)
        if self.mean < _NEAR_HIGHEST * self.highest:
            self.count = 0
            self.mean = 0.0
            self.squares = 0.0

    def add(self, ratio: float) -> None:
        """Add a ratio of tangential to normal force."""
        self.count += 1
        change = ratio - self.mean
        self.mean += change / self.count
        self.squares += change * (ratio - self.mean)

    @property
    def error(self) -> float:
        """Standard deviation of the ratios."""
        return math.sqrt(self.squares / (self.count - 1)) if self.count > 1 else math.inf


_BIAS = 1.2
"""Factor of a bias that is combined with a normal error: 68 to 77 % of errors are within, up to a bias of 3 sd."""


class ShearEstimator:
    """Estimator of the shear of contacts, tick by tick. Mutable; ``reset`` forgets measured coefficients.

    Args:
        map_: Map of the skin, for the frames of its taxels.
        friction: Coefficient of contacts until it was measured, > 0.

    Attributes:
        noise: Standard deviation of a traction [Pa].
        axis_errors: Standard deviation of the share of one channel of a taxel that another one reads, by effect of the
            sensor.

    Cost: 60 µs a contact.
    """

    def __init__(self, map_: TactileMap, friction: float) -> None:
        self.noise = 0.0
        self.axis_errors: Mapping[str, float] = {}
        self._friction = friction
        self._areas = map_.skin.areas
        self._positions = map_.skin.positions
        self.use(map_)
        self.reset()

    def use(self, map_: TactileMap) -> None:
        """Read by the frames of another map of the same skin from now on."""
        self._frames = taxel_frames(map_)

    def reset(self) -> None:
        """Forget all contacts."""
        self._contacts: dict[int, _Sliding] = {}

    def read(
        self, time: float, regions: Sequence[ContactRegion], pressures: FloatArray, shear: FloatArray
    ) -> tuple[ContactRegion, ...]:
        """Return the regions with their shear.

        Args:
            time: Time of the frame [s].
            regions: Contact regions.
            pressures: (taxels,) readings [Pa].
            shear: (taxels, 2) tractions along t1 and t2 [Pa].
        """
        known = self._contacts
        self._contacts = {}
        found = []
        for region, share in zip(regions, ring_shares([region.taxels for region in regions]), strict=True):
            normal = shared_readings(pressures, region.taxels, share)
            along = shared_readings(shear, region.taxels, share)
            sliding = known.get(region.id) or _Sliding(region.link_position, time, region.force)
            self._contacts[region.id] = sliding
            region = self._with_axis_errors(region, along)
            found.append(replace(region, shear=self._shear(time, region, sliding, normal, along)))
        return tuple(found)

    def _with_axis_errors(self, region: ContactRegion, shear: FloatArray) -> ContactRegion:
        """Return the region with the uncertainty of its force due to shear that is read as pressure.

        A rotated frame also reads less pressure: sd² of the force on average, half for each of two axes.
        """
        if not self.axis_errors:
            return region
        size = length(self._areas[region.taxels] * np.linalg.norm(shear[region.taxels], axis=1))
        parts = {name: share * size for name, share in self.axis_errors.items()}
        if Misorientation.key in parts:
            lost = _BIAS * self.axis_errors[Misorientation.key] ** 2 * region.force
            parts[Misorientation.key] = math.hypot(parts[Misorientation.key], lost)
        return replace(
            region,
            force_error=math.hypot(region.force_error, *parts.values()),
            force_parts={**region.force_parts, **parts},
            force_limits={**region.force_limits, **{name: 2 * part for name, part in parts.items()}},
        )

    def _shear(
        self, time: float, region: ContactRegion, sliding: _Sliding, pressures: FloatArray, shear: FloatArray
    ) -> ContactShear:
        taxels = region.taxels
        areas = self._areas[taxels]
        plane = plane_of(region.link_normal)
        # As the physics turned them from the plane of the contact into those of the taxels.
        turns = turned_into(self._frames[taxels], region.link_normal, plane).conj()
        forces = areas * as_complex(shear[taxels]) * turns
        arms = as_complex((self._positions[taxels] - region.link_position) @ plane)
        total = complex(forces.sum())
        ratio = abs(total) / region.force if region.force > 0 else 0.0
        normal = areas * np.maximum(pressures[taxels], 0.0)
        self._learn(time, region, sliding, ratio, _unevenness(forces, normal))
        estimated = sliding.count >= _ENOUGH
        friction = sliding.mean if estimated else self._friction
        usage = ratio / friction
        limits = friction * normal
        stuck = float(limits[np.abs(forces) < STUCK * limits].sum() / limits.sum()) if limits.any() else 1.0
        slip = Slip.SLIDING if usage >= SLIDING else Slip.INCIPIENT if stuck < INCIPIENT else Slip.STICKING
        # Per axis: pressure and the other axis of shear are read as shear.
        other = math.hypot(*self.axis_errors.values()) * np.hypot(pressures[taxels], np.abs(forces) / areas)
        deviations = areas * np.hypot(self.noise, other)
        force_error = length(deviations)
        parts = (
            force_error / max(abs(total), force_error) if force_error else 0.0,
            region.force_error / region.force if region.force > 0 else 0.0,
            sliding.error / friction if estimated else 0.0,
        )
        along = plane @ (total.real, total.imag)
        return ContactShear(
            force=(float(along[0]), float(along[1]), float(along[2])),
            torque=float(np.vdot(arms, forces).imag),
            usage=usage,
            stuck=stuck,
            slip=slip,
            friction=friction,
            estimated=estimated,
            force_error=force_error,
            torque_error=length(deviations * np.abs(arms)),
            usage_error=usage * math.hypot(*parts),
        )

    def _learn(self, time: float, region: ContactRegion, sliding: _Sliding, ratio: float, uneven: float) -> None:
        """Use the ratio as a measured coefficient if the contact moves, and all taxels rub alike and near the highest
        ratio so far.
        """
        elapsed = time - sliding.time
        moved = length(region.link_position - sliding.at)
        sliding.raise_to(ratio)
        rubs = uneven < _UNEVEN and ratio > _NEAR_HIGHEST * sliding.highest and region.force < _RISES * sliding.force
        if elapsed > 0 and moved > _MOVING * elapsed and rubs:
            sliding.add(ratio)
        sliding.at = region.link_position
        sliding.time = time
        sliding.force = region.force


def _unevenness(forces: ComplexArray, normal: FloatArray) -> float:
    """Return how much the shear forces (k,) [N] differ from one friction on all normal forces (k,) [N], 0 to 2."""
    size = float(np.abs(forces).sum())
    pressed = float(normal.sum())
    if size == 0.0 or pressed == 0.0:
        return 2.0
    return float(np.abs(forces - forces.sum() / pressed * normal).sum()) / size


def friction_in_use(regions: Sequence[ContactRegion], pressures: FloatArray, shear: FloatArray) -> FloatArray:
    """Return the friction in use (taxels,) of pressed taxels: 0 without traction, 1 at the limit; NaN elsewhere.

    Args:
        regions: Contacts with their shear, which states the friction coefficient; others are ignored.
        pressures: (taxels,) readings [Pa].
        shear: (taxels, 2) tractions along t1 and t2 [Pa].
    """
    used = np.full(len(pressures), np.nan)
    for region in regions:
        if region.shear is not None:
            own = region.taxels[pressures[region.taxels] > 0]
            used[own] = np.linalg.norm(shear[own], axis=1) / (region.shear.friction * pressures[own])
    return used
