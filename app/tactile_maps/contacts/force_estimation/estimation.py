"""Registry of force estimators, and regions with the force of the selected estimator."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.error_budget import INDEPENDENT, Widths, combine_parts, reading_variances
from tactile_maps.contacts.detection.regions import ContactRegion, ring_shares, shared_readings
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
    """Entry of a force estimator in the registry.

    Attributes:
        name: Name in scenes, recordings and commands.
        title: Displayed name.
        tip: Principle and cost, in one sentence.
        build: Builds it from the skin and the depth of its taxels below the surface [m].
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
            raise plugin.error("it did not return a ForceEstimate", type(found).__name__)
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
        EstimatorEntry(
            "area-sum", "Pressure times area", "Sum over the touched taxels.", lambda skin, _: AreaSum(skin)
        ),
        EstimatorEntry(
            "local-nnls",
            "NNLS deconvolution",
            "Non-negative least squares with the cover's blur undone.",
            lambda skin, depth: Deconvolution(skin, nonnegative_least_squares, depth=depth),
        ),
        EstimatorEntry(
            "tikhonov",
            "Tikhonov (discrepancy principle)",
            "As smooth as the noise requires.",
            lambda skin, depth: Deconvolution(skin, tikhonov, depth=depth),
        ),
        EstimatorEntry(
            "lumped",
            "Force-torque sensor in the link",
            "Measures the wrench, without a skin.",
            lambda skin, _: ForceTorqueSensor(skin),
        ),
    ),
    _guarded,
)
"""Force estimators by name, built-in ones first, then those of plug-ins."""


def build_estimator(name: EstimatorName, skin: Skin, *, depth: float) -> ForceEstimator:
    """Build the estimator of that name for a skin.

    Args:
        name: Name of the estimator.
        skin: The skin.
        depth: Depth of its taxels below the surface [m], for estimators that remove the blur.

    Raises:
        MapError: Unknown estimator, or the depth is out of range.
    """
    if name not in FORCE_ESTIMATORS:
        raise MapError("unknown force estimator", value=name, remedy=FORCE_ESTIMATORS.remedy(name))
    return FORCE_ESTIMATORS[name].build(skin, depth)


Regions = tuple[ContactRegion, ...]
Estimates = dict[int, ForceEstimate]
_NONE: Mapping[str, FloatArray] = MappingProxyType({})
_NONE_AWAITED: Mapping[int, str] = MappingProxyType({})
TORQUE_ARM = 0.02
"""Noise of a force-torque sensor's torques per noise of its forces [m]: 1/752 N m to 1/16 N (ATI Mini45, SI-145-5)."""


class _Known(NamedTuple):
    """Last result of an estimator, with its input."""

    regions: Regions
    pressures: FloatArray
    errors: SensorUncertainty
    result: tuple[Regions, Estimates]

    def holds(self, regions: Regions, pressures: FloatArray, errors: SensorUncertainty) -> bool:
        """Whether the input is the same; ``ContactDetector`` returns identical regions for a held sample."""
        return regions is self.regions and pressures is self.pressures and errors is self.errors


