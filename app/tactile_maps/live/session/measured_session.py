"""The counterpart of ``Session`` for readings of a real skin: frames with contacts, events and forces.

It is operated, recorded and displayed like a ``Session``, but its frames come from readings instead of inputs: only the
map and the contact detection can be changed, and its recordings cannot be simulated again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from tactile_maps.contacts.detection.taxel_noise import TailShape, TaxelNoise, estimate_noise, tail_of_readings
from tactile_maps.contacts.pipeline import ContactPipeline
from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError, SimulationError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.timing import Stopwatch
from tactile_maps.live.channels.calibration import Calibration, FallingReadingsError, Tare, ValueMode
from tactile_maps.live.channels.channel_health import QUIET_SECONDS, ChannelHealth, SilentChannel
from tactile_maps.live.channels.channel_swaps import SwapDetector, SwappedChannels
from tactile_maps.live.channels.falling_values import FallingValues
from tactile_maps.live.channels.last_heard import LastHeard
from tactile_maps.live.channels.matching import TaxelMatcher
from tactile_maps.live.channels.shear_channels import ShearChannels
from tactile_maps.live.channels.weighing import RecentReadings, Weighing, WeighingState
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit
from tactile_maps.robots.model.robot import Joint
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

MOST_COUNTS = 2.0**32
"""Largest plausible absolute value in counts: no converter has more bits."""
MOST_PRESSURE = 1e7
"""Largest plausible absolute pressure [Pa]: ten times the range of the strongest skins."""
JOINT_TOLERANCE = 0.1
"""Tolerance of a position beyond the joint's limits [rad]: encoders and models differ."""
SLIDE_TOLERANCE = 0.01
"""The same for a slide [m]."""
MOST_TURNS = 1e4
"""Largest plausible position of a joint without limits [rad]."""
LONGEST_SLIDE = 100.0
"""Largest plausible position of a slide without limits [m]."""
FASTEST_JOINT = 30.0
"""Largest plausible speed of a joint [rad/s], in addition to its tolerance in one step."""
FASTEST_SLIDE = 10.0
"""The same for a slide [m/s]."""
_LONGEST_STEP = 10.0
"""A larger forward step of the clock in a file [s] means that the clock was set; the time of arrival is used then."""
_AHEAD = 0.25
"""A live sender's clock may gain at most this much [s] on the time of arrival between two readings."""
_USUAL_TARE = 50
"""Number of readings in a tare, also where a recording does not state it."""
_NO_TAXELS: IntArray = readonly([], np.int64)
NOTHING: Callable[[], Arrived | None] = lambda: None  # noqa: E731  source of a session that uses ``show`` instead


@dataclass(frozen=True)
class MeasuredFacts:
    """Facts about the readings to display to the user, other than contacts.

    Attributes:
        readings: Number of readings used so far.
        refused: Number of readings that did not fit the skin.
        problem: Error of the newest rejected reading; None if there was none.
        unknown: Sorted labels that belong to no taxel.
        unknown_values: Number of values with such a label.
        ambiguous: Sorted labels that belong to several taxels, with the labels that tell these apart.
        ambiguous_values: Number of values with such a label.
        unheard: Number of taxels without a value so far.
        unknown_joints: Sorted names of joints that the robot does not have.
        unheard_joints: Number of the robot's joints without a position so far; they are displayed in the home posture.
        silent: Channels that do not follow the skin.
        swapped: Channels that are exchanged.
        unit: Unit of the newest reading.
        mode: Displayed quantity.
        calibrated: Whether pressures and forces are calibrated.
        mistimed: Number of readings with an implausible time, for which the time of arrival was used.
        combined: Number of readings without a frame of their own, because newer ones were waiting.
        taring: Whether the baseline is being measured.
        tared: Whether there is a baseline.
        awaits_tare: Whether no contact is detected before a tare.
        weighing: Progress of a calibration with a known weight.
        inverted: Whether values that fall count as pressure.
        falling: Whether values fall below the baseline where the skin seems to be touched.
        wrong_channels: Taxels that sent too few or too many of the channels pressure, t1 and t2.
        wrong_channel_values: Number of their values.
    """

    readings: int
    refused: int
    problem: str | None
    unknown: tuple[str, ...]
    unknown_values: int
    ambiguous: tuple[str, ...]
    ambiguous_values: int
    unheard: int
    unknown_joints: tuple[str, ...]
    unheard_joints: int
    silent: tuple[SilentChannel, ...]
    swapped: tuple[SwappedChannels, ...]
    unit: Unit | None
    mode: ValueMode
    calibrated: bool
    mistimed: int
    combined: int
    taring: bool
    tared: bool
    awaits_tare: bool
    weighing: WeighingState
    inverted: bool
    falling: bool
    wrong_channels: tuple[str, ...]
    wrong_channel_values: int


