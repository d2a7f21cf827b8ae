"""The contact pipeline: from the pressures of one tick to contact regions, self-touch and events.

``ReadingSettings`` contains the pressure threshold of a touched taxel and the force estimator. ``ContactPipeline`` runs
detection, force estimation, self-touch and events in that order. ``read_contacts`` reads contacts once, without
history.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD, ContactDetector
from tactile_maps.contacts.detection.filled_readings import BlindArea, FilledReadings, MissingReadings
from tactile_maps.contacts.detection.image_centre import BACK_PROJECTIONS, PIXELS, BackProjection, CentreSettings
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.detection.shear_estimation import ShearEstimator
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.events import ContactEvent, EventDetector
from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS, EstimatorName, ForceEstimate
from tactile_maps.contacts.force_estimation.estimation import FORCE_ESTIMATORS, RegionForceEstimator
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.contacts.self_touch import SelfTouchMatcher
from tactile_maps.core.arrays import BoolArray, FloatArray, set_fields
from tactile_maps.core.codec import LATER
from tactile_maps.core.errors import MapError, SceneError, check_range
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.toml import check_keys
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import Skin, number_ranges
from tactile_maps.tactile.mechanics.receptive_field import pad_displacements
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

ABOVE_NOISE = 3.0
"""Default threshold in standard deviations of the noise of a reading."""
THRESHOLDS = (1.0, 1e11)
"""Smallest and largest selectable threshold [Pa]; a count is shown as 1 kPa, and converters have up to 24 bits."""
NOISE_FACTORS = (1.0, 100.0)
"""Smallest and largest selectable threshold in standard deviations of the noise."""
NOISIEST_SENSOR = 10.0
"""Largest selectable noise of a force-torque sensor [N]."""
BrokenTaxels = Literal["estimated", "as-read"]
"""Treatment of known broken taxels."""
CloseContacts = Literal["separate", "joined"]
"""Treatment of contacts whose touched taxels are connected."""


@dataclass(frozen=True)
class ReadingSettings:
    """Settings of a scene, user or recording for reading contacts.

    Attributes:
        estimator: Name of the force estimator.
        threshold: Pressure from which a taxel is touched [Pa]; None for 1 kPa or ``above_noise``, whichever is larger.
            In either case a new contact as a whole must exceed the noise of its taxels.
        wrench_noise: Standard deviation of each force that the force-torque sensor of ``lumped`` reports [N], and 2 cm
            times as much of each torque. 0 is a perfect one; an ATI Mini45 (SI-145-5) resolves 1/16 N and 1/752 N m.
        pixel: Pixel size of the tactile image from which the centre of a contact is computed [m on the map]; None
            computes it from the taxels.
        interpolation: Interpolation of that image.
        back_projection: Method from a centre on the map to the body; see ``image_centre``.
        broken_taxels: Whether the readings of known broken taxels are estimated from their neighbours, see
            ``filled_readings``, or used unchanged.
        above_noise: Threshold in standard deviations of the noise of a reading, where ``threshold`` is None.
        close_contacts: Whether contacts whose touched taxels are connected are separated by the dip between them, see
            ``close_contacts``, or are one contact. They are separated only where a tare measured the noise.

    Raises:
        SceneError: A setting is unknown or out of range; the error states the valid ones.
    """

    estimator: EstimatorName = "area-sum"
    threshold: float | None = None
    wrench_noise: float = 0.0
    pixel: float | None = field(default=None, metadata=LATER)
    interpolation: str = field(default="barycentric", metadata=LATER)
    back_projection: BackProjection = field(default="triangle", metadata=LATER)
    broken_taxels: BrokenTaxels = field(default="estimated", metadata=LATER)
    above_noise: float = field(default=ABOVE_NOISE, metadata=LATER)
    close_contacts: CloseContacts = field(default="separate", metadata=LATER)

    def __post_init__(self) -> None:
        if self.estimator not in FORCE_ESTIMATORS:
            raise SceneError(
                "unknown force estimator",
                place="contacts.estimator",
                value=self.estimator,
                remedy=FORCE_ESTIMATORS.remedy(str(self.estimator)),
            )
        if self.threshold is not None:
            self._check("threshold", *THRESHOLDS, unit="Pa")
        self._check("wrench_noise", 0.0, NOISIEST_SENSOR, unit="N")
        self._check("above_noise", *NOISE_FACTORS, unit="times the noise")
        if self.pixel is not None:
            self._check("pixel", *PIXELS, unit="m")
        for name, problem, allowed in (
            ("interpolation", "unknown interpolation for the centre of a contact", tuple(INTERPOLATIONS)),
            ("back_projection", "unknown back projection for the centre of a contact", BACK_PROJECTIONS),
            ("broken_taxels", "unknown treatment of broken taxels", get_args(BrokenTaxels)),
            ("close_contacts", "unknown treatment of close contacts", get_args(CloseContacts)),
        ):
            if (value := getattr(self, name)) not in allowed:
                remedy = f"Choose one of: {', '.join(allowed)}"
                raise SceneError(problem, place=f"contacts.{name}", value=value, remedy=remedy)

    def _check(self, name: str, low: float, high: float, *, unit: str) -> None:
        value = getattr(self, name)
        check_range("a contact setting", value, low, high, error=SceneError, place=f"contacts.{name}", unit=unit)
        set_fields(self, **{name: float(value)})

    @property
    def centre(self) -> CentreSettings:
        """Settings for the centre of a contact."""
        return CentreSettings(self.pixel, self.interpolation, self.back_projection)

    def threshold_for(self, errors: SensorUncertainty) -> float:
        """Return the threshold for readings with this uncertainty [Pa].

        A threshold set by the user is used whatever the noise. Theory uses max(3 sigma, a tenth of the peak). The tenth
        is left out: it separates one contact from a whole image, and a firm contact would hide a light one next to it.
        Its purpose, to keep the cover's blur out of the inversion, is served by the region with its one ring.
        """
        return self.threshold if self.threshold is not None else max(TOUCH_THRESHOLD, self.above_noise * errors.noise)

    def thresholds_for(self, errors: SensorUncertainty) -> float | FloatArray:
        """Return the threshold of each taxel (taxels,) [Pa] if their noise was measured, otherwise one for all."""
        if self.threshold is not None or errors.taxels is None:
            return self.threshold_for(errors)
        limits = errors.taxels.limits(ABOVE_NOISE)
        return np.maximum(TOUCH_THRESHOLD, self.above_noise / ABOVE_NOISE * limits)


def reading_from(values: Mapping[str, object]) -> ReadingSettings:
    """Return the settings of a scene's table.

    Raises:
        SceneError: A key is unknown, or a value is invalid.
    """
    check_keys(values, ReadingSettings, place="contacts")
    return ReadingSettings(**values)  # type: ignore[arg-type]


def reading_values(settings: ReadingSettings) -> dict[str, str | float]:
    """Return the settings that differ from the defaults, as a scene's table that ``reading_from`` reads."""
    default = ReadingSettings()
    values = {one.name: getattr(settings, one.name) for one in fields(settings)}
    return {name: value for name, value in values.items() if value != getattr(default, name)}


