"""Regions with the force that the chosen estimator finds for them, instead of the sum of pressure times area; and the
estimators by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty, taxel_positions
from tactile_maps.contacts.detection.error_budget import INDEPENDENT, Widths, combine_parts, reading_variances
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.deconvolution import Deconvolution, nonnegative_least_squares, tikhonov
from tactile_maps.contacts.force_estimation.estimate import (
    AreaSum,
    ContactReading,
    EstimateRefusal,
    EstimatorName,
    ForceEstimate,
    ForceEstimator,
    Wrench,
)
from tactile_maps.contacts.force_estimation.force_torque_sensor import ForceTorqueSensor
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch, wrench_mismatch
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.plugins import Plugin, PluginObject, Registry, guard_call
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin


@dataclass(frozen=True)
class EstimatorEntry:
    """One force estimator.

    Attributes:
        name: In scenes, recordings and commands.
        title: For people.
        tip: What it knows and what it costs, in one sentence.
        build: From the skin and the depth of its taxels below the surface [m].
    """

    name: str
    title: str
    tip: str
    build: Callable[[Skin, float], ForceEstimator]


def _guarded(plugin: Plugin, entry: EstimatorEntry) -> EstimatorEntry:
    """Return a plug-in's entry whose estimators return finite forces or raise."""

    def estimate(method: Callable[[ContactReading], object], reading: ContactReading) -> ForceEstimate:
        found = method(reading)
        if not isinstance(found, ForceEstimate):
            raise plugin.error("it gave no ForceEstimate", type(found).__name__)
        if not math.isfinite(found.force):
            raise plugin.error("its force is not finite", found.force)
        return found

    def build(make: Callable[[Skin, float], object], skin: Skin, depth: float) -> PluginObject:
        return PluginObject(plugin, make(skin, depth), "estimate", checks={"estimate": estimate})

    return replace(entry, build=guard_call(plugin, entry.build, "skin", "depth", check=build))


FORCE_ESTIMATORS: Registry[EstimatorEntry] = Registry(
    "estimators",
    EstimatorEntry,
    (
        EstimatorEntry("area-sum", "Pressure times area", "Sum over the touched taxels.",
                       lambda skin, _: AreaSum(skin)),
        EstimatorEntry("local-nnls", "NNLS deconvolution", "Non-negative least squares with the cover's blur undone.",
                       lambda skin, depth: Deconvolution(skin, nonnegative_least_squares, depth=depth)),
        EstimatorEntry("tikhonov", "Tikhonov (discrepancy principle)", "As smooth as the noise asks for.",
                       lambda skin, depth: Deconvolution(skin, tikhonov, depth=depth)),
        EstimatorEntry("lumped", "Force-torque sensor in the link", "Measures the wrench, without a skin.",
                       lambda skin, _: ForceTorqueSensor(skin)),
    ),
    _guarded,
)  # fmt: skip
"""By name; then those of plug-ins."""


def build_estimator(name: EstimatorName, skin: Skin, *, depth: float) -> ForceEstimator:
    """The estimator of that name for a skin.

    Args:
        name: Which.
        skin: The skin.
        depth: Of its taxels below the surface [m]; only those that undo the blur use it.

    Raises:
        MapError: There is none, or the depth is no such number.
    """
    if name not in FORCE_ESTIMATORS:
        raise MapError("there is no such force estimator", value=name, remedy=FORCE_ESTIMATORS.remedy(name))
    return FORCE_ESTIMATORS[name].build(skin, depth)


Regions = tuple[ContactRegion, ...]
Estimates = dict[int, ForceEstimate]
_NONE: Mapping[str, FloatArray] = MappingProxyType({})
_NOBODY: Mapping[int, str] = MappingProxyType({})
TORQUE_ARM = 0.02
"""Noise of a force-torque sensor's torques per noise of its forces [m]: 1/752 N m to 1/16 N (ATI Mini45, SI-145-5)."""


class _Known(NamedTuple):
    """What was estimated last, and of what."""

    regions: Regions
    pressures: FloatArray
    errors: SensorUncertainty
    answer: tuple[Regions, Estimates]

    def holds(self, regions: Regions, pressures: FloatArray, errors: SensorUncertainty) -> bool:
        """Whether it was for the very same; ``ContactDetector`` finds the same regions in a sample that is held."""
        return regions is self.regions and pressures is self.pressures and errors is self.errors


