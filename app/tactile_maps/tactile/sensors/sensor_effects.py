"""Effects of a tactile sensor on the pressures of its taxels: thirteen effects, each switched on separately.

The settings of an effect are a frozen value with ranges, which builds its stage (``SensorStage``) for a ``Readout``:
the skin, the tick and the seed. Effects are in the order of the signal, from the cover over transducer and amplifier to
converter and bus: area averaging (a receptive field rather than a stage), misorientation and axis crosstalk (a matrix
for all channels of a taxel, see ``axis_matrices``), crosstalk, hysteresis, gain spread, offset drift, noise,
saturation, threshold, quantisation, dead taxels, sampling. ``SensorEffects`` contains the selected effects and those of
plug-ins; ``sensor_chain`` runs the stages.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar
from zlib import crc32

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import FloatArray, readonly
from tactile_maps.core.codec import LATER
from tactile_maps.core.errors import SimulationError, check_range
from tactile_maps.skin.model.skin import Skin


def check_setting(place: str, value: float, low: float, high: float) -> None:
    """Reject a number outside ``low`` to ``high``, both included.

    Args:
        place: Effect and field, e.g. ``noise.sd``.
        value: The number.
        low: Lowest valid value.
        high: Highest valid value.

    Raises:
        SimulationError: It is not a number, not finite or outside the range.
    """
    check_range("the sensor setting", value, low, high, error=SimulationError, place=f"sensor.{place}")


@dataclass(frozen=True, eq=False)
class Readout:
    """The skin that is read, with tick and seed.

    Attributes:
        skin: The skin.
        tick: Time between readings [s].
        seed: Seed of all random numbers, >= 0.
        averages: Whether a sample is the mean since the previous one.
        channel: Channel of the taxels: 0 for pressure, 1 and 2 for shear along t1 and t2, which has both signs. Random
            numbers of channels are independent, but the broken taxels are the same.

    Raises:
        SimulationError: Tick or seed is out of range.
    """

    skin: Skin
    tick: float
    seed: int
    averages: bool = False
    channel: int = 0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.tick) and self.tick > 0):
            raise SimulationError("the tick must be positive", place="tick", value=f"{self.tick} s")
        if self.seed < 0:
            raise SimulationError("a seed cannot be negative", place="seed", value=self.seed, remedy="Choose 0 or more")

    def stream(self, effect: str) -> np.random.Generator:
        """Return a new random stream of an effect, independent of other effects."""
        own = [self.channel] if self.channel and effect != "dead_taxels" else []
        seeds = np.random.SeedSequence([self.seed, crc32(effect.encode()), *own])
        return np.random.Generator(np.random.SFC64(seeds))  # normal numbers are a fifth faster than with PCG64


class SensorStage(ABC):
    """Stage of one effect. A stage with state implements ``reset`` and ``state``."""

    @abstractmethod
    def read(self, pressures: FloatArray) -> FloatArray:
        """Return the output (taxels,) [Pa] for an input, one tick after the last call; the input is not changed."""

    def reset(self) -> None:  # noqa: B027 - most stages have no state
        """Return to the state before the first reading, random numbers included."""

    def state(self) -> FloatArray:
        """Return the complete state (k,); with spec and readout it determines all later readings, bit for bit."""
        return np.zeros(0)


class BuiltInStage(SensorStage):
    """Stage of an effect with settings.

    Args:
        spec: Settings of the effect.
        readout: Skin, tick and seed.
    """

    def __init__(self, spec: Any, readout: Readout) -> None:
        self._spec = spec
        self._readout = readout


@dataclass(frozen=True)
class SensorEffect:
    """Settings of one effect, with their ranges and the stage that applies them.

    Raises:
        SimulationError: A setting is out of range.
    """

    key: ClassVar[str]
    ranges: ClassVar[tuple[tuple[str, float, float], ...]]
    stage: ClassVar[type[BuiltInStage]]

    def __post_init__(self) -> None:
        for name, low, high in self.ranges:
            check_setting(f"{self.key}.{name}", getattr(self, name), low, high)


@dataclass(frozen=True)
class AreaAveraging(SensorEffect):
    """Each taxel reads the mean pressure over a disc around it; pressure between the pads is not measured.

    A receptive field, not a stage: the contact model applies it (``tactile_maps.tactile.mechanics.receptive_field``).

    Attributes:
        radius: Radius of the pad [m], 0.1 to 50 mm; ROBOSKIN has 1.9 mm.
    """

    key = "area_averaging"
    ranges = (("radius", 1e-4, 0.05),)

    radius: float = 0.0019


@dataclass(frozen=True)
class Misorientation(SensorEffect):
    """The frame of each three-axis taxel is rotated against the stated one, drawn once.

    Not a stage: it turns the three channels into each other, see ``axis_matrices``.

    Attributes:
        sd: Standard deviation of the rotation about each axis of the frame [rad], 0 to 0.5.
    """

    key = "misorientation"
    ranges = (("sd", 0.0, 0.5),)

    sd: float = 0.03


@dataclass(frozen=True)
class AxisCrosstalk(SensorEffect):
    """Each channel of a three-axis taxel reads shares of the other two: a 3 x 3 matrix with ones on its diagonal.

    Not a stage, like ``Misorientation``. A calibration with the inverse matrices removes it.

    Attributes:
        sd: Standard deviation of the shares, 0 to 0.3.
    """

    key = "axis_crosstalk"
    ranges = (("sd", 0.0, 0.3),)

    sd: float = 0.02


def axis_matrices(effects: SensorEffects, readout: Readout) -> FloatArray | None:
    """Return the matrices (taxels, 3, 3) from true shear along t1 and t2 and pressure to what the channels measure.

    They are the identity for one-axis taxels. None if neither effect is on.
    """
    turned = effects.misorientation
    mixed = effects.axis_crosstalk
    if turned is None and mixed is None:
        return None
    count = len(readout.skin)
    matrices = np.tile(np.eye(3), (count, 1, 1))
    if turned is not None:
        turns = turned.sd * readout.stream(turned.key).standard_normal((count, 3))
        matrices = Rotation.from_rotvec(turns).as_matrix().reshape(count, 3, 3)
    if mixed is not None:
        shares = mixed.sd * readout.stream(mixed.key).standard_normal((count, 3, 3))
        shares[:, range(3), range(3)] = 1.0
        matrices = shares @ matrices
    return np.asarray(np.where((readout.skin.axes == 3)[:, None, None], matrices, np.eye(3)))


class CrosstalkStage(BuiltInStage):
    """Conserves force exactly: the sum of pressure times area is unchanged. A taxel without neighbours keeps its force.

    What is lost: an even pressure does not stay quite even where taxels differ in area or number of neighbours; on the
    arm's 300 taxels a share of 5 % leaves it within 2 %, the standard deviation is 0.7 %. Cost at 1,000 taxels: 4.6 µs.
    """

    def __init__(self, spec: Crosstalk, readout: Readout) -> None:
        super().__init__(spec, readout)
        self._matrix = crosstalk_matrix(readout.skin, spec.share)

    def read(self, pressures: FloatArray) -> FloatArray:
        return np.asarray(self._matrix @ pressures)


@dataclass(frozen=True)
class Crosstalk(SensorEffect):
    """Each taxel passes a share of its force to its neighbours.

    Attributes:
        share: Total share that is passed, in equal parts to all neighbours, 0 to 0.9.
    """

    key = "crosstalk"
    ranges = (("share", 0.0, 0.9),)
    stage = CrosstalkStage

    share: float = 0.05


def crosstalk_matrix(skin: Skin, share: float) -> csr_array:
    """Return the readings of all taxels (rows) for one unit of pressure on each taxel (columns), (taxels, taxels)."""
    count = len(skin)
    giver, taker = np.concatenate([skin.neighbours, skin.neighbours[:, ::-1]]).T
    degree = np.bincount(giver, minlength=count)
    kept = np.where(degree > 0, 1.0 - share, 1.0)
    parts = share / degree[giver] * skin.areas[giver] / skin.areas[taker]
    own = np.arange(count)
    entries = (np.concatenate([kept, parts]), (np.concatenate([own, taker]), np.concatenate([own, giver])))
    return csr_array(entries, shape=(count, count))


_LEAST = 1e-30
"""Pressure [Pa] below which decayed values are set to 0: subnormal numbers would be a hundred times slower."""


class HysteresisStage(BuiltInStage):
    """A step of pressure p that begins at a reading reads p (1 - share exp(-t / seconds)) from there on.

    Exact at every tick, however long, for a pressure that holds from one reading to the next. Cost at 1,000 taxels:
    4.4 µs.
    """

    def __init__(self, spec: Hysteresis, readout: Readout) -> None:
        super().__init__(spec, readout)
        self._share = spec.share
        self._gain = -math.expm1(-readout.tick / spec.seconds)
        self._late = np.zeros(len(readout.skin))

    def read(self, pressures: FloatArray) -> FloatArray:
        lag = pressures - self._late
        out: FloatArray = pressures - self._share * lag
        lag *= self._gain
        self._late += lag
        self._late *= np.abs(self._late) >= _LEAST
        return out

    def reset(self) -> None:
        self._late[:] = 0.0

    def state(self) -> FloatArray:
        """Return the delayed part so far (taxels,) [Pa]."""
        return self._late.copy()


@dataclass(frozen=True)
class Hysteresis(SensorEffect):
    """First-order creep of the cover (a spring in parallel with a spring and damper in series).

    Attributes:
        share: Share of the pressure that is delayed, 0 to 1.
        seconds: Its time constant [s], 1 ms to 10,000 s.
    """

    key = "hysteresis"
    ranges = (("share", 0.0, 1.0), ("seconds", 1e-3, 1e4))
    stage = HysteresisStage

    share: float = 0.1
    seconds: float = 1.0


class GainSpreadStage(BuiltInStage):
    """Stage with log-normal gains: their mean is 1, their standard deviation ``sd``, and none is negative.

    Cost at 1,000 taxels: 0.5 µs.
    """

    def __init__(self, spec: GainSpread, readout: Readout) -> None:
        super().__init__(spec, readout)
        spread = math.log1p(spec.sd**2)
        drawn = readout.stream("gain_spread").standard_normal(len(readout.skin))
        self._gains = np.exp(math.sqrt(spread) * drawn - 0.5 * spread)

    def read(self, pressures: FloatArray) -> FloatArray:
        return pressures * self._gains


@dataclass(frozen=True)
class GainSpread(SensorEffect):
    """Each taxel has its own gain, drawn once.

    Attributes:
        sd: Standard deviation of the gains around 1, 0 to 1.
    """

    key = "gain_spread"
    ranges = (("sd", 0.0, 1.0),)
    stage = GainSpreadStage

    sd: float = 0.1


class OffsetDriftStage(BuiltInStage):
    """Stage whose offsets have the variance sd² + walk² t at a time t after the first reading, for any tick.

    Nothing pulls them back: in an hour the walk of the default adds 1.2 kPa. Cost at 1,000 taxels: 8.9 µs.
    """

    def __init__(self, spec: OffsetDrift, readout: Readout) -> None:
        super().__init__(spec, readout)
        self._step = spec.walk * math.sqrt(readout.tick)
        self._walked = np.empty(len(readout.skin))
        self.reset()

    def read(self, pressures: FloatArray) -> FloatArray:
        out = pressures + self._offsets
        self._random.standard_normal(out=self._walked)
        self._walked *= self._step
        self._offsets += self._walked
        self._readings += 1
        return out

    def reset(self) -> None:
        self._random = self._readout.stream("offset_drift")
        self._offsets = self._spec.sd * self._random.standard_normal(len(self._walked))
        self._readings = 0

    def state(self) -> FloatArray:
        """Number of readings so far (the position in the random sequence), then the offsets [Pa] (1 + taxels,)."""
        return np.concatenate([[self._readings], self._offsets])


@dataclass(frozen=True)
class OffsetDrift(SensorEffect):
    """Each taxel has its own offset, which takes a random walk.

    Attributes:
        sd: Standard deviation of the offsets at the start [Pa], 0 to 1 MPa.
        walk: Standard deviation of the change within one second [Pa/sqrt(s)], 0 to 1 MPa.
    """

    key = "offset_drift"
    ranges = (("sd", 0.0, 1e6), ("walk", 0.0, 1e6))
    stage = OffsetDriftStage

    sd: float = 100.0
    walk: float = 20.0


class NoiseStage(BuiltInStage):
    """Stage that adds normal noise; readings may become negative. Cost at 1,000 taxels: 8.4 µs."""

    def __init__(self, spec: Noise, readout: Readout) -> None:
        super().__init__(spec, readout)
        self._drawn = np.empty(len(readout.skin))
        self.reset()

    def read(self, pressures: FloatArray) -> FloatArray:
        self._random.standard_normal(out=self._drawn)
        self._drawn *= self._spec.sd
        self._readings += 1
        return pressures + self._drawn

    def reset(self) -> None:
        self._random = self._readout.stream("noise")
        self._readings = 0

    def state(self) -> FloatArray:
        """Number of readings so far (1,): the position in the random sequence."""
        return np.array([float(self._readings)])


@dataclass(frozen=True)
class Noise(SensorEffect):
    """White normal noise of each taxel, drawn at every reading.

    Attributes:
        sd: Standard deviation [Pa], 0 to 1 MPa.
    """

    key = "noise"
    ranges = (("sd", 0.0, 1e6),)
    stage = NoiseStage

    sd: float = 100.0


class SaturationStage(BuiltInStage):
    """Clips at ``at``, shear in both directions."""

    def read(self, pressures: FloatArray) -> FloatArray:
        """Return the clipped pressures."""
        most = self._spec.at
        return np.clip(pressures, -most, most) if self._readout.channel else np.minimum(pressures, most)


@dataclass(frozen=True)
class Saturation(SensorEffect):
    """Readings are limited to a maximum.

    Attributes:
        at: The highest reading [Pa], 1 Pa to 1 GPa; ROBOSKIN has 180 kPa.
    """

    key = "saturation"
    ranges = (("at", 1.0, 1e9),)
    stage = SaturationStage

    at: float = 180e3


class ThresholdStage(BuiltInStage):
    """Stage that reads zero below the threshold, so that a light touch spread over many taxels is lost.

    Cost at 1,000 taxels: 1.7 µs.
    """

    def read(self, pressures: FloatArray) -> FloatArray:
        sizes = np.abs(pressures) if self._readout.channel else pressures
        return np.where(sizes < self._spec.at, 0.0, pressures)


@dataclass(frozen=True)
class Threshold(SensorEffect):
    """Dead zone without hysteresis: pressures below the threshold read 0, all others are unchanged.

    Attributes:
        at: Lowest pressure that is read [Pa], 0 to 1 MPa; ROBOSKIN has 2 to 3 kPa.
    """

    key = "threshold"
    ranges = (("at", 0.0, 1e6),)
    stage = ThresholdStage

    at: float = 2500.0


class QuantisationStage(BuiltInStage):
    """Rounds to the nearest step, ties to the even one, so that the error is at most half a step.

    The saturation may be exceeded by that much if it is not a whole number of steps. Cost at 1,000 taxels: 2.3 µs.
    """

    def read(self, pressures: FloatArray) -> FloatArray:
        steps = np.rint(pressures / self._spec.step)
        steps *= self._spec.step
        steps += 0.0  # avoids -0
        return steps


@dataclass(frozen=True)
class Quantisation(SensorEffect):
    """Readings are multiples of a step.

    Attributes:
        step: Resolution of the converter [Pa], 1 mPa to 1 MPa.
    """

    key = "quantisation"
    ranges = (("step", 1e-3, 1e6),)
    stage = QuantisationStage

    step: float = 200.0


ALIVE, DEAD, STUCK = range(3)
"""States of a taxel."""


class DeadTaxelsStage(BuiltInStage):
    """Stage with a rounded number of broken taxels; a larger share includes the same ones and more.

    Cost at 1,000 taxels: 0.7 µs.

    Attributes:
        codes: (taxels,) int8, ``ALIVE``, ``DEAD`` or ``STUCK``.
    """

    def __init__(self, spec: DeadTaxels, readout: Readout) -> None:
        super().__init__(spec, readout)
        count = len(readout.skin)
        dead = round(spec.dead * count)
        stuck = min(round(spec.stuck * count), count - dead)
        order = readout.stream("dead_taxels").permutation(count)
        self._dead = order[:dead]
        self._stuck = order[count - stuck :]
        codes = np.full(count, ALIVE, dtype=np.int8)
        codes[self._dead] = DEAD
        codes[self._stuck] = STUCK
        self.codes = readonly(codes, np.int8)

    def read(self, pressures: FloatArray) -> FloatArray:
        out = pressures.copy()
        out[self._dead] = 0.0
        out[self._stuck] = self._spec.stuck_at
        return out


@dataclass(frozen=True)
class DeadTaxels(SensorEffect):
    """Some taxels, drawn once at random, always read zero or another constant value.

    Attributes:
        dead: Share of the taxels that read 0.
        stuck: Share of the taxels that read ``stuck_at``; with ``dead`` at most 1.
        stuck_at: Reading of the stuck taxels [Pa], 0 to 1 GPa.
    """

    key = "dead_taxels"
    ranges = (("dead", 0.0, 1.0), ("stuck", 0.0, 1.0), ("stuck_at", 0.0, 1e9))
    stage = DeadTaxelsStage

    dead: float = 0.02
    stuck: float = 0.0
    stuck_at: float = 20e3

    def __post_init__(self) -> None:
        super().__post_init__()
        check_setting("dead_taxels, dead and stuck together", self.dead + self.stuck, 0.0, 1.0 + 1e-9)


class SamplingStage(BuiltInStage):
    """Stage that takes sample j at the tick nearest to j / rate, the first at the first reading, without drift.

    With time averaging a sample is the mean of the readings since the previous one. The delay is rounded to whole
    ticks. A rate above that of the ticks samples at every tick. Until the first sample arrives, taxels read 0. Cost at
    1,000 taxels: 0.5 µs.
    """

    def __init__(self, spec: Sampling, readout: Readout) -> None:
        super().__init__(spec, readout)
        self._period = max(1.0 / (spec.rate * readout.tick), 1.0)
        self._delay = round(spec.delay / readout.tick)
        self._taxels = len(readout.skin)
        self._averages = readout.averages
        self._sum: FloatArray
        self._summed: int
        self._next: int
        self.reset()

    def read(self, pressures: FloatArray) -> FloatArray:
        if self._averages:
            self._sum += pressures
            self._summed += 1
        if self._reading == self._next:
            if self._averages:
                pressures = self._sum / self._summed
                self._sum = np.zeros(self._taxels)
                self._summed = 0
            self._on_the_way.append((self._reading + self._delay, readonly(pressures)))
            self._taken += 1
            self._next = round(self._taken * self._period)
        if self._on_the_way and self._on_the_way[0][0] <= self._reading:
            self._held = self._on_the_way.popleft()[1]
        self._reading += 1
        return self._held

    def reset(self) -> None:
        self._reading = 0
        self._taken = 0
        self._next = 0
        self._held = readonly(np.zeros(self._taxels))
        self._sum = np.zeros(self._taxels)
        self._summed = 0
        self._on_the_way: deque[tuple[int, FloatArray]] = deque()

    def state(self) -> FloatArray:
        """(2 + k + (1 + k) taxels,) readings made, samples taken, what is read [Pa], arrivals and samples on the way;
        with time averaging (1 + taxels,) more, the sum and number of the readings since the last sample.

        Samples on the way fill k places, the largest possible number; empty ones arrive at -1.
        """
        places = math.floor(self._delay / self._period) + 2
        arrivals = np.full(places, -1.0)
        samples = np.zeros((places, self._taxels))
        for place, (arrival, sample) in enumerate(self._on_the_way):
            arrivals[place] = arrival
            samples[place] = sample
        sums = [self._sum, [self._summed]] if self._averages else []
        return np.concatenate([[self._reading, self._taken], self._held, arrivals, samples.ravel(), *sums])


@dataclass(frozen=True)
class Sampling(SensorEffect):
    """The skin is sampled at its own rate, samples arrive with a delay, and the last one is held until the next.

    Attributes:
        rate: Samples per second [Hz], 0.1 to 10,000.
        delay: Time from a sample to its arrival [s], 0 to 1.
    """

    key = "sampling"
    ranges = (("rate", 0.1, 1e4), ("delay", 0.0, 1.0))
    stage = SamplingStage

    rate: float = 50.0
    delay: float = 0.02


@dataclass(frozen=True)
class PluginEffect:
    """A selected effect of a plug-in, as recorded and as built by ``sensor_chain``.

    Attributes:
        name: Name of its entry.
        options: (name, number) of every option, in the entry's order.
    """

    name: str
    options: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class SensorEffects:
    """Settings of each effect, or None if it is off. The fields are in the order of the signal.

    Attributes:
        plug_ins: Selected effects of plug-ins; their entries state their positions in the signal.
    """

    area_averaging: AreaAveraging | None = None
    misorientation: Misorientation | None = field(default=None, metadata=LATER)
    axis_crosstalk: AxisCrosstalk | None = field(default=None, metadata=LATER)
    crosstalk: Crosstalk | None = None
    hysteresis: Hysteresis | None = None
    gain_spread: GainSpread | None = None
    offset_drift: OffsetDrift | None = None
    noise: Noise | None = None
    saturation: Saturation | None = None
    threshold: Threshold | None = None
    quantisation: Quantisation | None = None
    dead_taxels: DeadTaxels | None = None
    sampling: Sampling | None = None
    plug_ins: tuple[PluginEffect, ...] = field(default=(), metadata=LATER)

    def of(self, key: str) -> Any:
        """Return the settings of an effect, built in or of a plug-in; None if it is off."""
        if key in SENSOR_KEYS:
            return getattr(self, key)
        return next((effect for effect in self.plug_ins if effect.name == key), None)

    @property
    def axis_errors(self) -> dict[str, float]:
        """Standard deviation of the share of one channel of a taxel that another one reads, by key of the effect."""
        return {effect.key: effect.sd for effect in (self.misorientation, self.axis_crosstalk) if effect is not None}

    @property
    def stages(self) -> SensorEffects:
        """The effects that are stages of the chain."""
        return replace(self, area_averaging=None, misorientation=None, axis_crosstalk=None)

    def without(self, key: str) -> SensorEffects:
        """Return the effects with one switched off."""
        if key in SENSOR_KEYS:
            off: dict[str, Any] = {key: None}
            return replace(self, **off)
        return replace(self, plug_ins=tuple(effect for effect in self.plug_ins if effect.name != key))


SENSOR_KEYS: tuple[str, ...] = tuple(field.name for field in fields(SensorEffects) if field.name != "plug_ins")
"""The built-in effects in the order of the signal."""
STAGE_KEYS = tuple(key for key in SENSOR_KEYS if key not in ("area_averaging", "misorientation", "axis_crosstalk"))
"""The built-in effects that are stages of the sensor chain, in the order of the signal."""
