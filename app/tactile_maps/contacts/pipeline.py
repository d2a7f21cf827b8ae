"""The sense of touch as a whole: from one tick's pressures to contact regions, self-touch and events, as the settings
say.

``ReadingSettings`` say from which pressure on a taxel counts as touched, and which estimator leads to a force.
``ContactPipeline`` runs detection, force estimation, self-touch and events in that order; ``read_contacts`` reads
contacts once, without a past.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD, ContactDetector
from tactile_maps.contacts.detection.filled_readings import BlindArea, FilledReadings, TaxelFill
from tactile_maps.contacts.detection.image_centre import BACK_PROJECTIONS, PIXELS, BackProjection, CentreSettings
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.events import ContactEvent, EventDetector
from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS, EstimatorName, ForceEstimate
from tactile_maps.contacts.force_estimation.estimation import FORCE_ESTIMATORS, RegionForceEstimator
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.contacts.self_touch import SelfTouchMatcher
from tactile_maps.core.arrays import BoolArray, FloatArray, set_fields
from tactile_maps.core.codec import LATER
from tactile_maps.core.errors import MapError, SceneError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.toml import check_keys
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.tactile.mechanics.receptive_field import pad_displacements
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

ABOVE_NOISE = 3.0
"""Standard deviations of a reading's noise that the threshold is at least."""
THRESHOLDS = (1.0, 1e11)
"""Smallest and largest selectable threshold [Pa]; a count is shown as 1 kPa, and converters have up to 24 bits."""
NOISIEST_SENSOR = 10.0
"""Of a force-torque sensor [N]."""
BrokenTaxels = Literal["estimated", "as-read"]
"""Treatment of known broken taxels."""


@dataclass(frozen=True)
class ReadingSettings:
    """What a scene, a person or a recording may say of how contacts are read.

    Attributes:
        estimator: The way from readings to a contact's force.
        threshold: A taxel is touched from here [Pa]; None for 1 kPa, or what stands out of the noise if that is more.
            In either case a new contact as a whole must stand out of the noise of its taxels.
        wrench_noise: Standard deviation of each force that the force-torque sensor of ``lumped`` reports [N], and 2 cm
            times as much of each torque. 0 is a perfect one; an ATI Mini45 (SI-145-5) resolves 1/16 N and 1/752 N m.
        pixel: Of the tactile image whose pixels a contact's centre is taken from [m on the map]; None for none:
            straight from the taxels.
        interpolation: Of that image.
        back_projection: From a centre on the map to the body; see ``image_centre``.
        broken_taxels: Whether the readings of known broken taxels are estimated from their neighbours, see
            ``filled_readings``, or used as they are read.

    Raises:
        SceneError: Naming what is wrong, and what is allowed there.
    """

    estimator: EstimatorName = "area-sum"
    threshold: float | None = None
    wrench_noise: float = 0.0
    pixel: float | None = field(default=None, metadata=LATER)
    interpolation: str = field(default="barycentric", metadata=LATER)
    back_projection: BackProjection = field(default="triangle", metadata=LATER)
    broken_taxels: BrokenTaxels = field(default="estimated", metadata=LATER)

    def __post_init__(self) -> None:
        if self.estimator not in FORCE_ESTIMATORS:
            raise SceneError(
                "there is no such force estimator",
                place="contacts.estimator",
                value=self.estimator,
                remedy=FORCE_ESTIMATORS.remedy(str(self.estimator)),
            )
        if self.threshold is not None:
            self._check("threshold", *THRESHOLDS, unit="Pa")
        self._check("wrench_noise", 0.0, NOISIEST_SENSOR, unit="N")
        if self.pixel is not None:
            self._check("pixel", *PIXELS, unit="m")
        for name, allowed in (("interpolation", tuple(INTERPOLATIONS)), ("back_projection", BACK_PROJECTIONS)):
            if (value := getattr(self, name)) not in allowed:
                raise SceneError(
                    "there is no such way to find a contact's centre",
                    place=f"contacts.{name}",
                    value=value,
                    remedy=f"Choose one of: {', '.join(allowed)}",
                )

        if self.broken_taxels not in get_args(BrokenTaxels):
            raise SceneError(
                "unknown treatment of broken taxels",
                place="contacts.broken_taxels",
                value=self.broken_taxels,
                remedy=f"Choose one of: {', '.join(get_args(BrokenTaxels))}",
            )

    def _check(self, name: str, low: float, high: float, *, unit: str) -> None:
        value = getattr(self, name)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and low <= value <= high):  # NaN is in no range
            raise SceneError(
                "a contact setting is out of range",
                place=f"contacts.{name}",
                value=value,
                remedy=f"Choose {low:g} to {high:g} {unit}",
            )
        set_fields(self, **{name: float(value)})

    @property
    def centre(self) -> CentreSettings:
        """Where a contact's centre is taken from."""
        return CentreSettings(self.pixel, self.interpolation, self.back_projection)

    def threshold_for(self, errors: SensorUncertainty) -> float:
        """The threshold in force [Pa] with readings that are so far off.

        What a person sets stands, whatever the noise. Theory has max(3 sigma, a tenth of the peak); the tenth is left
        out: it is there to cut one contact out of a whole image, and would let a firm contact erase a light one beside
        it. What it is good for, keeping the cover's blur out of the inversion, the region with its one ring does.
        """
        return self.threshold if self.threshold is not None else max(TOUCH_THRESHOLD, ABOVE_NOISE * errors.noise)

    def thresholds_for(self, errors: SensorUncertainty) -> float | FloatArray:
        """The threshold of each taxel [Pa]: (taxels,) where their noise was measured, else one for all."""
        if self.threshold is not None or errors.taxels is None:
            return self.threshold_for(errors)
        return np.maximum(TOUCH_THRESHOLD, errors.taxels.limits(ABOVE_NOISE))


