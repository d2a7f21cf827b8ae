"""What a ``Session`` is for a simulation, for readings of a real skin: frames with contacts, events and forces.

It is driven, recorded and shown as a ``Session`` is, but no input makes its frames: it has the map, the way contacts
are read and nothing else to change, and a recording of it cannot be simulated again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactile_maps.contacts.detection.taxel_noise import TailShape, TaxelNoise, estimate_noise, tail_of_readings
from tactile_maps.contacts.pipeline import ContactPipeline
from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError, SimulationError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.timing import Stopwatch
from tactile_maps.live.channels.calibration import Calibration, Tare, ValueMode
from tactile_maps.live.channels.channel_health import QUIET_SECONDS, ChannelHealth, SilentChannel
from tactile_maps.live.channels.channel_swaps import SwapDetector, SwappedChannels
from tactile_maps.live.channels.last_heard import LastHeard
from tactile_maps.live.channels.matching import TaxelMatcher
from tactile_maps.live.channels.weighing import RecentReadings, Weighing, WeighingState
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit
from tactile_maps.robots.model.robot import Joint
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import (
    CalibrationUsed,
    MapEdited,
    PokeMoved,
    PokeReleased,
    ReadingChanged,
    SessionInput,
    remembered,
)
from tactile_maps.session.measured_values import MeasuredValues
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

MOST_COUNTS = 2.0**32
"""Largest plausible amount of a value in counts: no converter has more bits."""
MOST_PRESSURE = 1e7
"""Largest plausible amount of a pressure [Pa]: ten times what the strongest skins measure."""
JOINT_TOLERANCE = 0.1
"""A position may be beyond a joint's limits by so much [rad]: encoders and models differ."""
SLIDE_TOLERANCE = 0.01
"""The same for a slide [m]."""
MOST_TURNS = 1e4
"""Largest plausible position of a joint without limits [rad]."""
LONGEST_SLIDE = 100.0
"""Largest plausible position of a slide without limits [m]."""
FASTEST_JOINT = 30.0
"""Largest plausible speed of a joint [rad/s], beyond its tolerance in one step."""
FASTEST_SLIDE = 10.0
"""The same for a slide [m/s]."""
_LONGEST_STEP = 10.0
"""A clock in a file that jumps ahead by more [s] was set: then the time of arrival counts."""
_AHEAD = 0.25
"""A live sender's clock may be ahead of the time of arrival by so much more [s] than at the reading before."""
_USUAL_TARE = 50
"""Number of readings in a tare, also where a recording does not state it."""
NOTHING: Callable[[], Arrived | None] = lambda: None  # noqa: E731  the source of a session that is given readings


@dataclass(frozen=True)
class MeasuredFacts:
    """What a person should know of the readings besides their contacts.

    Attributes:
        readings: Taken so far.
        refused: That did not fit the skin; ``problem`` says why the newest did not.
        problem: Of the newest refused one; None where there was none.
        unknown: Labels that no taxel has, sorted.
        unknown_values: How many values had one.
        unheard: Taxels that no value came for yet.
        unknown_joints: Joints that the robot does not have, sorted.
        unheard_joints: How many of its own no position came for yet; they are shown at rest.
        silent: Channels that do not follow the skin.
        swapped: Channels that stand in each other's place.
        unit: Of the newest reading.
        mode: What is shown.
        calibrated: Whether pressures and forces mean what they say.
        mistimed: Number of readings whose time does not fit those before; their time of arrival was used instead.
        taring: Whether the baseline is being measured.
        tared: Whether there is one.
        weighing: How calibrating by a known weight goes.
    """

    readings: int
    refused: int
    problem: str | None
    unknown: tuple[str, ...]
    unknown_values: int
    unheard: int
    unknown_joints: tuple[str, ...]
    unheard_joints: int
    silent: tuple[SilentChannel, ...]
    swapped: tuple[SwappedChannels, ...]
    unit: Unit | None
    mode: ValueMode
    calibrated: bool
    mistimed: int
    taring: bool
    tared: bool
    weighing: WeighingState