@dataclass(frozen=True)
class Implausible:
    """Impossible values in the readings.

    Attributes:
        count: Number of readings with an impossible value.
        text: The newest one: its name, value and range.
    """

    count: int = 0
    text: str = ""


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
        heard: Time of the newest value of each taxel and joint.
        implausible: Impossible values so far.
        noise: Noise of the untouched taxels, in the displayed pressures; None if no tare measured it.
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
        self._finite = finite
        skin = prepared.skin
        robot = prepared.robot
        if calibration is not None and len(calibration.gain) != len(skin):
            found = f"{len(calibration.gain)} taxels for {len(skin)}"
            raise LiveError("the calibration is of another skin", value=found)
        self._given = calibration
        self._requested_mode = mode
        self._start = RuntimeSettings.of_scene(prepared)
        self._reading = self._start.reading
        self.map = prepared.map
        self._contacts = ContactPipeline(
            robot,
            self.map,
            SensorEffects(),
            settings=self._reading,
            depth=prepared.scene.layer.depth,
            friction=prepared.scene.layer.friction or 0.5,
        )
        self._matcher = TaxelMatcher(skin, table)
        self._health = ChannelHealth(skin, seconds=quiet_seconds)
        self.heard = LastHeard(skin, len(robot.joints))
        self._ranges = [_plausible(joint) for joint in robot.joints]
        self._swaps = SwapDetector(skin)
        self._falling = FallingValues(skin)
        self._joints = {joint.name: number for number, joint in enumerate(robot.joints)}
        zero = np.zeros(len(robot.joints))
        self._no_torque = zero
        self._watch = Stopwatch()
        self._watchers: list[Callable[[Frame], None]] = []
        self._waiting: list[SessionInput] = []
        self._readings = 0
        self._combined = 0
        self._without_frame = 0
        self._refused = 0
        self._problem: str | None = None
        self._unknown_joints: set[str] = set()
        self.implausible = Implausible()
        self.noise: TaxelNoise | None = None
        self._unit: Unit | None = None
        self._inverted = inverted
        self._calibration = calibration or self._plain(Unit.COUNTS, len(skin))
        self._negative: tuple[Calibration, float] | None = None
        self._baseline = np.zeros(len(skin))
        self._shear = ShearChannels(skin)
        self._spread: FloatArray | None = None
        self._counts: IntArray | None = None
        self._tail = TailShape()
        self._tare: Tare | None = None
        self._weighing: Weighing | None = None
        self._recent: RecentReadings | None = None
        self._weighed = WeighingState()
        self._before_weights: list[tuple[Calibration, Calibration | None]] = []
        self.tared = False
        self._tare_first = tare_first
        self.reset()

    def reset(self) -> None:
        """Discard contacts, values and time; calibration, baseline, map and settings stay."""
        self._contacts.reset()
        self._broken = np.zeros(len(self._baseline), dtype=bool)
        self._changed = np.zeros(len(self._baseline), dtype=bool)
        self._health.reset()
        self._swaps.reset()
        self._falling.reset()
        self.heard.reset()
        self._shear.reset()
        self._values = self._baseline + self._calibration.offset
        self._raw = np.full(len(self._values), np.nan)
        self._sequence: int | None = None
        self._posture = self.prepared.robot.home.copy()
        self._velocity = np.zeros(len(self._posture))
        self._joint_times = np.full(len(self._posture), -np.inf)  # session time of the newest positions
        self._times: tuple[float, float] | None = None  # sender's and receiver's time of the newest reading
        self._time_base: tuple[float, float, float] | None = None  # both and the session time when they last agreed
        self._mistimed = 0
        self._ticks = 0
        self._time = 0.0
        self.inputs = InputLog((0, session_input) for session_input in self.runtime_settings.since(self._start))
        self._recorded_calibration: CalibrationUsed | None = None
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
    def mode(self) -> ValueMode:
        """Displayed quantity."""
        known = self._calibration.known
        if self._requested_mode is None or (self._requested_mode is ValueMode.PRESSURE and not known):
            return ValueMode.PRESSURE if known else ValueMode.BASELINE
        return self._requested_mode

    def request_mode(self, mode: ValueMode) -> None:
        """Change the displayed quantity from the next reading on.

        Raises:
            LiveError: Pressure is requested for an uncalibrated skin.
        """
        if mode is ValueMode.PRESSURE and not self._calibration.known and self._unit is not None:
            remedy = "Give a calibration file, or calibrate with a known weight"
            raise LiveError("counts cannot be shown as pressure", value="no calibration", remedy=remedy)
        self._requested_mode = mode
        self._use_noise()

    @property
    def units(self) -> ReadingUnits:
        """Kind of the displayed values."""
        if self._calibration.known and self.mode is ValueMode.PRESSURE:
            return ReadingUnits.CALIBRATED
        known = self._unit is not None and self._unit.pascals is not None
        return ReadingUnits.PRESSURE if known else ReadingUnits.COUNTS

    @property
    def levels(self) -> ReadingLevels:
        """Newest readings with the thresholds and noise of the taxels."""
        readings = np.where(np.isnan(self._raw), np.nan, self.frame.pressures)
        return ReadingLevels(readings, self._contacts.thresholds, None if self.noise is None else self.noise.sd)

    @property
    def broken_taxels(self) -> BoolArray:
        """(taxels,) whether the channel of each is broken."""
        return self._broken.copy()

    @property
    def mean_rate(self) -> float:
        """Mean rate of readings by the sender's clock [Hz]; 0 before there are two."""
        return (self._readings - 1) / self._time if self._readings > 1 and self._time > 0 else 0.0

    @property
    def calibration(self) -> Calibration:
        """Current calibration."""
        return self._calibration

    def tare(self, frames: int = _USUAL_TARE) -> None:
        """Use the mean of the next readings as the baseline of the untouched skin, and their spread as noise.

        No contacts are detected meanwhile.
        """
        self._tare = Tare(len(self._values), frames)
        self._shear.begin_tare(frames)
        self._weighing = None
        self._falling.reset()

    @property
    def awaits_tare(self) -> bool:
        """True while no contact is detected because the skin was not tared."""
        return self._tare_first and self._unit is Unit.COUNTS and not (self.tared or self._calibration.known)

    def remember(self, seconds: float) -> None:
        """Keep the readings of the last ``seconds`` [s] for ``weigh``; raises LiveError if that is out of range."""
        self._recent = RecentReadings(seconds)

    def weigh(self, mass: float) -> Calibration:
        """Calibrate with a known weight [kg] that is on the skin now; return the new calibration.

        Uses the mean of the readings kept by ``remember``, otherwise the newest reading.

        Raises:
            LiveError: The readings do not change, the weight is not at rest, or the skin was not tared.
        """
        self._check_tared()
        areas = self.prepared.skin.areas
        change = self._change if self._recent is None else self._recent.mean(self._calibration.slope * areas)
        self._calibrate(self._calibration.with_weight(change, areas, mass))
        return self._calibration

    def begin_weighing(self, mass: float, seconds: float, *, taxels: IntArray | None = None) -> None:
        """Calibrate with a known weight on the skin, by the mean of the next readings.

        ``facts`` contains the progress; ``undo_weighing`` restores the previous calibration.

        Args:
            mass: Mass of the weight [kg].
            seconds: Time over which readings are averaged [s], at most 60.
            taxels: (k,) taxels under the weight: only their readings count, see ``Calibration.with_weight``; None for
                any.

        Raises:
            LiveError: The skin was not tared, or mass, time or taxels are invalid.
        """
        self._check_tared()
        self._weighing = Weighing(mass, seconds, taxels, self._time)
        self._weighed = WeighingState()
        self._negative = None

    def undo_weighing(self) -> None:
        """Restore the calibration before the newest weight, and end a running one."""
        self._weighing = None
        self._weighed = WeighingState()
        self._negative = None
        if self._before_weights:
            self._calibration, self._given = self._before_weights.pop()
            self._use_noise()

    def apply_negative_gain(self) -> None:
        """Use the negative gains of a weight under which the readings fell; does nothing if there is none."""
        if self._negative is None:
            return
        calibration, factor = self._negative
        self._negative = None
        self._calibrate(calibration)
        self._weighed = WeighingState(factor=factor)

    @property
    def inverted(self) -> bool:
        """Whether values that fall count as pressure: the gains are negative."""
        return bool(np.median(self._calibration.gain) < 0)

    def invert(self) -> None:
        """Use gains of the opposite sign from the next reading on; the tare stays valid."""
        self._inverted = not self._inverted
        self._calibration = self._calibration.inverted
        if self._given is not None:
            self._given = self._calibration
        self._falling.reset()
        self._use_noise()

    def _check_tared(self) -> None:
        if not self.tared:
            raise LiveError("the skin was not tared", remedy="Tare it untouched, then add the weight")

    @property
    def _change(self) -> FloatArray:
        """(taxels,) values above those of the untouched skin, in the sent unit."""
        change = self._values - self._baseline - self._calibration.offset
        return self._calibration.independent(change, self._shear.change)[0]

    def _calibrate(self, calibration: Calibration) -> None:
        self._before_weights.append((self._calibration, self._given))
        self._calibration = self._given = calibration
        self._use_noise()

    def _take_weighing(self) -> None:
        if self._weighing is None or not self._weighing.add(self._change, self._time):
            return
        weighing = self._weighing
        self._weighing = None
        areas = self.prepared.skin.areas
        try:
            calibration, factor = weighing.calibrated(self._calibration, areas)
        except FallingReadingsError as error:
            calibration, factor = weighing.calibrated(self._calibration.inverted, areas)
            self._negative = calibration, -factor
            self._weighed = WeighingState(problem=str(error), falling=True)
        except LiveError as error:
            self._weighed = WeighingState(problem=str(error))
        else:
            self._calibrate(calibration)
            self._weighed = WeighingState(factor=factor)

    def adopt(self, used: CalibrationUsed) -> None:
        """Use gains, offsets and baseline of a recording where no other calibration was given.

        Raises:
            LiveError: They are of another skin.
        """
        arrays = (used.gain, used.offset, used.baseline, used.spread, used.counts)
        if any(values is not None and values.shape != self._values.shape for values in arrays):
            found = f"{len(used.gain)} taxels for {len(self._values)}"
            remedy = "Use the skin of the recording, or give a calibration of this skin"
            raise LiveError("the recorded calibration is of another skin", value=found, remedy=remedy)
        if used.known:
            self._given = self._calibration = Calibration(used.gain, used.offset, curve=used.curve, matrix=used.matrix)
        elif (used.gain < 0).all():
            self._inverted = True
            self._calibration = self._plain(self._unit or Unit.COUNTS, len(self._values))
        self._baseline = used.baseline
        if used.shear_baseline is not None:
            self._shear.baseline = used.shear_baseline
        self._spread = used.spread
        self._counts = used.counts
        self._tail = TailShape(used.tail_scale, used.tail_heaviness)
        self.tared = used.spread is not None
        self._broken[used.broken] = True
        self._use_noise()

    @property
    def facts(self) -> MeasuredFacts:
        """Facts about the readings to display to the user."""
        matcher = self._matcher
        return MeasuredFacts(
            readings=self._readings,
            refused=self._refused,
            problem=self._problem,
            unknown=tuple(sorted(matcher.unknown)),
            unknown_values=matcher.unknown_values,
            ambiguous=tuple(sorted(matcher.ambiguous)),
            ambiguous_values=matcher.ambiguous_values,
            unheard=int((~matcher.heard).sum()),
            unknown_joints=tuple(sorted(self._unknown_joints)),
            unheard_joints=int((self.heard.joints == -np.inf).sum()),
            silent=self._health.silent,
            swapped=self._swaps.swapped,
            unit=self._unit,
            mode=self.mode,
            calibrated=self.units.force is not None,
            mistimed=self._mistimed,
            combined=self._combined,
            taring=self._tare is not None,
            tared=self.tared,
            awaits_tare=self.awaits_tare,
            weighing=self._weighing_state,
            inverted=self.inverted,
            falling=self._falling.found,
            wrong_channels=self._shear.wrong,
            wrong_channel_values=self._shear.wrong_values,
        )

    @property
    def _weighing_state(self) -> WeighingState:
        left = None if self._weighing is None else self._weighing.left(self._time)
        return replace(self._weighed, left=left, undoable=bool(self._before_weights))

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
        if self._readings == 0:
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
        with self._watch.stage("receive"):
            try:
                taxels, values = self._matcher.match(reading, self._calibration.gain < 0)
                self._check_values(taxels, values, reading.unit)
                sheared = None if reading.shear is None else self._match_shear(reading)
                joints, positions = self._known_joints(reading.joints)
                self._use_unit(reading.unit)
                if reading.recorded is not None and self._given is None and self._tare is None and not self.tared:
                    self.adopt(reading.recorded)
            except LiveError as error:
                self._refused += 1
                self._problem = str(error)
                return False
            self._advance(reading.time, item.at)
            self._check_speed(joints, positions)
            self.heard.add(taxels, joints, self._values[taxels] != values, item.at, item.at - item.age)
            self._notice_changes(taxels, values)
            self._values[taxels] = self._raw[taxels] = values
            if sheared is not None:
                self._shear.set(*sheared)
            self._sequence = reading.sequence
            self._move(joints, positions)
            self._health.add(taxels, values, self._time)
            self._notice_silence()
            if compare:
                self._swaps.add(self._raw, self._time)
            self._take_tare(taxels, _NO_TAXELS if sheared is None else sheared[0])
            self._take_weighing()
            if self._recent is not None and self.tared:
                self._recent.add(self._change, self._time)
        self._readings += 1
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
        joints = {name for name, number in self._joints.items() if self.heard.joints[number] > -np.inf}
        complete = bool(taxels.any())

        def needed(reading: Reading) -> bool:
            try:
                taxels[self._matcher.taxels(reading)] = False
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
            self.inputs.append(self._ticks + 1, remembered(session_input))

    def _use_unit(self, unit: Unit) -> None:
        if unit is self._unit:
            return
        if self._unit is not None:
            problem = "the unit of the readings changed"
            raise MalformedReadingError(problem, value=f"{unit} after {self._unit}", remedy="Send one unit")
        self._unit = unit
        if self._given is None:
            self._calibration = self._plain(unit, len(self._values))

    def _plain(self, unit: Unit, taxels: int) -> Calibration:
        """Return the calibration where none is given."""
        plain = Calibration.plain(taxels, unit)
        return plain.inverted if self._inverted else plain

    def _advance(self, sent: float, arrived: float) -> None:
        """Advance the session time to a reading.

        If its time does not fit the previous readings, the time of arrival is used instead. Such a time becomes the
        base for later ones only if the next reading fits it, as after a restart of the sender or a change of its clock.
        """
        before = self._times
        self._times = (sent, arrived)
        if self._time_base is None or before is None:
            self._time_base = sent, arrived, self._time
        else:
            base_sent, base_arrived, base = self._time_base
            fits = self._follows(self._times, (base_sent, base_arrived))
            self._mistimed += not fits
            now = base + (sent - base_sent if fits else max(arrived - base_arrived, 0.0))
            self._time = max(now, self._time)
            if fits or self._finite or self._follows(self._times, before):
                self._time_base = sent, arrived, self._time
        self._ticks = max(round(self._time / self.prepared.scene.tick), self._ticks + 1)

    def _follows(self, times: tuple[float, float], before: tuple[float, float]) -> bool:
        """Return whether the sender's and the receiver's time of a reading fit those of an earlier one."""
        passed = max(times[1] - before[1], 0.0)
        return 0 <= times[0] - before[0] <= (_LONGEST_STEP if self._finite else passed + _AHEAD)

    def _match_shear(self, reading: Reading) -> tuple[IntArray, FloatArray]:
        """Return the taxels (m,) with complete channels and their shear (m, 2)."""
        taxels, shear = self._shear.complete(*self._matcher.match_shear(reading, self._calibration.gain < 0))
        self._check_values(np.repeat(taxels, 2), shear.ravel(), reading.unit)
        return taxels, shear

    def _check_values(self, taxels: IntArray, values: FloatArray, unit: Unit) -> None:
        most = MOST_COUNTS if unit.pascals is None else MOST_PRESSURE / unit.pascals
        beyond = np.abs(values) > most
        if beyond.any():
            row = int(beyond.argmax())
            name = str(self.prepared.skin.taxel_name(int(taxels[row]))) or f"taxel {taxels[row]}"
            self._refuse("a value is impossible", name, f"{values[row]:g} {unit}", f"At most {most:g} {unit}")

    def _known_joints(self, joints: Mapping[str, float]) -> tuple[list[int], list[float]]:
        """Return numbers and positions of the robot's joints; names of unknown joints are kept."""
        numbers = []
        positions = []
        for name, position in joints.items():
            number = self._joints.get(name)
            if number is None:
                if len(self._unknown_joints) < 100:
                    self._unknown_joints.add(name)
                continue
            low, high = self._ranges[number]
            if not low <= position <= high:
                limits = f"From {low:g} to {high:g}"
                self._refuse("a joint's position is impossible", f"joint {name}", f"{position:g}", limits)
            numbers.append(number)
            positions.append(position)
        return numbers, positions

    def _refuse(self, problem: str, place: str, value: str, remedy: str) -> None:
        self.implausible = Implausible(self.implausible.count + 1, f"{place}: {value}. {remedy}")
        raise MalformedReadingError(problem, place=place, value=value, remedy=remedy)

    def _check_speed(self, joints: list[int], positions: list[float]) -> None:
        """Report a position that the joint cannot have reached since its previous one. It is displayed nevertheless."""
        for number, position in zip(joints, positions, strict=True):
            joint = self.prepared.robot.joints[number]
            fastest, tolerance = (FASTEST_SLIDE, SLIDE_TOLERANCE) if joint.slide else (FASTEST_JOINT, JOINT_TOLERANCE)
            step = self._time - self._joint_times[number]  # infinite for the first position
            moved = abs(position - self._posture[number])
            if moved > fastest * step + tolerance:
                text = f"joint {joint.name}: moved by {moved:.3g} in {step:.3g} s"
                self.implausible = Implausible(self.implausible.count + 1, text)

    def _move(self, joints: list[int], positions: list[float]) -> None:
        """Use joint positions; velocities are relative to the joint's previous position, even with other readings
        between.
        """
        if not joints:
            return
        passed = self._time - self._joint_times[joints]  # infinite for the first position: velocity 0
        moved = np.asarray(positions) - self._posture[joints]
        before = self._velocity[joints]
        velocity = self._velocity.copy()
        velocity[joints] = np.divide(moved, passed, out=before, where=passed > 0)
        self._velocity = velocity
        self._posture[joints] = positions
        self._joint_times[joints] = self._time

    def _notice_changes(self, taxels: IntArray, values: FloatArray) -> None:
        """Count taxels (k,) whose ``values`` (k,) differ from the previous ones as working."""
        before = self._raw[taxels]
        changed = taxels[~np.isnan(before) & (before != values)]
        self._changed[changed] = True
        self._broken[changed] = False

    def _notice_silence(self) -> None:
        """Count silent channels as broken where a working one would have changed.

        Without noise, a working taxel next to a contact may keep its value. So a silent channel is broken if it has
        never changed, or if it varied in the tare.
        """
        for one in self._health.silent:
            varied = self._spread is not None and self._spread[one.taxel] > 0
            self._broken[one.taxel] |= varied or not self._changed[one.taxel]

    def _take_tare(self, heard: IntArray, sheared: IntArray) -> None:
        """Add a reading to a running tare.

        Args:
            heard: (k,) taxels with a value in the reading.
            sheared: (m,) taxels with shear in the reading.
        """
        if self._tare is None:
            return
        last = self._tare.add(self._values, heard)
        self._shear.take_tare(sheared, last=last)
        if not last:
            return
        mean, self._spread, self._counts, readings = self._tare.result()
        self._tail = tail_of_readings(readings * self._gains)
        self._tare = None
        self.tared = True
        self._baseline = mean - self._calibration.offset
        self._use_noise()

    def _use_noise(self) -> None:
        """Detect contacts above the noise of the untouched skin, in displayed units."""
        if self._spread is None:
            return
        counts = np.full(len(self._spread), _USUAL_TARE) if self._counts is None else self._counts
        self.noise = estimate_noise(self._spread * np.abs(self._gains), counts, self._tail)
        self._contacts.set_measured_noise(self.noise)

    @property
    def _gains(self) -> FloatArray:
        """(taxels,) displayed pascals per unit of the readings."""
        if self.mode is ValueMode.PRESSURE:
            matrix = self._calibration.matrix
            slope = self._calibration.slope
            # Noise of all three channels, which are assumed to have as much as the first.
            return slope if matrix is None else slope * np.linalg.norm(matrix[:, 0], axis=1)
        sign = np.sign(self._calibration.gain) if self.mode is ValueMode.BASELINE else np.ones(len(self._values))
        return np.asarray(self._scale * sign)

    @property
    def _scale(self) -> float:
        """Displayed pascals per unit of the readings where no calibration is used."""
        return float(Calibration.plain(1, self._unit or Unit.COUNTS).gain[0])

    def _pressures(self) -> FloatArray:
        """Displayed pressures (taxels,) [Pa]."""
        calibration = self._calibration
        mode = self.mode
        if self._tare is not None and mode is not ValueMode.RAW:
            return np.zeros(len(self._values))  # the skin is untouched during a tare
        if mode is ValueMode.PRESSURE and calibration.matrix is not None:
            return calibration.pressures(self._change)
        if mode is ValueMode.PRESSURE:
            return calibration.values(self._values, self._baseline, mode)
        return self._scale * calibration.values(self._values, self._baseline + calibration.offset, mode)

    def _shear_tractions(self) -> FloatArray | None:
        """Displayed shear (taxels, 2) [Pa]; None if none was received."""
        if not self._shear.received:
            return None
        mode = self.mode
        if mode is ValueMode.RAW:
            return self._scale * np.nan_to_num(self._shear.raw)
        if self._tare is not None:
            return np.zeros_like(self._shear.raw)
        if mode is ValueMode.PRESSURE:
            change = self._values - self._baseline - self._calibration.offset
            shear = self._calibration.independent(change, self._shear.change)[1]
            return np.abs(self._calibration.slope)[:, None] * shear
        return self._scale * self._shear.change

    def _record_calibration(self) -> None:
        """Add the calibration to the inputs when it changes, so that a recording can be displayed with another one."""
        now = self._calibration
        recorded = self._recorded_calibration
        mode: Literal["raw", "baseline", "kPa"] = self.mode.value
        broken = np.flatnonzero(self._broken)
        if (
            recorded is not None
            and recorded.gain is now.gain
            and recorded.baseline is self._baseline
            and recorded.mode == mode
            and np.array_equal(recorded.broken, broken)
        ):
            return
        used = CalibrationUsed(
            now.gain,
            now.offset,
            self._baseline,
            self._spread,
            now.known,
            mode,
            self._counts,
            self._tail.scale,
            self._tail.heaviness,
            broken,
            now.curve,
            self._shear.baseline if self._shear.baseline.any() else None,
            now.matrix,
        )
        self._baseline = used.baseline
        self._recorded_calibration = used
        self.inputs.append(self._ticks, used)

    def _frame(self) -> Frame:
        pressures = self._pressures()
        shear = self._shear_tractions()
        units = self.units
        self._record_calibration()
        self._contacts.set_broken_taxels(self._broken)
        self._contacts.use_units(units)
        felt = np.zeros(len(pressures)) if self.awaits_tare else pressures
        if self.tared and self._tare is None and self.mode is not ValueMode.RAW:
            self._falling.add(pressures, self.noise)
        with self._watch.stage("contacts"):
            regions = self._contacts.read(self._ticks, self._time, self._posture, felt, shear=shear)
        zero = self._no_torque
        return Frame(
            tick=self._ticks,
            time=self._time,
            posture=self._posture.copy(),
            velocity=self._velocity.copy(),
            pressures=pressures,
            regions=regions,
            pokes=(),
            command=JointCommand(self._posture.copy(), zero, zero, zero),
            timings=self._watch.take(),
            notes=tuple(area.note for area in self._contacts.blind),
            recent=self._contacts.recent,
            estimates=self._contacts.estimates,
            measured=MeasuredValues(
                self._raw.copy(),
                self._unit or Unit.COUNTS,
                None if self._times is None else self._times[0],
                self._sequence,
                units,
                None if shear is None else self._shear.raw.copy(),
            ),
            shear=shear,
        )