def _widths(reading: ContactReading, estimate: ForceEstimate, areas: FloatArray) -> dict[str, Widths]:
    """Return the parts of an estimate's uncertainty [N].

    Errors that readings share are those of the sum over the region. The error of the estimator itself is at most about
    its difference from that sum, since both estimate the total.

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
    """Forces of regions by the selected estimator. Mutable: it stores built estimators and ids of lumped contacts.

    If a method refuses or finds no push, the region keeps the sum over its taxels, and its estimate contains the
    reason.

    ``lumped`` combines all contacts of a link into one, as a sensor in the link would: force and place are those of the
    wrench, and there is no shape. Begin and end of the contact are still those of the skin, so that controllers are
    compared over the same time. The contact keeps its first id, whatever happens to the contacts of the skin.

    Args:
        map_: Map of the skin.
        estimator: Name of the estimator; may be set at any time.
        depth: Depth of the taxels below the surface [m].
        wrench_noise: Standard deviation of the forces of the force-torque sensor [N]; may be set at any time.
        seed: Seed of that noise.

    Attributes:
        awaited: Ids of lost contacts that may come back, as of the last frame.
        mismatch: Touches of a link of which none explains its wrench, of ``lumped`` at the last frame; None otherwise.

    Raises:
        MapError: The depth is out of range.

    Cost: none with the area sum, otherwise that of the estimator for each contact and 10 µs. Regions of a held sample
        are estimated once.
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
        self._positions = map_.skin.positions
        self.awaited: Collection[int] = ()
        self.estimator = estimator
        self.reset()

    @property
    def estimator(self) -> EstimatorName:
        """Name of the estimator. Setting one that removes the blur builds its equations: 0.15 s for 1000 taxels."""
        return self._name

    @estimator.setter
    def estimator(self, name: EstimatorName) -> None:
        self._known: _Known | None = None
        if name != "area-sum" and name not in self._built:
            self._built[name] = build_estimator(name, self._map.skin, depth=self._depth)
        self._name: EstimatorName = name

    def use(self, map_: TactileMap) -> None:
        """Use another map; for another skin the estimators are built again."""
        skin = self._map.skin
        self._map = map_
        self._known = None
        if map_.skin is not skin:
            self._built = {}
            self._positions = map_.skin.positions
            self.estimator = self._name

    def reset(self) -> None:
        """Forget the ids of lumped contacts and restart the noise."""
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
        awaited: Mapping[int, str] = _NONE_AWAITED,
    ) -> tuple[Regions, Estimates]:
        """Return the regions with estimated forces, strongest first, and the estimates by region.

        Args:
            regions: Regions of a frame, with the sum of pressure times area.
            pressures: (taxels,) readings of that frame [Pa].
            errors: Their uncertainty.
            wrenches: Contact wrench on each link: (6,) force [N] and torque [N m] about its origin, in its frame; only
                for ``lumped``.
            awaited: Links of lost contacts that may come back, by id.
        """
        self.awaited = awaited.keys()
        self.mismatch = None
        if self._name != "lumped":
            self._lumped = {}
        if self._name == "area-sum":
            return regions, {}
        if self._known is not None and self._known.holds(regions, pressures, errors):
            return self._known.result
        result = self._estimated(regions, pressures, errors, wrenches, awaited)
        # A force-torque sensor has a new reading at every tick, even if the sample of the skin is held.
        held = self._name != "lumped" and not pressures.flags.writeable
        self._known = _Known(regions, pressures, errors, result) if held else None
        return result

    def _estimated(
        self,
        regions: Regions,
        pressures: FloatArray,
        errors: SensorUncertainty,
        wrenches: Mapping[str, FloatArray],
        awaited: Mapping[int, str],
    ) -> tuple[Regions, Estimates]:
        if not math.isfinite(float(pressures.sum())):  # not finite counts as unpressed, as in the detector
            pressures = np.where(np.isfinite(pressures), pressures, 0.0)
        areas = self._map.skin.areas
        readings = []
        for region, share in zip(regions, ring_shares([region.taxels for region in regions]), strict=True):
            taxels = region.taxels
            own = shared_readings(pressures, taxels, share)
            noise = errors.noise_of(taxels, areas.take(taxels))
            variances = reading_variances(errors, own.take(taxels), taxels)
            whole = np.add.reduce([np.zeros(len(taxels)), *variances.values()])
            readings.append(ContactReading(region, own, noise, errors.gain, np.asarray(whole, dtype=np.float64)))
        if self._name == "lumped":
            readings = [
                replace(r, wrench=self._measured(wrenches, r.region.link))
                for r in self._one_a_link(readings, awaited.values())
            ]
            self.mismatch = self._mismatch(readings, regions)
        estimator = self._built[self._name]
        found = []
        for reading in readings:
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

    def _one_a_link(self, readings: list[ContactReading], awaited: Collection[str]) -> list[ContactReading]:
        """Return the strongest contact of each link, with the id of the link's lumped contact."""
        first: dict[str, ContactReading] = {}
        for reading in readings:
            first.setdefault(reading.region.link, reading)
        known = {link: number for link, number in self._lumped.items() if link in first or link in awaited}
        new = {link: min(r.region.id for r in readings if r.region.link == link) for link in first}
        self._lumped = new | known
        self.awaited = {number for link, number in known.items() if link not in first}
        return [
            replace(r, region=replace(r.region, id=self._lumped[link], merged=(), split_from=None))
            for link, r in first.items()
        ]

    def _mismatch(self, readings: Sequence[ContactReading], regions: Regions) -> WrenchMismatch | None:
        """Return the mismatch of the first link whose wrench none of its touches explains."""
        for reading in readings:
            link = reading.region.link
            wrench = reading.wrench
            on_link = [region for region in regions if region.link == link]
            found = None if wrench is None else wrench_mismatch(link, wrench, on_link, self._positions)
            if found is not None:
                return found
        return None

    def _measured(self, wrenches: Mapping[str, FloatArray], link: str) -> Wrench:
        """Return the reading of the force-torque sensor in a link."""
        wrench = wrenches.get(link, np.zeros(6))
        noise = self.wrench_noise
        if noise:
            wrench = wrench + noise * np.repeat((1.0, TORQUE_ARM), 3) * self._random.standard_normal(6)
        return Wrench(wrench[:3], wrench[3:], force_noise=noise, torque_noise=TORQUE_ARM * noise)
