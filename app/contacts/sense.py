"""The sense of touch as a whole: from one tick's pressures to contact regions, self-touch and events."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from app.arrays import FloatArray
from app.contacts.accuracy import ReadingErrors
from app.contacts.estimators.estimate import ForceEstimate
from app.contacts.event import ContactEvent
from app.contacts.events import EventReader
from app.contacts.force_reader import ForceReader
from app.contacts.reader import ContactReader
from app.contacts.reading_settings import ReadingSettings
from app.contacts.region import ContactRegion
from app.contacts.self_touch import SelfTouch
from app.maps.tactile_map import TactileMap
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.touch.sensor.effects import SensorEffects

_USUAL = ReadingSettings()
_NONE: Mapping[str, FloatArray] = MappingProxyType({})


class ContactSense:
    """Reads contacts tick by tick. Mutable; ``reset`` forgets the past.

    Args:
        robot: Which wears the skin; where its links are tells self-touch.
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
        self._settings, self._reader = settings, ContactReader(map_)
        self._forces = ForceReader(
            map_, estimator=settings.estimator, depth=depth, wrench_noise=settings.wrench_noise, seed=seed
        )
        self._self_touch, self._events = SelfTouch(), EventReader()
        self.trust(sensor)
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
        self._reader.threshold = settings.threshold_for(self._reader.errors)

    @property
    def feels_wrenches(self) -> bool:
        """Whether ``read`` wants to be told what the contacts do to links as a whole."""
        return self._settings.estimator == "lumped"

    def use(self, map_: TactileMap) -> None:
        """Place contacts by another map of the same skin from now on. Cost: 0.2 ms."""
        self._reader.use(map_)
        self._forces.use(map_)

    def trust(self, sensor: SensorEffects) -> None:
        """Draw error bars for a sensor that does this to readings from now on, and stay above its noise."""
        self._reader.errors = ReadingErrors.of_sensor(sensor)
        self._reader.threshold = self._settings.threshold_for(self._reader.errors)
        gaps = sensor.area_averaging is not None or sensor.dead_taxels is not None
        self._reader.wait(period=1 / sensor.sampling.rate if sensor.sampling else 0.0, gaps=gaps)

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
                where ``feels_wrenches``.

        Cost: ``ContactReader``'s and 3 µs a contact, and 30 µs while two links are touched; with another estimator
        than the area sum, that one's as well.
        """
        pressures = self._nothing if pressures is None else pressures
        regions = self._reader.read(pressures, time=time)
        regions, self.estimates = self._forces.read(
            regions, pressures, self._reader.errors, wrenches, awaited=self._reader.may_return(time)
        )
        if self._configuration is not None:
            if len({region.link for region in regions}) > 1:
                self._configuration.update(posture)
            regions = self._self_touch.link(regions, self._configuration.pose)
        self._events.read(tick, time, regions, awaited=self._forces.awaited)
        return regions

    @property
    def recent(self) -> tuple[ContactEvent, ...]:
        """The newest events, newest first; see ``EventReader``."""
        return self._events.recent