def reading_from(values: Mapping[str, object]) -> ReadingSettings:
    """Settings from a scene's table.

    Raises:
        SceneError: An unknown key, or a value that is none of those allowed.
    """
    check_keys(values, ReadingSettings, place="contacts")
    return ReadingSettings(**values)  # type: ignore[arg-type]


_USUAL = ReadingSettings()
_NONE: Mapping[str, FloatArray] = MappingProxyType({})


class ContactPipeline:
    """Reads contacts tick by tick. Mutable; ``reset`` forgets the past.

    Args:
        robot: Which the skin covers; where its links are tells self-touch.
        map_: The skin's map. Its skin is the one believed in; the one that feels needs the same taxels, but they may
            lie elsewhere.
        sensor: What the sensor does to readings, for the threshold and the regions' error bars.
        settings: How contacts are read; may be set at any time.
        depth: Of the taxels below the cover's surface [m], for estimators that undo its blur.
        seed: Of a force-torque sensor's noise.

    Attributes:
        estimates: What the estimator in force answered at the last tick, by region; empty with the area sum.

    Raises:
        MapError: The depth is no such number.
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
    ) -> None:
        self._skin = map_.skin
        self._depth = depth
        self._settings = settings
        self._reader = ContactDetector(map_, centre=settings.centre)
        self._forces = RegionForceEstimator(
            map_, estimator=settings.estimator, depth=depth, wrench_noise=settings.wrench_noise, seed=seed
        )
        self._self_touch = SelfTouchMatcher()
        self._events = EventDetector()
        self._fill: TaxelFill | None = None
        self._filled: tuple[FloatArray, FilledReadings] | None = None
        self.set_sensor_model(sensor)
        # Only a skin on two links can touch itself.
        several = len({patch.link for patch in map_.skin.patches}) > 1
        self._configuration = Configuration(robot) if several else None
        self._nothing = np.zeros(len(map_.skin))
        self.estimates: Mapping[int, ForceEstimate] = {}

    @property
    def settings(self) -> ReadingSettings:
        """How contacts are read. They stay who they are when that changes."""
        return self._settings

    @settings.setter
    def settings(self, settings: ReadingSettings) -> None:
        self._forces.estimator = settings.estimator
        self._forces.wrench_noise = settings.wrench_noise
        self._settings = settings
        self._reader.threshold = settings.thresholds_for(self._reader.errors)
        self._filled = None
        if settings.centre != self._reader.centre:
            self._reader.centre = settings.centre

    @property
    def threshold(self) -> float:
        """Lowest pressure that counts as touch [Pa]: the threshold of contacts, or of the sensor where it is higher."""
        errors = self._reader.errors
        of_sensor = errors.effects.threshold
        return max(self._settings.threshold_for(errors), of_sensor.at if of_sensor else 0.0)

    @property
    def needs_wrenches(self) -> bool:
        """Whether ``read`` wants to be told what the contacts do to links as a whole."""
        return self._settings.estimator == "lumped"

    def use(self, map_: TactileMap) -> None:
        """Place contacts by another map of the same skin from now on. Cost: 0.2 ms."""
        self._reader.use(map_)
        self._forces.use(map_)

    def set_sensor_model(self, sensor: SensorEffects, *, averaged: float = 0.0, model: str = "") -> None:
        """Draw error bars for a sensor that does this to readings from now on, and stay above its noise.

        Args:
            sensor: Effects of the sensor.
            averaged: Tick whose mean a reading is [s]; 0 for readings of an instant.
            model: Contact model that the readings come from.
        """
        errors = SensorUncertainty.of_sensor(sensor, averaged=averaged, model=model)
        if sensor.area_averaging is not None:
            errors = replace(errors, displaced=pad_displacements(self._skin, sensor.area_averaging.radius))
        self._reader.errors = replace(errors, depth=self._depth) if model == "half-space" else errors
        self._reader.threshold = self._settings.thresholds_for(self._reader.errors)
        self._filled = None
        gaps = sensor.area_averaging is not None or sensor.dead_taxels is not None
        self._reader.wait(period=1 / sensor.sampling.rate if sensor.sampling else 0.0, gaps=gaps)

    def set_measured_noise(self, noise: TaxelNoise | None) -> None:
        """Use the measured noise of each taxel for thresholds and error bars from now on; None for unknown noise."""
        self._reader.errors = SensorUncertainty.measured(noise)
        self._reader.threshold = self._settings.thresholds_for(self._reader.errors)
        self._filled = None

    def set_broken_taxels(self, broken: BoolArray) -> None:
        """Estimate the readings of these ``broken`` (taxels,) from their neighbours from now on; see ``TaxelFill``."""
        known = self._fill
        if known is None or not np.array_equal(known.broken, broken):
            self._fill = TaxelFill(self._skin, broken) if broken.any() or known is not None else None
            self._filled = None

    @property
    def blind(self) -> tuple[BlindArea, ...]:
        """Areas of broken taxels whose readings cannot be estimated."""
        known = self._fill
        return () if known is None or self._settings.broken_taxels == "as-read" else known.blind

    def _estimated(self, pressures: FloatArray) -> FilledReadings | None:
        """Return the readings with estimates for broken taxels; None where none is known or none is requested.

        A reading that cannot change is estimated once: a slow skin repeats it from tick to tick.
        """
        if self._fill is None or self._settings.broken_taxels == "as-read":
            return None
        known = self._filled
        if known is None or known[0] is not pressures or pressures.flags.writeable:
            errors = self._reader.errors
            noise = errors.noise if errors.taxels is None else errors.taxels.sd
            filled = self._fill.fill(pressures, threshold=self._reader.threshold, noise=noise)
            known = self._filled = (pressures, filled)
        return known[1]

    def use_units(self, units: ReadingUnits) -> None:
        """What readings may be called from now on: events tell forces only where they may."""
        self._events.claims_force = units.force is not None

    def reset(self) -> None:
        """Forget all contacts and events; ids start at 1 again."""
        self._reader.reset()
        self._forces.reset()
        self._self_touch.reset()
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
    ) -> tuple[ContactRegion, ...]:
        """The regions touched at a tick, the strongest first; what began or ended with them stands in ``recent``.

        Args:
            tick: Of the frame; rising.
            time: The same [s].
            posture: (joints,) of the robot.
            pressures: (taxels,) [Pa]; None where no skin is simulated, which counts as untouched.
            wrenches: By link, (6,) force [N] and torque [N m] of all contacts on it, about its origin, in its frame;
                where ``needs_wrenches``.

        Cost: ``ContactDetector``'s and 3 µs a contact, and 30 µs while two links are touched; with another estimator
        than the area sum, that one's as well.
        """
        pressures = self._nothing if pressures is None else pressures
        filled = self._estimated(pressures)
        pressures = pressures if filled is None else filled.pressures
        regions = self._reader.read(pressures, time=time, estimated=None if filled is None else filled.sd)
        regions, self.estimates = self._forces.read(
            regions, pressures, self._reader.errors_now, wrenches, awaited=self._reader.may_return(time)
        )
        if self._configuration is not None:
            if len({region.link for region in regions}) > 1:
                self._configuration.update(posture)
            regions = self._self_touch.link(regions, self._configuration.pose)
        self._events.read(tick, time, regions, awaited=self._forces.awaited)
        return regions

    @property
    def mismatch(self) -> WrenchMismatch | None:
        """Several touches of a link whose wrench none of them explains, at the last tick; None but with ``lumped``."""
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
    """The contacts in one reading of a skin, with no past; a stream of readings is for ``ContactPipeline``.

    Args:
        map_: The skin's map.
        pressures: (taxels,) [Pa].
        threshold: A taxel is touched from here [Pa]; by default 1 kPa, or what stands out of the noise if that is more.
        estimator: The way from readings to a contact's force, but ``lumped``, which reads another sensor.
        depth: Of the taxels below the cover's surface [m], for estimators that undo its blur.
        errors: How far readings may be off, for the error bars; by default not at all.

    Returns:
        The strongest first; ``map_point`` is on the map, ``point`` and ``normal`` are in the frame of ``link``.

    Raises:
        MapError: Not one pressure for each taxel, or the estimator is ``lumped``.
        SceneError: No such estimator or threshold.

    Example:
        >>> pressures = tm.press_skin(skin, skin.taxel_point(30), force=3.0)
        >>> for contact in tm.read_contacts(tactile_map, pressures):
        ...     print(f"{contact.force:.2f} N on {contact.link}")
        3.00 N on hand

    Cost: 10 ms for 1000 taxels; an estimator that undoes the blur 0.2 s.
    """
    pressures = np.asarray(pressures, dtype=np.float64)
    if pressures.shape != (len(map_.skin),):
        remedy = f"Give one number for each of the {len(map_.skin)} taxels"
        raise MapError("the pressures do not fit this skin", value=f"shape {pressures.shape}", remedy=remedy)
    if estimator == "lumped":
        remedy = f"Choose one of: {', '.join(name for name in ESTIMATORS if name != 'lumped')}"
        raise MapError("a force-torque sensor is not read from pressures", value=estimator, remedy=remedy)
    settings = ReadingSettings(estimator, threshold)
    errors = errors or SensorUncertainty()
    detector = ContactDetector(map_, threshold=settings.thresholds_for(errors), errors=errors)
    forces = RegionForceEstimator(map_, estimator=estimator, depth=depth)
    return forces.read(detector.read(pressures), pressures, errors)[0]