def _widths(reading: ContactReading, estimate: ForceEstimate, areas: FloatArray) -> dict[str, Widths]:
    """Return the parts of an estimate's uncertainty [N].

    What readings share is taken over from the sum over the region. An estimator's own error is at most about what it
    differs from that sum, since both find the total.

    Args:
        reading: Region with the sum over its taxels, and the variances of its readings.
        estimate: Estimate with the uncertainty that these variances cause.
        areas: (k,) areas of the region's taxels [m²].
    """
    region = reading.region
    if reading.wrench is not None:
        return {"wrench": Widths.normal(estimate.force_error)}
    known = {name: Widths(part, region.force_limits.get(name, 2 * part)) for name, part in region.force_parts.items()}
    own = {name: width for name, width in known.items() if name in INDEPENDENT}
    variances = reading.variances_of(reading.pressures.take(region.taxels))
    whole = math.sqrt(float(variances @ np.square(areas)))
    share = estimate.force_error / whole if whole > 0 else 0.0
    scaled = {name: Widths(share * width.standard, share * width.limit) for name, width in own.items()}
    scaled = scaled or {"noise": Widths.normal(estimate.force_error)}
    difference = abs(estimate.force - region.force)
    return known | scaled | {"estimator": Widths(difference, difference)}


class RegionForceEstimator:
    """Asks the estimator. Mutable: estimators are built when first wanted, and lumped contacts keep their names.

    Where a method refuses, or finds no push, the region keeps the sum over its taxels, and its estimate says why.

    ``lumped`` makes one contact of all that touch a link, as a sensor in the link would: force and place are those of
    the wrench, and there is no shape. Whether and how long there is contact is still the skin's word, so that
    controllers are compared on the same moments of contact. It keeps the name that it began with, whatever the skin's
    contacts do.

    Args:
        map_: The skin's map.
        estimator: Which; may be set at any time.
        depth: Of the taxels below the surface [m].
        wrench_noise: Standard deviation of the forces of the force-torque sensor [N]; may be set at any time.
        seed: Of that noise.

    Attributes:
        awaited: Ids of contacts that are gone but may come back, as of the last frame.
        mismatch: Several touches whose wrench none of them explains, of ``lumped`` at the last frame; None otherwise.

    Raises:
        MapError: The depth is no such number.

    Cost: nothing with the area sum; else that of the estimator for each contact, and 10 µs. Regions that a slow skin
    holds are estimated once.
    """

    def __init__(
        self,
        map_: TactileMap,
        *,
        estimator: EstimatorName = "area-sum",
        depth: float = 0.002,
        wrench_noise: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.wrench_noise = wrench_noise
        self._map = map_
        self._depth = depth
        self._seed = seed
        self._built: dict[EstimatorName, ForceEstimator] = {}
        self._lumped: dict[str, int] = {}
        self._positions = taxel_positions(map_.skin)
        self.awaited: Collection[int] = ()
        self.estimator = estimator
        self.reset()

    @property
    def estimator(self) -> EstimatorName:
        """The way in force. Setting one that undoes the blur builds its equations: 0.15 s for 1000 taxels."""
        return self._name

    @estimator.setter
    def estimator(self, name: EstimatorName) -> None:
        self._known: _Known | None = None
        if name != "area-sum" and name not in self._built:
            self._built[name] = build_estimator(name, self._map.skin, depth=self._depth)
        self._name: EstimatorName = name

    def use(self, map_: TactileMap) -> None:
        """Place by another map from now on; of another skin's, the estimators are built anew."""
        skin = self._map.skin
        self._map = map_
        self._known = None
        if map_.skin is not skin:
            self._built = {}
            self._positions = taxel_positions(map_.skin)
            self.estimator = self._name

    def reset(self) -> None:
        """Forget who was who; the noise begins afresh."""
        self._lumped = {}
        self.awaited = ()
        self.mismatch: WrenchMismatch | None = None
        self._random = np.random.default_rng((self._seed, 6))

    def read(
        self,
        regions: Regions,
        pressures: FloatArray,
        errors: SensorUncertainty,
        wrenches: Mapping[str, FloatArray] = _NONE,
        *,
        awaited: Mapping[int, str] = _NOBODY,
    ) -> tuple[Regions, Estimates]:
        """The regions as the estimator has them, the strongest first, and its answers by region.

        Args:
            regions: Of a frame, with the sum of pressure times area.
            pressures: (taxels,) they were found in [Pa].
            errors: How far these may be off.
            wrenches: By link, (6,) force [N] and torque [N m] of all contacts on it, about its origin, in its frame;
                only for ``lumped``.
            awaited: Links by ids of contacts that are gone but may come back.
        """
        self.awaited = awaited.keys()
        self.mismatch = None
        if self._name != "lumped":
            self._lumped = {}
        if self._name == "area-sum":
            return regions, {}
        if self._known is not None and self._known.holds(regions, pressures, errors):
            return self._known.answer
        answer = self._estimated(regions, pressures, errors, wrenches, awaited)
        # A force-torque sensor reads at every tick, whatever the skin holds.
        held = self._name != "lumped" and not pressures.flags.writeable
        self._known = _Known(regions, pressures, errors, answer) if held else None
        return answer

    def _estimated(
        self,
        regions: Regions,
        pressures: FloatArray,
        errors: SensorUncertainty,
        wrenches: Mapping[str, FloatArray],
        awaited: Mapping[int, str],
    ) -> tuple[Regions, Estimates]:
        """See ``read``."""
        if not math.isfinite(float(pressures.sum())):  # what reads no number counts as unpressed, as to the reader
            pressures = np.where(np.isfinite(pressures), pressures, 0.0)
        areas = self._map.skin.areas
        asked = []
        for region in regions:
            taxels = region.taxels
            noise = errors.noise_of(taxels, areas.take(taxels))
            variances = reading_variances(errors, pressures.take(taxels), taxels)
            whole = np.add.reduce([np.zeros(len(taxels)), *variances.values()])
            asked.append(ContactReading(region, pressures, noise, errors.gain, np.asarray(whole, dtype=np.float64)))
        if self._name == "lumped":
            asked = [
                replace(r, wrench=self._felt(wrenches, r.region.link))
                for r in self._one_a_link(asked, awaited.values())
            ]
            self.mismatch = self._mismatch(asked, regions)
        estimator = self._built[self._name]
        found = []
        for reading in asked:
            estimate = estimator.estimate(reading)
            if estimate.refused is None and estimate.force <= 0:
                estimate = replace(estimate, refused=EstimateRefusal.PULL)
            if estimate.refused is None:
                widths = _widths(reading, estimate, areas.take(reading.region.taxels))
                parts = {name: width.standard for name, width in widths.items()}
                limits = {name: width.limit for name, width in widths.items()}
                estimate = replace(estimate, force_error=combine_parts(parts))
                region = replace(reading.region, force_parts=parts, force_limits=limits)
            else:
                region = reading.region
            found.append((self._as_estimated(region, estimate), estimate))
        found.sort(key=lambda pair: (-pair[0].force, pair[0].id))
        return tuple(region for region, _ in found), {region.id: estimate for region, estimate in found}

    def _as_estimated(self, region: ContactRegion, estimate: ForceEstimate) -> ContactRegion:
        if estimate.refused is not None:
            return region
        region = replace(region, force=estimate.force, force_error=estimate.force_error)
        at = estimate.at
        if at is None or at == region.at:
            return region
        skin = self._map.skin
        return replace(
            region,
            at=at,
            map_point=self._map.to_map(at),
            link_position=skin.position(at),
            link_normal=skin.normal(at),
            place_error=estimate.place_error,
            torn=False,
            link_axes=np.zeros((2, 3)),
            map_axes=np.zeros((2, 2)),
        )

    def _one_a_link(self, asked: list[ContactReading], awaited: Collection[str]) -> list[ContactReading]:
        """The strongest contact of each link stands for all of them, under the name that the link's contact has."""
        first: dict[str, ContactReading] = {}
        for reading in asked:
            first.setdefault(reading.region.link, reading)
        known = {link: number for link, number in self._lumped.items() if link in first or link in awaited}
        new = {link: min(r.region.id for r in asked if r.region.link == link) for link in first}
        self._lumped = new | known
        self.awaited = {number for link, number in known.items() if link not in first}
        return [
            replace(r, region=replace(r.region, id=self._lumped[link], merged=(), split_from=None))
            for link, r in first.items()
        ]

    def _mismatch(self, asked: Sequence[ContactReading], regions: Regions) -> WrenchMismatch | None:
        """Of the first link whose wrench no one of its touches explains."""
        for reading in asked:
            link = reading.region.link
            wrench = reading.wrench
            on_link = [region for region in regions if region.link == link]
            found = None if wrench is None else wrench_mismatch(link, wrench, on_link, self._positions)
            if found is not None:
                return found
        return None

    def _felt(self, wrenches: Mapping[str, FloatArray], link: str) -> Wrench:
        """What the sensor in a link reports."""
        wrench = wrenches.get(link, np.zeros(6))
        noise = self.wrench_noise
        if noise:
            wrench = wrench + noise * np.repeat((1.0, TORQUE_ARM), 3) * self._random.standard_normal(6)
        return Wrench(wrench[:3], wrench[3:], force_noise=noise, torque_noise=TORQUE_ARM * noise)