@dataclass(frozen=True)
class Implausible:
    """Impossible values in the readings.

    Attributes:
        count: How many readings contained one.
        text: The newest one: its name, value and range.
    """

    count: int = 0
    text: str = ""


class MeasuredSession:
    """Readings of a skin as frames. Mutable; ``reset`` starts the clock and the contacts again.

    Args:
        prepared: Robot, skin and map; see ``prepare_measured``.
        source: The next reading in order, or None where none waits.
        table: Running number of the taxel by the stream's id, instead of the skin's own ids.
        calibration: Of the skin; None where nothing is known.
        mode: What is shown; by default pressure where it is known, else values above the baseline.
        finite: Whether the readings come from a file: they arrive when they are read, so only their own times count.
        quiet_seconds: For which a channel may not change before it is suspected.

    Attributes:
        prepared: As above.
        frame: The newest frame.
        inputs: (tick, input) since the reset.
        map: By which contacts are placed.
        failure: None: readings do not diverge.
        scripted: False.
        heard: When each taxel and joint was last heard.
        implausible: Impossible values so far.
        noise: Of the untouched taxels, in the pressures shown; None where no tare measured it.
    """

    failure = None
    scripted = False

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
        self._wanted = mode
        self._start = RuntimeSettings.of_scene(prepared)
        self._reading = self._start.reading
        self.map = prepared.map
        self._contacts = ContactPipeline(
            robot, self.map, SensorEffects(), settings=self._reading, depth=prepared.scene.layer.depth
        )
        self._matcher = TaxelMatcher(skin, table)
        self._health = ChannelHealth(skin, seconds=quiet_seconds)
        self.heard = LastHeard(skin, len(robot.joints))
        self._ranges = [_plausible(joint) for joint in robot.joints]
        self._swaps = SwapDetector(skin)
        self._joints = {joint.name: number for number, joint in enumerate(robot.joints)}
        zero = np.zeros(len(robot.joints))
        self._no_torque = zero
        self._watch = Stopwatch()
        self._watchers: list[Callable[[Frame], None]] = []
        self._waiting: list[SessionInput] = []
        self._readings = 0
        self._refused = 0
        self._problem: str | None = None
        self._unknown_joints: set[str] = set()
        self.implausible = Implausible()
        self.noise: TaxelNoise | None = None
        self._unit: Unit | None = None
        self._calibration = calibration or Calibration.plain(len(skin), Unit.COUNTS)
        self._baseline = np.zeros(len(skin))
        self._spread: FloatArray | None = None
        self._counts: IntArray | None = None
        self._tail = TailShape()
        self._tare: Tare | None = None
        self._weighing: Weighing | None = None
        self._recent: RecentReadings | None = None
        self._weighed = WeighingState()
        self._before_weights: list[tuple[Calibration, Calibration | None]] = []
        self.tared = False
        self.reset()

    def reset(self) -> None:
        """Forget contacts, values and time; calibration, baseline, map and settings stay."""
        self._contacts.reset()
        self._broken = np.zeros(len(self._baseline), dtype=bool)
        self._changed = np.zeros(len(self._baseline), dtype=bool)
        self._health.reset()
        self._swaps.reset()
        self.heard.reset()
        self._values = self._baseline + self._calibration.offset
        self._raw = np.full(len(self._values), np.nan)
        self._sequence: int | None = None
        self._posture = self.prepared.robot.home.copy()
        self._velocity = np.zeros(len(self._posture))
        self._joint_times = np.full(len(self._posture), -np.inf)  # of the newest positions, in the session's time
        self._times: tuple[float, float] | None = None  # of the newest reading: the sender's and ours
        self._time_base: tuple[float, float, float] | None = None  # the same two and the session's, when they agreed
        self._mistimed = 0
        self._ticks = 0
        self._time = 0.0
        self.inputs: list[tuple[int, SessionInput]] = [
            (0, session_input) for session_input in self.runtime_settings.since(self._start)
        ]
        self._told: CalibrationUsed | None = None
        self.frame = self._frame()

    @property
    def runtime_settings(self) -> RuntimeSettings:
        """What a person may change, as it is in force; of it only map and reading mean anything here."""
        start = self._start
        return RuntimeSettings(start.settings, start.effects, start.behaviours, self._reading, self.map)

    @property
    def mode(self) -> ValueMode:
        """What is shown."""
        known = self._calibration.known
        if self._wanted is None or (self._wanted is ValueMode.PRESSURE and not known):
            return ValueMode.PRESSURE if known else ValueMode.BASELINE
        return self._wanted

    def request_mode(self, mode: ValueMode) -> None:
        """Show something else from the next reading on.

        Raises:
            LiveError: Pressure is wanted of a skin that is not calibrated.
        """
        if mode is ValueMode.PRESSURE and not self._calibration.known and self._unit is not None:
            remedy = "Give a calibration file, or calibrate with a known weight"
            raise LiveError("counts cannot be shown as pressure", value="no calibration", remedy=remedy)
        self._wanted = mode
        self._use_noise()

    @property
    def units(self) -> ReadingUnits:
        """What the values that are shown may be called."""
        if self._calibration.known and self.mode is ValueMode.PRESSURE:
            return ReadingUnits.CALIBRATED
        known = self._unit is not None and self._unit.pascals is not None
        return ReadingUnits.PRESSURE if known else ReadingUnits.COUNTS

    @property
    def broken_taxels(self) -> BoolArray:
        """(taxels,) whether the channel of each is broken."""
        return self._broken.copy()

    @property
    def mean_rate(self) -> float:
        """Readings a second by the sender's clock [Hz]; 0 before there are two."""
        return (self._readings - 1) / self._time if self._readings > 1 and self._time > 0 else 0.0

    @property
    def calibration(self) -> Calibration:
        """In force."""
        return self._calibration

    def tare(self, frames: int = _USUAL_TARE) -> None:
        """Take the mean of the next readings as that of the untouched skin, and their spread as noise.

        Until then nothing is felt.
        """
        self._tare = Tare(len(self._values), frames)
        self._weighing = None

    def remember(self, seconds: float) -> None:
        """Keep the readings of so long from now on, for ``weigh``; raises LiveError for what is no time."""
        self._recent = RecentReadings(seconds)

    def weigh(self, mass: float) -> Calibration:
        """Calibrate by a known weight [kg] that lies on the skin now; the calibration, in force from now on.

        By the mean of the readings that are remembered, else by the newest.

        Raises:
            LiveError: It is not felt, has not come to rest, or the skin was not tared.
        """
        self._check_tared()
        areas = self.prepared.skin.areas
        change = self._change if self._recent is None else self._recent.mean(self._calibration.gain * areas)
        self._calibrate(self._calibration.with_weight(change, areas, mass))
        return self._calibration

    def begin_weighing(self, mass: float, seconds: float, *, taxels: IntArray | None = None) -> None:
        """Calibrate by a known weight that lies on the skin from now on, by the mean of the next readings.

        How it goes is among the ``facts``; ``undo_weighing`` takes it back.

        Args:
            mass: [kg].
            seconds: Over which readings are averaged, at most 60.
            taxels: (k,) on which it lies: only their readings count, see ``Calibration.with_weight``; None for any.

        Raises:
            LiveError: The skin was not tared, or there is no such weight, time or taxel.
        """
        self._check_tared()
        self._weighing = Weighing(mass, seconds, taxels, self._time)
        self._weighed = WeighingState()

    def undo_weighing(self) -> None:
        """Go back to the calibration from before the newest weight, and end one that goes on."""
        self._weighing = None
        self._weighed = WeighingState()
        if self._before_weights:
            self._calibration, self._given = self._before_weights.pop()
            self._use_noise()

    def _check_tared(self) -> None:
        if not self.tared:
            raise LiveError("the skin was not tared", remedy="Tare it while nothing touches it, then lay the weight on")

    @property
    def _change(self) -> FloatArray:
        """(taxels,) values above the untouched skin's, as they are sent."""
        return self._values - self._baseline - self._calibration.offset

    def _calibrate(self, calibration: Calibration) -> None:
        self._before_weights.append((self._calibration, self._given))
        self._calibration = self._given = calibration
        self._use_noise()

    def _take_weighing(self) -> None:
        if self._weighing is None or not self._weighing.add(self._change, self._time):
            return
        weighing = self._weighing
        self._weighing = None
        try:
            calibration, factor = weighing.calibrated(self._calibration, self.prepared.skin.areas)
        except LiveError as error:
            self._weighed = WeighingState(problem=str(error))
        else:
            self._calibrate(calibration)
            self._weighed = WeighingState(factor=factor)

    def adopt(self, used: CalibrationUsed) -> None:
        """Take over gains, offsets and baseline of a recording, where nothing else was given.

        Raises:
            LiveError: It is of another skin.
        """
        sizes = {
            values.shape
            for values in (used.gain, used.offset, used.baseline, used.spread, used.counts)
            if values is not None
        }
        if sizes != {self._values.shape}:
            found = f"{len(used.gain)} taxels for {len(self._values)}"
            remedy = "Show it on the skin that it was recorded with, or give a calibration of this one"
            raise LiveError("the recorded calibration is of another skin", value=found, remedy=remedy)
        if used.known:
            self._given = self._calibration = Calibration(used.gain, used.offset)
        self._baseline = used.baseline
        self._spread = used.spread
        self._counts = used.counts
        self._tail = TailShape(used.tail_scale, used.tail_heaviness)
        self.tared = used.spread is not None
        self._broken[used.broken] = True
        self._use_noise()

    @property
    def facts(self) -> MeasuredFacts:
        """What a person should know besides contacts."""
        matcher = self._matcher
        return MeasuredFacts(
            readings=self._readings,
            refused=self._refused,
            problem=self._problem,
            unknown=tuple(sorted(matcher.unknown)),
            unknown_values=matcher.unknown_values,
            unheard=int((~matcher.heard).sum()),
            unknown_joints=tuple(sorted(self._unknown_joints)),
            unheard_joints=int((self.heard.joints == -np.inf).sum()),
            silent=self._health.silent,
            swapped=self._swaps.swapped,
            unit=self._unit,
            mode=self.mode,
            calibrated=self.units.force is not None,
            mistimed=self._mistimed,
            taring=self._tare is not None,
            tared=self.tared,
            weighing=self._weighing_state,
        )

    @property
    def _weighing_state(self) -> WeighingState:
        left = None if self._weighing is None else self._weighing.left(self._time)
        return replace(self._weighed, left=left, undoable=bool(self._before_weights))

    def submit(self, session_input: SessionInput) -> None:
        """Change the map or the way contacts are read, from the next reading on.

        Raises:
            SimulationError: It is something that only a simulation can do.
        """
        if isinstance(session_input, PokeMoved | PokeReleased):
            return  # of a poke that was refused
        if not isinstance(session_input, MapEdited | ReadingChanged):
            remedy = "Disconnect to simulate again"
            raise SimulationError("a measured skin can be watched, not poked or controlled", remedy=remedy)
        self._waiting.append(session_input)
        if self._readings == 0:
            self.apply_inputs()

    @contextmanager
    def watched(self, each: Callable[[Frame], None]) -> Iterator[None]:
        """Tell ``each`` every new frame while the block runs."""
        self._watchers.append(each)
        try:
            yield
        finally:
            self._watchers.remove(each)

    def tick(self) -> Frame:
        """Take the next reading, if one waits; the newest frame.

        Cost: 0.2 ms for 1000 taxels untouched, and what the estimator in force takes.
        """
        self.apply_inputs()
        item = self._source()
        return self.frame if item is None else self.show(item)

    def show(self, item: Arrived) -> Frame:
        """The frame of a reading; the last one where the reading does not fit the skin, which is counted."""
        return self.make_frame() if self.apply(item) else self.frame

    def apply(self, item: Arrived, *, compare: bool = True) -> bool:
        """Take the values of a reading without a frame; False where it does not fit the skin, which is counted.

        Several readings may be taken before ``make_frame`` shows them as one.

        Args:
            item: The reading.
            compare: False to leave out the search for swapped channels, which takes up to 90 ms for 5,000 taxels.

        Cost: 0.02 ms for 100 taxels, 0.1 ms for 5,000.
        """
        reading = item.reading
        with self._watch.stage("receive"):
            try:
                taxels, values = self._matcher.match(reading)
                self._check_values(taxels, values, reading.unit)
                joints, positions = self._known_joints(reading.joints)
                self._use_unit(reading.unit)
                if reading.recorded is not None and self._given is None and self._tare is None and not self.tared:
                    self.adopt(reading.recorded)
            except LiveError as error:
                self._refused = self._refused + 1
                self._problem = str(error)
                return False
            self._advance(reading.time, item.at)
            self._check_speed(joints, positions)
            self.heard.add(taxels, joints, self._values[taxels] != values, item.at, item.at - item.age)
            self._notice_changes(taxels, values)
            self._values[taxels] = self._raw[taxels] = values
            self._sequence = reading.sequence
            self._move(joints, positions)
            self._health.add(taxels, values, self._time)
            self._notice_silence()
            if compare:
                self._swaps.add(self._raw, self._time)
            self._take_tare(taxels)
            self._take_weighing()
            if self._recent is not None and self.tared:
                self._recent.add(self._change, self._time)
        self._readings += 1
        return True

    def make_frame(self) -> Frame:
        """The frame of the values that were taken since the last one."""
        self.frame = self._frame()
        for each in tuple(self._watchers):
            each(self.frame)
        return self.frame

    def missing(self) -> Callable[[Reading], bool]:
        """Return a function for ``Connection.take_newest``, to call with readings from the newest to the oldest.

        It returns False once they contain a value of every taxel and joint that was heard before.
        """
        taxels = self.heard.taxels > -np.inf
        joints = {joint.name for joint, at in zip(self.prepared.robot.joints, self.heard.joints, strict=True)
                  if at > -np.inf}  # fmt: skip
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
        """Put the inputs that were submitted in force."""
        while self._waiting:
            session_input = self._waiting.pop(0)
            if isinstance(session_input, MapEdited):
                self._contacts.use(session_input.map)
                self.map = session_input.map
            elif isinstance(session_input, ReadingChanged):
                self._contacts.settings = self._reading = session_input.settings
            self.inputs.append((self._ticks + 1, remembered(session_input)))

    def _use_unit(self, unit: Unit) -> None:
        if unit is self._unit:
            return
        if self._unit is not None:
            problem = "the unit of the readings changed"
            raise MalformedReadingError(problem, value=f"{unit} after {self._unit}", remedy="Send one unit")
        self._unit = unit
        if self._given is None:
            self._calibration = Calibration.plain(len(self._values), unit)

    def _advance(self, sent: float, arrived: float) -> None:
        """Let time pass up to a reading.

        A time that does not fit the reading before is not used: the time of arrival counts. It becomes the base of
        those after it only where the next reading fits it, as when the sender started again or its clock was set.
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
        """Return whether the sender's and our time of a reading follow those of one before it."""
        passed = max(times[1] - before[1], 0.0)
        return 0 <= times[0] - before[0] <= (_LONGEST_STEP if self._finite else passed + _AHEAD)

    def _check_values(self, taxels: IntArray, values: FloatArray, unit: Unit) -> None:
        most = MOST_COUNTS if unit.pascals is None else MOST_PRESSURE / unit.pascals
        beyond = np.abs(values) > most
        if beyond.any():
            row = int(beyond.argmax())
            name = str(self.prepared.skin.taxel_name(int(taxels[row]))) or f"taxel {taxels[row]}"
            self._refuse("a value is impossible", name, f"{values[row]:g} {unit}", f"At most {most:g} {unit}")

    def _known_joints(self, joints: Mapping[str, float]) -> tuple[list[int], list[float]]:
        """Numbers and positions of the robot's own joints; others are remembered by name."""
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
                self._refuse("a joint's position is impossible", f"joint {name}", f"{position:g}",
                             f"From {low:g} to {high:g}")  # fmt: skip
            numbers.append(number)
            positions.append(position)
        return numbers, positions

    def _refuse(self, problem: str, place: str, value: str, remedy: str) -> None:
        self.implausible = Implausible(self.implausible.count + 1, f"{place}: {value}. {remedy}")
        raise MalformedReadingError(problem, place=place, value=value, remedy=remedy)

    def _check_speed(self, joints: list[int], positions: list[float]) -> None:
        """Remember a position that the joint cannot have reached since it was last heard. It is shown all the same."""
        for number, position in zip(joints, positions, strict=True):
            joint = self.prepared.robot.joints[number]
            fastest, tolerance = (FASTEST_SLIDE, SLIDE_TOLERANCE) if joint.slide else (FASTEST_JOINT, JOINT_TOLERANCE)
            step = self._time - self._joint_times[number]  # infinite before the first
            moved = abs(position - self._posture[number])
            if moved > fastest * step + tolerance:
                text = f"joint {joint.name}: moved by {moved:.3g} in {step:.3g} s"
                self.implausible = Implausible(self.implausible.count + 1, text)

    def _move(self, joints: list[int], positions: list[float]) -> None:
        """Take positions; velocities are since the joint was last heard, also where other readings came between."""
        if not joints:
            return
        passed = self._time - self._joint_times[joints]  # infinite before the first: no velocity is known
        moved = np.asarray(positions) - self._posture[joints]
        before = self._velocity[joints]
        velocity = self._velocity.copy()
        velocity[joints] = np.divide(moved, passed, out=before, where=passed > 0)
        self._velocity = velocity
        self._posture[joints] = positions
        self._joint_times[joints] = self._time

    def _notice_changes(self, taxels: IntArray, values: FloatArray) -> None:
        """Count taxels (k,) as working whose ``values`` (k,) differ from the ones before."""
        before = self._raw[taxels]
        changed = taxels[~np.isnan(before) & (before != values)]
        self._changed[changed] = True
        self._broken[changed] = False

    def _notice_silence(self) -> None:
        """Count silent channels as broken where a working one would have changed.

        Without noise a working taxel next to a contact may keep its value. So a silent channel is broken if it has
        never changed, or if it varied in the tare.
        """
        for one in self._health.silent:
            varied = self._spread is not None and self._spread[one.taxel] > 0
            self._broken[one.taxel] |= varied or not self._changed[one.taxel]

    def _take_tare(self, heard: IntArray) -> None:
        if self._tare is None or not self._tare.add(self._values, heard):
            return
        mean, self._spread, self._counts, readings = self._tare.result()
        self._tail = tail_of_readings(readings * self._gains)
        self._tare = None
        self.tared = True
        self._baseline = mean - self._calibration.offset
        self._use_noise()

    def _use_noise(self) -> None:
        """Contacts are read above the noise of the untouched skin, in what is shown."""
        if self._spread is None:
            return
        counts = np.full(len(self._spread), _USUAL_TARE) if self._counts is None else self._counts
        self.noise = estimate_noise(self._spread * np.abs(self._gains), counts, self._tail)
        self._contacts.set_measured_noise(self.noise)

    @property
    def _gains(self) -> FloatArray:
        """(taxels,) pascals that a unit of the readings is shown as."""
        return self._calibration.gain if self.mode is ValueMode.PRESSURE else np.full(len(self._values), self._scale)

    @property
    def _scale(self) -> float:
        """Pascals that a unit of the readings is shown as where no calibration is used."""
        return float(Calibration.plain(1, self._unit or Unit.COUNTS).gain[0])

    def _pressures(self) -> FloatArray:
        """(taxels,) [Pa], or what is shown as that."""
        calibration = self._calibration
        mode = self.mode
        if self._tare is not None and mode is not ValueMode.RAW:
            return np.zeros(len(self._values))  # by its meaning nothing touches the skin meanwhile
        if mode is ValueMode.PRESSURE:
            return calibration.values(self._values, self._baseline, mode)
        return self._scale * calibration.values(self._values, self._baseline + calibration.offset, mode)

    def _tell_calibration(self) -> None:
        """By what readings are shown is an input, so that a recording of them can be shown otherwise."""
        now = self._calibration
        told = self._told
        mode = _recorded_mode(self.mode)
        broken = np.flatnonzero(self._broken)
        same = (
            told is not None
            and told.gain is now.gain
            and told.baseline is self._baseline
            and told.mode == mode
            and np.array_equal(told.broken, broken)
        )
        if not same:
            used = CalibrationUsed(
                now.gain, now.offset, self._baseline, self._spread, now.known, mode, self._counts,
                self._tail.scale, self._tail.heaviness, broken,
            )  # fmt: skip
            self._baseline = used.baseline
            self._told = used
            self.inputs.append((self._ticks, used))

    def _frame(self) -> Frame:
        pressures = self._pressures()
        units = self.units
        self._tell_calibration()
        self._contacts.set_broken_taxels(self._broken)
        self._contacts.use_units(units)
        with self._watch.stage("contacts"):
            regions = self._contacts.read(self._ticks, self._time, self._posture, pressures)
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
            ),
        )


