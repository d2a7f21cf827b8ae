"""Detection of contact regions in taxel pressures, on the graph of the skin's taxels; placed by the map and tracked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import (
    BackProjector,
    ContactLocation,
    SensorUncertainty,
    principal_axes,
)
from tactile_maps.contacts.detection.close_contacts import CloseContactSeparator
from tactile_maps.contacts.detection.error_budget import LeftOut, Motion, Readings, propagate_uncertainty
from tactile_maps.contacts.detection.image_centre import CentreSettings, taxel_moments
from tactile_maps.contacts.detection.regions import (
    ContactRegion,
    SeamCrossings,
    TaxelGraph,
    TaxelGroup,
    ring_shares,
    shared_readings,
)
from tactile_maps.contacts.detection.tracking import Measured, RegionTracker, TrackId, TrackMemory
from tactile_maps.contacts.detection.unpressed_readings import UnpressedTaxels
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, dot, seal
from tactile_maps.core.errors import MapError
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.tactile.sensors.sensor_effects import Crosstalk, crosstalk_matrix

TOUCH_THRESHOLD = 1000.0
"""Pressure from which a taxel is in contact [Pa]; commercial skins resolve 2-3 kPa."""
_RELEASE = 0.5
_HELD = 2 / 3
"""Share of the force of a new region that taxels which were touched before must exceed."""
_DROWNED = 0.5
"""A ring that reduces the force of the touched taxels to this share is all noise."""
_ITERATIONS = 8
"""Number of iterations for the force that crosstalk passes beyond the ring: exact to 1e-9 of it for a share of 5 %."""
_UNSTATED = SensorUncertainty(unknown=True)
_FROM_TAXELS = CentreSettings()
NOISE_LIMIT = 6.0
"""Standard deviations of its noise that the force on a new region's touched taxels must be: as much as four taxels that
just touch have at a threshold of three. Among 1000 taxels at 200 Hz noise alone does that once in an hour."""
_AFTER = 0.1
"""Share of its strongest reading below which a taxel of a real skin is released: soft covers keep several per cent of a
load as creep. It holds until the taxel has come back to rest."""
_DIP_LIMIT = 3.0
"""The same for the dip between two contacts that are connected."""


class _TouchedGroup(NamedTuple):
    """A group of touched taxels with all data that depend only on which taxels are touched.

    Attributes:
        name: Its identity.
        taxels: (k,) touched taxels and ring, increasing.
        inside: (c,) indices into ``taxels`` of the touched ones.
        areas: (k,) areas [m²].
        area: Sum over the touched ones [m²].
        weights: (k,) weights of their readings in the centre: areas, or pixels.
        share: (k,) share of the group in their readings; None where it shares none with another group.
        points: (k, 2) their places on the map [m].
        body: (k, 3) their places on the body [m], link frame.
        patch: Number of the patch; a region is on one patch, because neighbours are.
        torn: Whether a seam tears it apart on the map.
        row: (r,) taxels around these, some of which may belong to other groups.
        passed: (k,) force that passes beyond the ring by crosstalk, for one unit of each reading [m²]; None without it.
    """

    name: TrackId
    taxels: IntArray
    inside: IntArray
    areas: FloatArray
    area: float
    weights: FloatArray
    share: FloatArray | None
    points: FloatArray
    body: FloatArray
    patch: int
    torn: bool
    row: IntArray
    passed: FloatArray | None


class ContactDetector:
    """Detector of contact regions, frame by frame. Mutable: it stores the touched taxels and the ids of regions.

    Regions are connected on the body (the skin's neighbours), so a seam never splits one. The untouched ring around a
    region is added before summing: 8 to 20 % of the force is below the threshold there. Pressed taxels connected to the
    ring are added too, see ``unpressed_readings``: a flat object at rest may press most of its taxels below the
    threshold. A ring taxel between regions is shared evenly among them. The force that crosstalk passes beyond the ring
    follows from the readings and is added to that of the region. A reading that is not finite counts as unpressed.

    Args:
        map_: The tactile map.
        threshold: Pressure from which a taxel is touched [Pa], > 0; it remains touched down to half of that. One for
            all, or (taxels,).
        errors: Uncertainty of the readings, for error bars; may be set at any time. By default no error is stated, and
            the noise is estimated from each frame to decide which taxels beyond the ring are pressed.
        centre: Settings for the centre of a region.

    Attributes:
        separates: Whether connected contacts are separated.

    Cost: 2 µs without contact, otherwise 50 µs a contact, and 40 µs more when the set of touched taxels changes. Both
        grow by only 1 ns for each taxel of the skin. With all of 1000 taxels touched, 0.4 ms, and 1 ms when the set
        changes. A held sample of a slow skin is processed once and costs nothing from its third tick on. Estimating
        the noise, where it is not stated, takes 60 µs more for 1000 taxels while something is touched.
    """

    def __init__(
        self,
        map_: TactileMap,
        *,
        threshold: float | FloatArray = TOUCH_THRESHOLD,
        errors: SensorUncertainty = _UNSTATED,
        centre: CentreSettings = _FROM_TAXELS,
    ) -> None:
        self._since: float | None = None  # when the offsets began to drift [s]
        self._held: FloatArray | None = None  # a read-only reading that is unchanged, and its result
        self._found: tuple[ContactRegion, ...] = ()
        self._errors = errors
        self._skin = map_.skin
        self._set_crosstalk(errors.effects.crosstalk)
        self._areas = map_.skin.areas
        self._body = map_.skin.positions
        self._memory = TrackMemory(map_.skin, self._body)
        self._graph = TaxelGraph(map_.skin)
        self._unpressed = UnpressedTaxels(map_.skin)
        self._close = CloseContactSeparator(self._graph.near)
        self.separates = True
        self._measure_dips()
        self._tracker = RegionTracker(self._memory)
        self._projector = BackProjector(map_, self._body)
        self._touched: IntArray = np.zeros(0, dtype=np.int64)
        self._centre = centre
        self.threshold = threshold
        self.use(map_)
        self.reset()

    @property
    def errors(self) -> SensorUncertainty:
        """Uncertainty of the readings."""
        return self._errors

    @errors.setter
    def errors(self, errors: SensorUncertainty) -> None:
        if errors.effects.offset_drift != self._errors.effects.offset_drift:
            self._since = None
        if errors.effects.crosstalk != self._errors.effects.crosstalk:
            self._set_crosstalk(errors.effects.crosstalk)
        self._errors = errors
        self._errors_now = errors
        self._held = None
        self._measure_dips()

    def _measure_dips(self) -> None:
        """Compute the dips (taxels,) between close contacts that noise rarely exceeds [Pa].

        ``_noise`` is for readings. ``_dips`` is for smoothed readings, None for noise that was not measured.
        """
        errors = self._errors
        measured = None if errors.taxels is None else errors.taxels.limits(_DIP_LIMIT)
        self._noise = np.full(len(self._skin), _DIP_LIMIT * errors.noise) if measured is None else measured
        self._dips = None if measured is None else self._close.smoothed_noise(measured)

    @property
    def errors_now(self) -> SensorUncertainty:
        """Uncertainty of the last reading: ``errors`` with the time that offsets have drifted since they were drawn."""
        return self._errors_now

    def _set_crosstalk(self, crosstalk: Crosstalk | None) -> None:
        self._exchange = None if crosstalk is None else crosstalk_matrix(self._skin, crosstalk.share).T.tocsr()
        self._seen = b""

    @property
    def threshold(self) -> float | FloatArray:
        """Pressure from which a taxel is touched [Pa]. Touched taxels remain touched down to half of it.

        Raises:
            MapError: It is not positive.
        """
        return self._threshold

    @threshold.setter
    def threshold(self, threshold: float | FloatArray) -> None:
        thresholds = np.broadcast_to(np.asarray(threshold, dtype=np.float64), len(self._skin))
        bad = thresholds[~((thresholds > 0) & (thresholds < np.inf))]
        if len(bad):
            raise MapError(
                "the contact threshold must be positive", value=f"{bad[0]} Pa", remedy="Choose more than 0 Pa"
            )
        self._threshold = threshold
        self._thresholds = thresholds
        self._level()

    def _level(self) -> None:
        """Update the pressure from which each taxel is touched [Pa]."""
        self._levels = self._thresholds.copy()
        self._levels[self._touched] *= _RELEASE
        self._held = None

    @property
    def centre(self) -> CentreSettings:
        """Settings for the centre of a region."""
        return self._centre

    @centre.setter
    def centre(self, centre: CentreSettings) -> None:
        self._centre = centre
        self._moments = taxel_moments(self._map, centre)
        self._projector.by_taxels = centre.back_projection == "three-taxels"
        self._seen = b""
        self._held = None

    def use(self, map_: TactileMap) -> None:
        """Use another map of the same skin; contacts continue. Cost: 0.2 ms."""
        self._map = map_
        self._seams = SeamCrossings(map_, self._body)
        self._projector.use(map_)
        self.centre = self._centre

    def reset(self) -> None:
        """Forget all contacts; ids start at 1 again."""
        self._touched = np.zeros(0, dtype=np.int64)
        self._strongest = np.zeros(len(self._skin))
        self._level()
        self._tracker.reset()
        self._seen = b""
        self._felt: list[_TouchedGroup] = []
        self._groups: list[TaxelGroup] = []
        self._covered: BoolArray = np.zeros(len(self._skin), dtype=bool)  # taxels of these groups
        self._beyond = b""  # pressed taxels outside them
        self._unpressed.reset()
        self._faces: dict[int, int] = {}  # by region, the triangle that held its centre
        self._since = None
        self._errors_now = self._errors
        self._motions: dict[int, Motion] = {}
        self._sample: FloatArray | None = None
        self._estimated: FloatArray | None = None

    def rescale(self, factors: FloatArray) -> None:
        """Multiply the remembered readings by ``factors`` (taxels,), because readings have another unit from now on."""
        self._strongest = self._strongest * factors

    def wait(self, *, period: float = 0.0, gaps: bool = False) -> None:
        """Let contacts that come back soon keep their id.

        Args:
            period: Period of the skin's samples [s]; 0 if each tick has a new one.
            gaps: Whether there are gaps without sensing between the taxels.
        """
        self._memory.waits = True
        self._memory.period = period
        self._memory.gaps = gaps

    def may_return(self, time: float) -> Mapping[int, str]:
        """Return the ids of contacts that are lost at ``time`` [s] and may come back, with their links."""
        return self._memory.may_return(time)

    def read(
        self, pressures: FloatArray, *, time: float = 0.0, estimated: FloatArray | None = None
    ) -> tuple[ContactRegion, ...]:
        """Return the contact regions, strongest first.

        Args:
            pressures: (taxels,) readings [Pa].
            time: Present time [s], increasing; used for contacts that come back.
            estimated: (taxels,) standard uncertainty of the readings that are estimated, 0 for others [Pa]; None where
                broken taxels are unknown.
        """
        if pressures is self._held:
            return self._found
        given = pressures
        self._begin(given, time)
        self._estimated = estimated
        if not math.isfinite(dot(pressures, self._areas)):
            pressures = np.where(np.isfinite(pressures), pressures, 0.0)
        touched = pressures >= self._levels
        if self._errors.taxels is not None:
            touched &= self._exceeds_creep(pressures)
        mask = touched.tobytes()
        same = mask == self._seen
        if same:  # same taxels: merges and splits were reported before
            self._felt = [felt._replace(name=TrackId(felt.name.id)) for felt in self._felt]
        else:
            self._seen = mask
            self._look(touched.nonzero()[0], pressures, time)
        self._unpressed.observe(self._errors.effects.hysteresis, pressures, time)
        if self._felt:
            same &= self._extend(pressures)
        regions = [self._region(felt, pressures) for felt in self._felt]
        self._faces = {region.id: region.at.face for region in regions}
        if len(regions) > 1:
            measured = ((region.id, Measured(region.link_position, region.force)) for region in regions)
            self._tracker.motions.observe(time, measured)
        self._motions = {region.id: self._motions[region.id] for region in regions if region.id in self._motions}
        self._found = tuple(sorted(regions, key=lambda region: (-region.force, region.id)))
        self._held = given if same and not given.flags.writeable and given.base is None else None
        return self._found

    def _exceeds_creep(self, pressures: FloatArray) -> BoolArray:
        """Return whether each reading (taxels,) exceeds what creep leaves of the strongest one since it was at rest."""
        self._strongest = np.where(pressures < _RELEASE * self._thresholds, 0.0, np.maximum(self._strongest, pressures))
        return np.asarray(pressures >= _AFTER * self._strongest)

    def _begin(self, given: FloatArray, time: float) -> None:
        """Bring the uncertainty up to ``time`` [s], and note whether ``given`` is another sample than before."""
        errors = self._errors
        self._new = given is not self._sample
        self._sample = given
        self._time = time
        if errors.effects.offset_drift is not None:
            self._since = time if self._since is None else self._since
            errors = replace(errors, elapsed=max(time - self._since, 0.0))
        self._errors_now = errors

    def _follow(self, region: int, force: float, position: FloatArray) -> Motion | None:
        """Return the motion of a region, where readings are old enough for it to count."""
        if not self._errors.lag:
            return None
        motion = self._motions.get(region)
        if motion is None:
            motion = Motion.begin(self._time, force, position, self._errors.lag)
        elif self._new and self._time > motion.time:
            motion = motion.next(self._time, force, position)
        self._motions[region] = motion
        return motion

    def _look(self, touched: IntArray, pressures: FloatArray, time: float) -> None:
        """Group the ``touched`` taxels (t,) and identify the groups."""
        groups = self._graph.groups(touched.tolist())
        if groups and self._may_be_noise:
            touched, groups = self._believed(touched, groups, pressures)
        connected = groups
        if groups and self.separates and self._dips is not None:
            self._seen = b""  # search again, even if the same taxels are touched
            groups = self._close.separated(groups, pressures, self._dips)
        if len(connected) > 1:
            groups = self._united(groups, connected, pressures)
        self._touched = touched
        self._level()
        names = self._tracker.assign(groups, now=time, measure=lambda parts: self._measured(parts, pressures))
        self._felt = self._touched_groups(names, groups)
        self._groups = groups
        self._covered = np.zeros(len(self._skin), dtype=bool)
        for felt in self._felt:
            self._covered[felt.taxels] = True
        self._beyond = b""

    def _united(
        self, groups: list[TaxelGroup], connected: Sequence[TaxelGroup], pressures: FloatArray
    ) -> list[TaxelGroup]:
        """Return the groups, where parts of one contact that may not be separate are one group."""
        owner = {taxel: number for number, group in enumerate(connected) for taxel in group.core}
        names = [(owner[min(group.core)], self._tracker.contact_of(group)) for group in groups]
        if len({contact for _, contact in names}) == len(names):
            return groups
        self._seen = b""  # search again, even if the same taxels are touched
        threshold = self._errors.effects.threshold
        readings = pressures if threshold is None else np.maximum(pressures, threshold.at)
        return self._close.united(groups, names, readings, self._noise)

    def _extend(self, pressures: FloatArray) -> bool:
        """Add pressed taxels that are connected to the rings of groups; return whether nothing changed."""
        found = self._unpressed.readings(self._errors_now, self._thresholds, pressures, self._covered)
        if self._errors.taxels is not None:
            found = found._replace(rest=found.rest + _AFTER * self._strongest)
        if found.deviation is not None:
            self._errors_now = replace(self._errors_now, noise=found.deviation)
        self._rest = found
        pressed = found.exceeded(pressures)
        outside = pressed & ~self._covered
        beyond = outside.tobytes() if outside.any() else b""
        if beyond == self._beyond:
            return True
        self._beyond = beyond
        groups = self._graph.extended(self._groups, set(pressed.nonzero()[0].tolist())) if beyond else self._groups
        self._felt = self._touched_groups([felt.name for felt in self._felt], groups)
        return False

    def _measured(self, groups: Sequence[TaxelGroup], pressures: FloatArray) -> list[Measured]:
        """Return the centre and force of each group."""
        members = _taxels_of(groups)
        found = []
        for taxels, share in zip(members, ring_shares(members), strict=True):
            own = shared_readings(pressures, taxels, share)
            forces = np.maximum(own.take(taxels), 0.0) * self._areas.take(taxels)
            force = float(forces.sum())
            found.append(Measured(forces @ self._body.take(taxels, axis=0) / force, force))
        return found

    @property
    def _may_be_noise(self) -> bool:
        errors = self._errors
        return errors.taxels is not None or bool((self._thresholds < NOISE_LIMIT * errors.noise).any())

    def _believed(
        self, touched: IntArray, groups: list[TaxelGroup], pressures: FloatArray
    ) -> tuple[IntArray, list[TaxelGroup]]:
        """Return the groups that exceed the noise: one taxel in 700 reads three deviations of it.

        A group that has half of the taxels of a region before stays without that. Two thirds as much are enough for
        other groups of taxels that were touched before. Without that limit, the taxels of a contact that has just ended
        would be contacts of their own for one frame: one in 15 reads 1.5 deviations, half its threshold.
        """
        known = frozenset(self._touched.tolist())
        before = [frozenset(felt.taxels.take(felt.inside).tolist()) for felt in self._felt]
        kept = []
        for group in groups:
            core = np.array(sorted(group.core))
            areas = self._areas.take(core)
            share = 1.0 if known.isdisjoint(group.core) else _HELD
            stays = any(2 * len(region & group.core) >= len(region) for region in before)
            if stays or self._exceeds_noise(pressures.take(core) * areas / share, core, areas):
                kept.append(group)
        if len(kept) < len(groups):
            self._seen = b""  # search again, even if the same taxels are touched
            touched = np.array(sorted(taxel for group in kept for taxel in group.core), dtype=np.int64)
        return touched, kept

    def _exceeds_noise(self, forces: FloatArray, core: IntArray, areas: FloatArray) -> bool:
        """Whether the forces (k,) [N] on the touched taxels ``core`` (k,) with their areas (k,) [m²] are not noise."""
        if self.errors.taxels is not None:
            return self.errors.taxels.exceeded(NOISE_LIMIT, forces, core, areas)
        return float(forces.sum()) >= NOISE_LIMIT * self.errors.noise * math.sqrt(float(areas @ areas))

    def _touched_groups(self, names: Sequence[TrackId], groups: Sequence[TaxelGroup]) -> list[_TouchedGroup]:
        members = _taxels_of(groups)
        return [self._touched_group(*one) for one in zip(names, groups, members, ring_shares(members), strict=True)]

    def _touched_group(
        self, name: TrackId, group: TaxelGroup, taxels: IntArray, share: FloatArray | None
    ) -> _TouchedGroup:
        taxels.flags.writeable = False
        whole = taxels.tolist()
        inside = np.array([place for place, taxel in enumerate(whole) if taxel in group.core], dtype=np.int64)
        areas = self._areas.take(taxels)
        area = float(areas.take(inside).sum())
        torn = self._seams.tear(group.core | group.ring)
        body = self._body.take(taxels, axis=0)
        patch = int(self._skin.patch_of[whole[0]])
        weights = areas if self._centre.pixel is None else self._moments.weights.take(taxels)
        points = self._moments.points.take(taxels, axis=0)
        around = frozenset[int]().union(*[self._graph.near[taxel] for taxel in group.ring]).difference(whole)
        row = np.array(sorted(around), dtype=np.int64)
        passed = self._passed_beyond(taxels)
        return _TouchedGroup(name, taxels, inside, areas, area, weights, share, points, body, patch, torn, row, passed)

    def _passed_beyond(self, taxels: IntArray) -> FloatArray | None:
        """Return the force that a contact on ``taxels`` (k,) passes to other taxels, for one unit of each reading [m²].

        Readings y = S p of pressures p, S being the exchange among the taxels themselves, conserve force except for
        what passes beyond: a - S'a for one unit of each pressure, a being the areas. For one unit of each reading it is
        the solution w of S'w = a - S'a, by Richardson's iteration.
        """
        if self._exchange is None:
            return None
        inside = np.zeros(len(self._skin))
        inside[taxels] = 1.0
        lost = inside * (self._areas - self._exchange @ (inside * self._areas))
        passed = lost
        for _ in range(_ITERATIONS):
            passed = passed + lost - inside * (self._exchange @ passed)
        return np.asarray(passed[taxels])

    def _region(self, felt: _TouchedGroup, pressures: FloatArray) -> ContactRegion:
        own = pressures.take(felt.taxels)
        if felt.share is not None:
            own = own * felt.share
        forces, force, borne = _forces(felt, own)
        share = forces / force
        if felt.passed is not None:
            force += max(dot(felt.passed, own), 0.0)
        place = self._place(felt, share)
        offsets = felt.body - place.link_position
        motion = self._follow(felt.name.id, force, place.link_position)
        errors = propagate_uncertainty(
            self._errors_now,
            Readings(
                forces, felt.areas, felt.taxels, felt.inside, self._left_out(felt, pressures), self._deviations(felt)
            ),
            np.einsum("ij,ij->i", offsets, offsets),
            motion=motion,
        )
        axes, map_axes = principal_axes(offsets, share, _own_spread(share, felt.areas), place)
        seal(place.map_point, place.link_position, place.link_normal, axes, map_axes)
        return ContactRegion(
            id=felt.name.id,
            taxels=felt.taxels,
            force=force,
            area=felt.area,
            peak=float(own.take(felt.inside).max()),
            map_point=place.map_point,
            at=place.at,
            link=self._skin.patches[felt.patch].link,
            link_position=place.link_position,
            link_normal=place.link_normal,
            torn=place.torn,
            mean=borne / felt.area,
            touched=len(felt.inside),
            link_axes=axes,
            map_axes=map_axes,
            place_error=errors.place,
            force_error=errors.force,
            force_parts=errors.parts,
            force_limits=errors.limits,
            merged=felt.name.merged,
            split_from=felt.name.split_from,
        )

    def _left_out(self, felt: _TouchedGroup, pressures: FloatArray) -> LeftOut:
        """Return the force on the row of taxels around a group."""
        row = felt.row[~self._covered.take(felt.row)]
        return self._rest.row_force(pressures, row, self._areas.take(row))

    def _deviations(self, felt: _TouchedGroup) -> FloatArray | None:
        """Return the standard uncertainties (k,) of the forces on estimated taxels [N]."""
        return None if self._estimated is None else self._estimated.take(felt.taxels) * felt.areas

    def _place(self, felt: _TouchedGroup, share: FloatArray) -> ContactLocation:
        """Return the centre of pressure, computed on the map and projected back by the containing triangle.

        On the map it remains on the surface; a mean in space is below it (by 0.5 mm at 10 mm half-width on a 36 mm
        tube). If a seam tears the region apart on the map, the mean in space is used and projected to the skin.
        """
        if not felt.torn:
            if felt.weights is not felt.areas:
                share = _share_of_pixels(felt, share)
            near = self._faces.get(felt.name.id)
            if near is None:
                near = self._projector.face_of(int(felt.taxels[int(share.argmax())]))
            place = self._projector.place(felt.patch, share.dot(felt.points), near=near)
            if place is not None:
                return place
        return self._projector.put_back(felt.patch, share.dot(felt.body))


def _taxels_of(groups: Sequence[TaxelGroup]) -> list[IntArray]:
    """Return the taxels and ring taxels (k,) of each group, increasing."""
    return [np.array(sorted(group.core | group.ring), dtype=np.int64) for group in groups]


def _share_of_pixels(felt: _TouchedGroup, share: FloatArray) -> FloatArray:
    """Return the share of each taxel (k,) in the sum over pixels; its share of the force if no pixel shows any."""
    pixels = share * felt.weights / felt.areas
    total = float(pixels.sum())
    return pixels / total if total > 0 else share


def _own_spread(share: FloatArray, areas: FloatArray) -> float:
    """Return the mean variance of a taxel's own area along one axis [m²], that of a square, weighted by force.

    Noise may make the reading of a ring taxel negative, and so the weighted mean; negative weights are therefore 0.
    """
    pressed = np.maximum(share, 0.0)
    return dot(pressed, areas) / (12.0 * float(pressed.sum()))


def _forces(felt: _TouchedGroup, own: FloatArray) -> tuple[FloatArray, float, float]:
    """Return the forces (k,) of readings ``own`` (k,) [Pa], their sum, and their sum over the touched taxels [N]."""
    forces = own * felt.areas
    touched = forces.take(felt.inside)
    force = float(forces.sum())
    borne = float(touched.sum())
    if force < _DROWNED * borne:
        forces = np.zeros(len(forces))
        forces[felt.inside] = touched
        force = float(forces.sum())
    return forces, force, borne