def _plausible(joint: Joint) -> tuple[float, float]:
    """Return the lowest and highest plausible position of a joint [rad or m]."""
    tolerance, most = (SLIDE_TOLERANCE, LONGEST_SLIDE) if joint.slide else (JOINT_TOLERANCE, MOST_TURNS)
    return max(joint.lower - tolerance, -most), min(joint.upper + tolerance, most)


def swapped_texts(session: MeasuredSession, swapped: tuple[SwappedChannels, ...]) -> tuple[str, ...]:
    """Return swapped channels in words by module, like "module 14: 87012 with 87015"."""
    by_module: dict[int | None, list[str]] = {}
    skin = session.prepared.skin
    for one in swapped:
        names = [str(skin.taxel_name(taxel)) or f"taxel {taxel}" for taxel in (one.first, one.second)]
        by_module.setdefault(one.module, []).append(" with ".join(names))
    return tuple(
        ("" if module is None else f"module {module}: ") + ", ".join(pairs) for module, pairs in by_module.items()
    )


def silent_text(session: MeasuredSession, silent: SilentChannel) -> str:
    """Return a silent channel in words: its name and value."""
    name = str(session.prepared.skin.taxel_name(silent.taxel)) or f"taxel {silent.taxel}"
    return f"{name}: {'stuck' if silent.stuck else 'dead'} at {silent.value:g}"