def _plausible(joint: Joint) -> tuple[float, float]:
    """Lowest and highest plausible position [rad or m]."""
    tolerance, most = (SLIDE_TOLERANCE, LONGEST_SLIDE) if joint.slide else (JOINT_TOLERANCE, MOST_TURNS)
    return max(joint.lower - tolerance, -most), min(joint.upper + tolerance, most)


def _recorded_mode(mode: ValueMode) -> Literal["raw", "baseline", "kPa"]:
    match mode:
        case ValueMode.RAW:
            return "raw"
        case ValueMode.BASELINE:
            return "baseline"
        case ValueMode.PRESSURE:
            return "kPa"


def swapped_texts(session: MeasuredSession, swapped: tuple[SwappedChannels, ...]) -> tuple[str, ...]:
    """Swapped channels in words, module by module, like "module 14: 87012 with 87015"."""
    by_module: dict[int | None, list[str]] = {}
    skin = session.prepared.skin
    for one in swapped:
        names = [str(skin.taxel_name(taxel)) or f"taxel {taxel}" for taxel in (one.first, one.second)]
        by_module.setdefault(one.module, []).append(" with ".join(names))
    return tuple(
        ("" if module is None else f"module {module}: ") + ", ".join(pairs) for module, pairs in by_module.items()
    )


def silent_text(session: MeasuredSession, silent: SilentChannel) -> str:
    """A silent channel in words: its name, and what it says."""
    name = str(session.prepared.skin.taxel_name(silent.taxel)) or f"taxel {silent.taxel}"
    return f"{name}: {'stuck' if silent.stuck else 'dead'} at {silent.value:g}"