_USUAL = ReadingSettings()
_NONE: Mapping[str, FloatArray] = MappingProxyType({})


class ContactPipeline:
    """Reader of contacts, tick by tick. Mutable; ``reset`` discards the past.

    Args:
        robot: The robot; poses of its links determine self-touch.
        map_: Map of the skin. Its skin is the assumed one; the skin that is read needs the same taxels, but they may be
            at other places.
        sensor: Effects of the sensor, for the threshold and the uncertainty of regions.
        settings: Settings for reading contacts; may be set at any time.
        depth: Depth of the taxels below the cover's surface [m], for estimators that remove its blur.
        seed: Seed of a force-torque sensor's noise.
        friction: Coulomb coefficient of contacts, for their shear, until it was measured.

    Attributes:
        estimates: Results of the estimator at the last tick by region; empty with the area sum.

    Raises:
        MapError: The depth is out of range.
    """

    def __init__(
        self,
        robot: Robot,
        map_: TactileMap,
        sensor: SensorEffects,
        *,
        settings: ReadingSettings = _USUAL,
        depth: float = 0.002,
        seed: int = 0,
        friction: float = 0.5,
    ) -> None:
        self._skin = map_.skin
        self._map = map_
        self._friction = friction
        self._shear: ShearEstimator | None = None
        self._depth = depth
        self._settings = settings
        self._detector = ContactDetector(map_, centre=settings.centre)
        self._detector.separates = settings.close_contacts == "separate"
        self._forces = RegionForceEstimator(
            map_, estimator=settings.estimator, depth=depth, wrench_noise=settings.wrench_noise, seed=seed
        )
        self._self_touch = SelfTouchMatcher()
        self._events = EventDetector()
        self._missing = MissingReadings(map_.skin)
        self.set_sensor_model(sensor)
        # Self-touch needs skin on two links.
        several = len(map_.skin.links) > 1
        self._configuration = Configuration(robot) if several else None
        self._nothing = np.zeros(len(map_.skin))
        self.estimates: Mapping[int, ForceEstimate] = {}

    @property
    def settings(self) -> ReadingSettings:
        """Settings for reading contacts. A change keeps the ids of contacts."""
        return self._settings

    @settings.setter
    def settings(self, settings: ReadingSettings) -> None:
        self._forces.estimator = settings.estimator
        self._forces.wrench_noise = settings.wrench_noise
        self._settings = settings
        self._detector.separates = settings.close_contacts == "separate"
        self._detector.threshold = settings.thresholds_for(self._detector.errors)
        self._missing.forget()
        if settings.centre != self._detector.centre:
            self._detector.centre = settings.centre

    @property
    def threshold(self) -> float:
        """Lowest pressure that counts as touch [Pa]: the threshold of contacts, or of the sensor where it is higher."""
        errors = self._detector.errors
        of_sensor = errors.effects.threshold
        return max(self._settings.threshold_for(errors), of_sensor.at if of_sensor else 0.0)

    @property
    def thresholds(self) -> FloatArray:
        """(taxels,) pressure from which each taxel is touched [Pa]."""
        return np.broadcast_to(np.asarray(self._detector.threshold, dtype=np.float64), len(self._skin))

    @property
    def needs_wrenches(self) -> bool:
        """Whether ``read`` needs the contact wrenches on links."""
        return self._settings.estimator == "lumped"

    def use(self, map_: TactileMap) -> None:
        """Place contacts by another map of the same skin from now on. Cost: 0.2 ms."""
        self._detector.use(map_)
        self._forces.use(map_)
        self._map = map_
        if self._shear is not None:
            self._shear.use(map_)

    def set_sensor_model(self, sensor: SensorEffects, *, averaged: float = 0.0, model: str = "") -> None:
        """Set the sensor model, which determines error bars and the threshold above its noise.

        Args:
            sensor: Effects of the sensor.
            averaged: Tick whose mean a reading is [s]; 0 for readings of an instant.
            model: Contact model that the readings come from.
        """
        errors = SensorUncertainty.of_sensor(sensor, averaged=averaged, model=model)
        if sensor.area_averaging is not None:
            errors = replace(errors, displaced=pad_displacements(self._skin, sensor.area_averaging.radius))
        self._detector.errors = replace(errors, depth=self._depth) if model == "half-space" else errors
        self._detector.threshold = self._settings.thresholds_for(self._detector.errors)
        self._missing.forget()
        gaps = sensor.area_averaging is not None or sensor.dead_taxels is not None
        self._detector.wait(period=1 / sensor.sampling.rate if sensor.sampling else 0.0, gaps=gaps)

    def set_measured_noise(self, noise: TaxelNoise | None) -> None:
        """Use the measured noise of each taxel for thresholds and error bars from now on; None for unknown noise."""
        self._detector.errors = SensorUncertainty.measured(noise)
        self._detector.threshold = self._settings.thresholds_for(self._detector.errors)
        self._missing.forget()

    def set_broken_taxels(self, broken: BoolArray) -> None:
        """Estimate the readings of these ``broken`` (taxels,) from their neighbours from now on; see ``TaxelFill``."""
        self._missing.set_broken(broken)

    @property
    def blind(self) -> tuple[BlindArea, ...]:
        """Areas of taxels that are broken, or did not report at the last tick, whose readings cannot be estimated."""
        return () if self._settings.broken_taxels == "as-read" else self._missing.blind

    def _estimated(self, pressures: FloatArray) -> FilledReadings | None:
        """Return the readings with estimates; None where none is needed or none is requested."""
        if self._settings.broken_taxels == "as-read":
            return None
        return _with_estimates(self._missing, pressures, self._detector)

    def use_units(self, units: ReadingUnits) -> None:
        """Set the units of readings: without a unit of force, events have no forces."""
        self._events.claims_force = units.force is not None

    def rescale(self, factors: FloatArray) -> None:
        """Continue the contacts in readings of another unit or calibration.

        Args:
            factors: (taxels,) by which equal pressures read more from now on; 0 where earlier readings say nothing.
        """
        self._detector.rescale(factors)
        self._events.forget_forces()
        self._shear = None

    def reset(self) -> None:
        """Forget all contacts and events; ids start at 1 again."""
        self._detector.reset()
        self._forces.reset()
        self._self_touch.reset()
        self._shear = None
        self._events.reset()
        self.estimates = {}

    def read(
        self,
        tick: int,
        time: float,
        posture: FloatArray,
        pressures: FloatArray | None,
        *,
        wrenches: Mapping[str, FloatArray] = _NONE,
        shear: FloatArray | None = None,
    ) -> tuple[ContactRegion, ...]:
        """Return the contact regions of a tick, strongest first; their events are in ``recent``.

        Args:
            tick: Tick of the frame, increasing.
            time: Its time [s].
            posture: (joints,) posture of the robot.
            pressures: (taxels,) readings [Pa]; None without a simulated skin, which counts as untouched. NaN for a
                taxel that did not report, whose reading is estimated from its neighbours. Without an estimate
                (``blind`` areas, or ``as-read``), it and infinite readings count as unpressed.
            wrenches: Contact wrench on each link: (6,) force [N] and torque [N m] about its origin, in its frame.
                Required if ``needs_wrenches``.
            shear: (taxels, 2) tractions along t1 and t2 of each taxel [Pa]; None for a skin that measures one axis.

        Cost: that of ``ContactDetector``, 3 µs a contact, 60 µs more with shear, 30 µs while two links are touched, and
            that of the estimator unless it is the area sum.
        """
        pressures = self._nothing if pressures is None else pressures
        filled = self._estimated(pressures)
        pressures = pressures if filled is None else filled.pressures
        if not np.isfinite(pressures).all():
            pressures = np.where(np.isfinite(pressures), pressures, 0.0)
        regions = self._detector.read(pressures, time=time, estimated=None if filled is None else filled.sd)
        regions, self.estimates = self._forces.read(
            regions, pressures, self._detector.errors_now, wrenches, awaited=self._detector.may_return(time)
        )
        if self._configuration is not None:
            if len({region.link for region in regions}) > 1:
                self._configuration.update(posture)
            regions = self._self_touch.link(regions, self._configuration.pose)
        if shear is not None:
            if self._shear is None:
                self._shear = ShearEstimator(self._map, self._friction)
            self._shear.noise = self._detector.errors.noise
            self._shear.axis_errors = self._detector.errors.effects.axis_errors
            regions = self._shear.read(time, regions, pressures, shear)
        self._events.read(tick, time, regions, awaited=self._forces.awaited)
        return regions

    @property
    def mismatch(self) -> WrenchMismatch | None:
        """Touches of a link of which none explains its wrench, at the last tick; None unless ``lumped``."""
        return self._forces.mismatch

    @property
    def touched(self) -> bool:
        """Whether any contact has not been released yet: a slow skin may miss one in a sample."""
        return self._events.touched

    @property
    def recent(self) -> tuple[ContactEvent, ...]:
        """The newest events, newest first; see ``EventDetector``."""
        return self._events.recent


