"""The counterpart of ``Session`` for readings of a real skin: frames with contacts, events and forces.

It is operated, recorded and displayed like a ``Session``, but its frames come from readings instead of inputs: only the
map and the contact detection can be changed, and its recordings cannot be simulated again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.pipeline import ContactPipeline
from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.core.errors import LiveError, SimulationError
from tactile_maps.core.timing import Stopwatch
from tactile_maps.live.calibration.calibration import Calibration, ValueMode
from tactile_maps.live.channels.broken_channels import BrokenChannels
from tactile_maps.live.channels.channel_health import QUIET_SECONDS, ChannelHealth
from tactile_maps.live.channels.channel_swaps import SwapDetector
from tactile_maps.live.channels.last_heard import LastHeard
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.facts import MeasuredFacts, taxel_names
from tactile_maps.live.session.implausible import ImplausibleValues
from tactile_maps.live.session.known_weights import KnownWeights
from tactile_maps.live.session.measured_joints import MeasuredJoints
from tactile_maps.live.session.session_clock import SessionClock
from tactile_maps.live.session.skin_readings import USUAL_TARE, SkinReadings
from tactile_maps.session.frame import Frame, MeasuredValues
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import (
    CalibrationUsed,
    MapEdited,
    PokeMoved,
    PokePulled,
    PokeReleased,
    ReadingChanged,
    SessionInput,
    remembered,
)
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

NOTHING: Callable[[], Arrived | None] = lambda: None  # noqa: E731  source of a session that uses ``show`` instead


class ReadingLevels(NamedTuple):
    """Readings of n taxels, with their thresholds and noise.

    Attributes:
        readings: (n,) displayed pressures [Pa]; NaN where no value arrived.
        thresholds: (n,) pressures from which the taxels are in contact [Pa].
        noise: (n,) standard deviations [Pa]; None if no tare measured them.
    """

    readings: FloatArray
    thresholds: FloatArray
    noise: FloatArray | None


class MeasuredSession:
    """Readings of a skin as frames. Mutable; ``reset`` restarts the clock and the contacts.

    Args:
        prepared: Robot, skin and map; see ``prepare_measured``.
        source: Returns the next reading in order, or None if none is waiting.
        table: Taxel number by the stream's id; replaces the skin's own ids.
        calibration: Calibration of the skin; None if unknown.
        mode: Displayed quantity; by default pressure if calibrated, otherwise values above the baseline.
        finite: Whether the readings come from a file: only their own times count then, not their arrival.
        quiet_seconds: Time without a change after which a channel is suspect [s].
        inverted: Whether values fall under pressure: the gain is negative where no calibration is given.
        tare_first: Whether no contact is detected in counts without a calibration before a tare: without a baseline
            the whole skin would seem to be touched.

    Attributes:
        prepared: Value of the argument.
        frame: The newest frame.
        inputs: (tick, input) since the reset.
        map: Map on which contacts are located.
        readings: Newest values of the taxels, with units, tare and calibration.
        weights: Calibration with known weights.
        heard: Time of the newest value of each taxel and joint.
        implausible: Impossible values so far.

    Raises:
        LiveError: The calibration is of another skin.
    """

    def __init__(
        self,
        prepared: PreparedScene,
        source: Callable[[], Arrived | None] = NOTHING,
        *,
        table: Mapping[int, int] | None = None,
        calibration: Calibration | None = None,
        mode: ValueMode | None = None,
        finite: bool = False,
        quiet_seconds: float = QUIET_SECONDS,
        tare_first: bool = False,
        inverted: bool = False,
    ) -> None:
        self.prepared = prepared
        self._source = source
        self._start = RuntimeSettings.of_scene(prepared)
        self._reading = self._start.reading
        self.map = prepared.map
        skin = prepared.skin
        robot = prepared.robot
        layer = prepared.scene.layer
        self._contacts = ContactPipeline(
            robot,
            self.map,
            SensorEffects(),
            settings=self._reading,
            depth=layer.depth,
            friction=layer.friction or 0.5,
        )
        self._contacts.set_measured_noise(None)
        self.implausible = ImplausibleValues()
        self._clock = SessionClock(prepared.scene.tick, finite=finite)
        self._joints = MeasuredJoints(robot, self.implausible)
        self.readings = SkinReadings(
            skin,
            self.implausible,
            self._contacts.set_measured_noise,
            table=table,
            calibration=calibration,
            mode=mode,
            inverted=inverted,
            tare_first=tare_first,
        )
        self.weights = KnownWeights(self.readings, skin.areas, self._clock)
        self.heard = LastHeard(skin, len(robot.joints))
        self._health = ChannelHealth(skin, seconds=quiet_seconds)
        self._broken = BrokenChannels(len(skin))
        self._swaps = SwapDetector(skin)
        self._watch = Stopwatch()
        self._watchers: list[Callable[[Frame], None]] = []
        self._waiting: list[SessionInput] = []
        self._used = 0
        self._combined = 0
        self._without_frame = 0
        self._refused = 0
        self._problem: str | None = None
        self.reset()

    def reset(self) -> None:
        """Discard contacts, values and time; calibration, baseline, map and settings stay."""
        self._contacts.reset()
        self._clock.reset()
        self._joints.reset()
        self.readings.reset()
        self.heard.reset()
        self._health.reset()
        self._broken.reset()
        self._swaps.reset()
        self._sequence: int | None = None
        self.inputs = InputLog((0, session_input) for session_input in self.runtime_settings.since(self._start))
        self.frame = self._frame()

    @property
    def failure(self) -> None:
        """None: readings cannot diverge."""

    @property
    def runtime_settings(self) -> RuntimeSettings:
        """Current settings that can be changed at run time; only map and reading apply to measured readings."""
        start = self._start
        return RuntimeSettings(start.settings, start.effects, start.behaviours, self._reading, self.map)

    @property
    def levels(self) -> ReadingLevels:
        """Newest readings with the thresholds and noise of the taxels."""
        readings = np.where(np.isnan(self.readings.raw), np.nan, self.frame.pressures)
        noise = self.readings.noise
        return ReadingLevels(readings, self._contacts.thresholds, None if noise is None else noise.sd)

    @property
    def broken_taxels(self) -> BoolArray:
        """(taxels,) whether the channel of each is broken."""
        return self._broken.broken.copy()

    @property
    def stuck_taxels(self) -> BoolArray:
        """(taxels,) whether the channel of each is stuck; the other broken ones are dead."""
        return self._broken.stuck.copy()

    @property
    def mean_rate(self) -> float:
        """Mean rate of readings by the sender's clock [Hz]; 0 before there are two."""
        return (self._used - 1) / self._clock.time if self._used > 1 and self._clock.time > 0 else 0.0

    def tare(self, frames: int = USUAL_TARE) -> None:
        """Tare the skin, see ``SkinReadings.tare``; a running calibration with a known weight ends."""
        self.weights.cancel()
        self.readings.tare(frames)

    def adopt(self, used: CalibrationUsed) -> None:
        """Use gains, offsets, baseline and broken taxels of a recording.

        Raises:
            LiveError: They are of another skin.
        """
        self.readings.adopt(used)
        self._broken.broken[used.broken] = True
        self._broken.stuck[used.stuck] = True

    @property
    def facts(self) -> MeasuredFacts:
        """Facts about the readings to display to the user."""
        readings = self.readings
        matcher = readings.matcher
        skin = self.prepared.skin
        return MeasuredFacts(
            readings=self._used,
            refused=self._refused,
            problem=self._problem,
            unknown=tuple(sorted(matcher.unknown)),
            unknown_values=matcher.unknown_values,
            ambiguous=tuple(sorted(matcher.ambiguous)),
            ambiguous_values=matcher.ambiguous_values,
            unheard=int((~matcher.heard).sum()),
            unknown_joints=tuple(sorted(self._joints.unknown)),
            unheard_joints=int((self.heard.joints == -np.inf).sum()),
            silent=self._health.silent,
            swapped=self._swaps.swapped,
            unit=readings.unit,
            mode=readings.mode,
            calibrated=readings.units.force is not None,
            known=readings.calibration.known,
            mistimed=self._clock.mistimed,
            combined=self._combined,
            taring=readings.taring,
            tared=readings.tared,
            awaits_tare=readings.awaits_tare,
            weighing=self.weights.state,
            inverted=readings.inverted,
            falling=readings.falling.found,
            falling_taxels=taxel_names(skin, readings.falling.taxels),
            touched_in_tare=taxel_names(skin, readings.touched_in_tare),
            held_in_tare=taxel_names(skin, readings.held_in_tare),
            wrong_channels=readings.shear.wrong,
            wrong_channel_values=readings.shear.wrong_values,
        )

    def submit(self, session_input: SessionInput) -> None:
        """Change the map or the contact detection from the next reading on.

        Raises:
            SimulationError: The input applies only to simulations.
        """
        if isinstance(session_input, PokeMoved | PokePulled | PokeReleased):
            return  # follows a poke that was rejected
        if not isinstance(session_input, MapEdited | ReadingChanged):
            remedy = "Disconnect to simulate again"
            raise SimulationError("a measured skin cannot be poked or controlled", remedy=remedy)
        self._waiting.append(session_input)
        if self._used == 0:
            self.apply_inputs()

    @contextmanager
    def watched(self, each: Callable[[Frame], None]) -> Iterator[None]:
        """Call ``each`` with every new frame while the block runs."""
        self._watchers.append(each)
        try:
            yield
        finally:
            self._watchers.remove(each)

    def tick(self) -> Frame:
        """Use the next reading, if one is waiting; return the newest frame.

        Cost: 0.2 ms for 1000 taxels without contact, plus the time of the force estimator.
        """
        self.apply_inputs()
        item = self._source()
        return self.frame if item is None else self.show(item)

    def show(self, item: Arrived) -> Frame:
        """Return the frame of a reading; the previous frame if the reading does not fit the skin, which is counted."""
        return self.make_frame() if self.apply(item) else self.frame

    def apply(self, item: Arrived, *, compare: bool = True) -> bool:
        """Use the values of a reading without making a frame; return False if it does not fit the skin, which is
        counted.

        ``make_frame`` combines several readings into one frame.

        Args:
            item: The reading.
            compare: False to skip the search for swapped channels, which takes up to 90 ms for 5,000 taxels.

        Cost: 0.02 ms for 100 taxels, 0.1 ms for 5,000.
        """
        reading = item.reading
        readings = self.readings
        with self._watch.stage("receive"):
            try:
                matched = readings.match(reading)
                joints, positions = self._joints.match(reading.joints)
                readings.use_unit(reading.unit)
                if reading.recorded is not None and readings.unknown:
                    self.adopt(reading.recorded)
            except LiveError as error:
                self._refused += 1
                self._problem = str(error)
                return False
            taxels = matched.taxels
            values = matched.values
            self._sequence = reading.sequence
            self._clock.advance(reading.time, item.at)
            self._joints.move(joints, positions, self._clock.time)
            self.heard.add(taxels, joints, readings.differ(matched), item.at, item.at - item.age)
            self._broken.add(taxels, values, readings.raw[taxels])
            self._health.add(taxels, values, self._clock.time)
            self._broken.notice_silence(self._health.silent, readings.spread)
            readings.use(matched)
            self.weights.add_reading()
            if compare:
                self._swaps.add(readings.raw, self._clock.time)
        self._used += 1
        self._without_frame += 1
        return True

    def make_frame(self) -> Frame:
        """Return the frame of the values used since the previous frame."""
        self._combined += max(self._without_frame - 1, 0)
        self._without_frame = 0
        self.frame = self._frame()
        for each in tuple(self._watchers):
            each(self.frame)
        return self.frame

    def missing(self) -> Callable[[Reading], bool]:
        """Return a function for ``Connection.take_newest``, to call with readings from the newest to the oldest.

        It returns False once they contain a value of every taxel and joint that has ever had one.
        """
        taxels = self.heard.taxels > -np.inf
        joints = {name for name, number in self._joints.numbers.items() if self.heard.joints[number] > -np.inf}
        complete = bool(taxels.any())

        def needed(reading: Reading) -> bool:
            try:
                taxels[self.readings.matcher.taxels(reading)] = False
            except LiveError:
                return True
            joints.difference_update(reading.joints)
            return not complete or bool(joints) or bool(taxels.any())

        return needed

    def apply_inputs(self) -> None:
        """Apply the submitted inputs."""
        while self._waiting:
            session_input = self._waiting.pop(0)
            if isinstance(session_input, MapEdited):
                self._contacts.use(session_input.map)
                self.map = session_input.map
            elif isinstance(session_input, ReadingChanged):
                self._contacts.settings = self._reading = session_input.settings
            self.inputs.append(self._clock.ticks + 1, remembered(session_input))

    def _frame(self) -> Frame:
        readings = self.readings
        clock = self._clock
        pressures = readings.pressures()
        shear = readings.shear_tractions()
        units = readings.units
        broken = self._broken
        used = readings.changed_calibration(np.flatnonzero(broken.broken), np.flatnonzero(broken.stuck))
        if used is not None:
            self.inputs.append(clock.ticks, used)
            if (factors := readings.take_rescaling()) is not None:
                self._contacts.rescale(factors)
        self._contacts.set_broken_taxels(broken.broken)
        self._contacts.use_units(units)
        felt = np.zeros(len(pressures)) if readings.awaits_tare else pressures
        readings.notice_falling(pressures)
        posture = self._joints.posture
        with self._watch.stage("contacts"):
            regions = self._contacts.read(clock.ticks, clock.time, posture, felt, shear=shear)
        zero = np.zeros(len(posture))
        return Frame(
            tick=clock.ticks,
            time=clock.time,
            posture=posture.copy(),
            velocity=self._joints.velocity.copy(),
            pressures=pressures,
            regions=regions,
            pokes=(),
            command=JointCommand(posture.copy(), zero, zero, zero),
            timings=self._watch.take(),
            notes=tuple(area.note for area in self._contacts.blind),
            recent=self._contacts.recent,
            estimates=self._contacts.estimates,
            measured=MeasuredValues(
                readings.raw.copy(),
                readings.unit or Unit.COUNTS,
                clock.sent,
                self._sequence,
                units,
                None if shear is None else readings.shear.raw.copy(),
            ),
            shear=shear,
        )