def read_contacts(
    map_: TactileMap,
    pressures: FloatArray,
    *,
    threshold: float | None = None,
    estimator: EstimatorName = "area-sum",
    depth: float = 0.002,
    errors: SensorUncertainty | None = None,
) -> tuple[ContactRegion, ...]:
    """Return the contacts in one reading of a skin, without history. Use ``ContactPipeline`` for a stream.

    Args:
        map_: Map of the skin.
        pressures: (taxels,) readings [Pa]; NaN for a taxel that did not report, whose reading is estimated from its
            neighbours; ``force_parts["dead_taxels"]`` of contacts there is the uncertainty of the estimate.
        threshold: Pressure from which a taxel is touched [Pa]; by default 1 kPa or ``ABOVE_NOISE``, whichever is
            larger.
        estimator: Name of the force estimator, except ``lumped``, which reads another sensor.
        depth: Depth of the taxels below the cover's surface [m], for estimators that remove its blur.
        errors: Uncertainty of the readings, for the error bars; exact by default.

    Returns:
        Contact regions, strongest first; ``map_point`` is on the map, ``link_position`` and ``link_normal`` are in the
        frame of ``link``.

    Raises:
        MapError: Not one pressure for each taxel, a pressure is infinite, taxels that did not report have too few
            neighbours for an estimate, or the estimator is ``lumped``.
        SceneError: Unknown estimator, or threshold out of range.

    Example:
        >>> pressures = tm.press_skin(skin, skin.taxel_point(30), force=3.0)
        >>> for contact in tm.read_contacts(tactile_map, pressures):
        ...     print(f"{contact.force:.2f} N on {contact.link}")
        3.00 N on hand

    Cost: 10 ms for 1000 taxels; an estimator that removes the blur 0.2 s.
    """
    if estimator == "lumped":
        remedy = f"Choose one of: {', '.join(name for name in ESTIMATORS if name != 'lumped')}"
        raise MapError("a force-torque sensor is not read from pressures", value=estimator, remedy=remedy)
    settings = ReadingSettings(estimator, threshold)
    errors = errors or SensorUncertainty()
    detector = ContactDetector(map_, threshold=settings.thresholds_for(errors), errors=errors)
    forces = RegionForceEstimator(map_, estimator=estimator, depth=depth)
    pressures, estimated = _complete_readings(map_.skin, np.asarray(pressures, dtype=np.float64), detector)
    return forces.read(detector.read(pressures, estimated=estimated), pressures, errors)[0]


def _complete_readings(
    skin: Skin, pressures: FloatArray, detector: ContactDetector
) -> tuple[FloatArray, FloatArray | None]:
    """Return the readings with estimates for missing ones, and the uncertainties of the estimates, if there are any.

    Raises:
        MapError: Not one pressure for each taxel, a pressure is infinite, or a missing one cannot be estimated.
    """
    if pressures.shape != (len(skin),):
        remedy = f"Give one number for each of the {len(skin)} taxels"
        raise MapError("the pressures do not fit this skin", value=f"shape {pressures.shape}", remedy=remedy)
    infinite = np.flatnonzero(np.isinf(pressures))
    if len(infinite):
        place = f"taxel {infinite[0]}"
        remedy = "Use NaN for a taxel that did not report"
        raise MapError("a pressure is infinite", place=place, value=pressures[infinite[0]], remedy=remedy)
    missing = MissingReadings(skin)
    filled = _with_estimates(missing, pressures, detector)
    if missing.blind:
        area = missing.blind[0]
        raise MapError(
            "taxels that did not report have too few neighbours for an estimate",
            place=f"on {area.link}",
            value=f"taxels {number_ranges(area.taxels)}",
            remedy="Read the skin again, or use 0 for taxels that count as untouched",
        )
    return (pressures, None) if filled is None else filled


def _with_estimates(
    missing: MissingReadings, pressures: FloatArray, detector: ContactDetector
) -> FilledReadings | None:
    """Return the readings with estimates for ``missing`` ones, with threshold and noise of the ``detector``."""
    errors = detector.errors
    noise = errors.noise if errors.taxels is None else errors.taxels.sd
    return missing.fill(pressures, threshold=detector.threshold, noise=noise)
