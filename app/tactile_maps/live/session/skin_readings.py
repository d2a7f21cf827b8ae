"""Newest values of a skin's taxels, and their conversion to the displayed pressures: units, tare and calibration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

import numpy as np

from tactile_maps.contacts.detection.taxel_noise import TailShape, TaxelNoise, estimate_noise, tail_of_readings
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.calibration.calibration import Calibration, ValueMode
from tactile_maps.live.channels.falling_values import FallingValues
from tactile_maps.live.channels.matching import TaxelMatcher
from tactile_maps.live.channels.shear_channels import ShearChannels
from tactile_maps.live.channels.tare import Tare, TouchedTares
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit
from tactile_maps.live.session.implausible import ImplausibleValues
from tactile_maps.session.inputs import CalibrationUsed
from tactile_maps.skin.model.skin import Skin

MOST_COUNTS = 2.0**32
"""Largest plausible absolute value in counts: no converter has more bits."""
MOST_PRESSURE = 1e7
"""Largest plausible absolute pressure [Pa]: ten times the range of the strongest skins."""
USUAL_TARE = 50
"""Number of readings in a tare, also where a recording does not state it."""
_NO_TAXELS: IntArray = readonly([], np.int64)


class MatchedValues(NamedTuple):
    """Values of a reading by taxel.

    Attributes:
        taxels: (k,) taxels with a value.
        values: (k,) their values.
        sheared: (m,) taxels with complete shear.
        shear: (m, 2) their shear.
    """

    taxels: IntArray
    values: FloatArray
    sheared: IntArray
    shear: FloatArray


class CalibrationStep(NamedTuple):
    """Calibration before a change.

    Attributes:
        calibration: The calibration.
        given: The same if it was given or measured; None if it follows from the unit.
        mode: Requested quantity to display; None for the usual one.
    """

    calibration: Calibration
    given: Calibration | None
    mode: ValueMode | None


class SkinReadings:
    """Newest values of the taxels, with the calibration and the tare that convert them. Mutable.

    Args:
        skin: The skin.
        implausible: Where impossible values are counted.
        report_noise: Receives the noise of the untouched taxels, None if unknown, when it is measured and when the
            displayed quantity changes.
        table: Taxel number by the stream's id; replaces the skin's own ids.
        calibration: Calibration of the skin; None if unknown.
        mode: Displayed quantity; by default pressure if calibrated, otherwise values above the baseline.
        inverted: Whether values fall under pressure: the gain is negative where no calibration is given.
        tare_first: Whether readings in counts without a calibration count as untouched before a tare.

    Attributes:
        matcher: Assignment of values to taxels.
        shear: Shear channels of the three-axis taxels.
        falling: Detection of values that fall under pressure.
        raw: (taxels,) newest values in the sent unit; NaN where none arrived.
        unit: Unit of the newest reading; None before the first.
        noise: Noise of the untouched taxels, in displayed pressures; None if no tare measured it.
        spread: (taxels,) standard deviations in the tare, in the sent unit; None before one.
        calibration: Current calibration.
        tared: Whether there is a baseline.
        touched_in_tare: Taxels that were touched during a part of the last tare, which was left out for them.
        held_in_tare: Taxels that may have been touched during all of the last tare.

    Raises:
        LiveError: The calibration is of another skin.
    """

    def __init__(
        self,
        skin: Skin,
        implausible: ImplausibleValues,
        report_noise: Callable[[TaxelNoise | None], None],
        *,
        table: Mapping[int, int] | None,
        calibration: Calibration | None,
        mode: ValueMode | None,
        inverted: bool,
        tare_first: bool,
    ) -> None:
        if calibration is not None and len(calibration.gain) != len(skin):
            found = f"{len(calibration.gain)} taxels for {len(skin)}"
            raise LiveError("the calibration is of another skin", value=found)
        self._skin = skin
        self._implausible = implausible
        self._report_noise = report_noise
        self._requested_mode = mode
        self._inverted = inverted
        self._tare_first = tare_first
        self.matcher = TaxelMatcher(skin, table)
        self.shear = ShearChannels(skin)
        self.falling = FallingValues(skin)
        self.unit: Unit | None = None
        self._given = calibration
        self.calibration = calibration or self._plain(Unit.COUNTS)
        self._recorded: CalibrationUsed | None = None
        self._displayed: tuple[ValueMode, FloatArray] | None = None

        self._baseline = np.zeros(len(skin))
        self.tared = False
        self._tare: Tare | None = None
        self._touched_tares = TouchedTares(skin)
        self.touched_in_tare = _NO_TAXELS
        self.held_in_tare = _NO_TAXELS
        self.spread: FloatArray | None = None
        self._counts: IntArray | None = None
        self._tail = TailShape()
        self.noise: TaxelNoise | None = None
        self.reset()

    def reset(self) -> None:
        """Discard the values; calibration and baseline stay."""
        self.falling.reset()
        self.shear.reset()
        self._values = self._baseline + self.calibration.offset
        self.raw = np.full(len(self._values), np.nan)
        self._recorded = None

    def match(self, reading: Reading) -> MatchedValues:
        """Return the values of a reading by taxel.

        Raises:
            LiveError: It does not fit the skin, or a value is impossible.
        """
        falls = self.calibration.gain < 0
        taxels, values = self.matcher.match(reading, falls)
        self._check_plausible(taxels, values, reading.unit)
        if reading.shear is None:
            return MatchedValues(taxels, values, _NO_TAXELS, np.zeros((0, 2)))
        sheared, shear = self.shear.complete(*self.matcher.match_shear(reading, falls))
        self._check_plausible(np.repeat(sheared, 2), shear.ravel(), reading.unit)
        return MatchedValues(taxels, values, sheared, shear)

    def _check_plausible(self, taxels: IntArray, values: FloatArray, unit: Unit) -> None:
        most = MOST_COUNTS if unit.pascals is None else MOST_PRESSURE / unit.pascals
        beyond = np.abs(values) > most
        if beyond.any():
            row = int(beyond.argmax())
            name = self._skin.taxel_text(int(taxels[row]))
            self._implausible.refuse(
                "a value is impossible", name, f"{values[row]:g} {unit}", f"At most {most:g} {unit}"
            )

    def use_unit(self, unit: Unit) -> None:
        """Use the unit of a reading; raises MalformedReadingError if it has changed."""
        if unit is self.unit:
            return
        if self.unit is not None:
            problem = "the unit of the readings changed"
            raise MalformedReadingError(problem, value=f"{unit} after {self.unit}", remedy="Send one unit")
        self.unit = unit
        if self._given is None:
            self.calibration = self._plain(unit)

    def differ(self, matched: MatchedValues) -> BoolArray:
        """Return (k,) whether the values of a reading differ from the newest ones."""
        return np.asarray(self._values[matched.taxels] != matched.values)

    def use(self, matched: MatchedValues) -> None:
        """Use the values of a reading, also for a running tare."""
        self._values[matched.taxels] = self.raw[matched.taxels] = matched.values
        self.shear.set(matched.sheared, matched.shear)
        self._take_tare(matched)

    @property
    def mode(self) -> ValueMode:
        """Displayed quantity."""
        known = self.calibration.known
        if self._requested_mode is None or (self._requested_mode is ValueMode.PRESSURE and not known):
            return ValueMode.PRESSURE if known else ValueMode.BASELINE
        return self._requested_mode

    def request_mode(self, mode: ValueMode) -> None:
        """Change the displayed quantity from the next reading on.

        Raises:
            LiveError: Pressure is requested for an uncalibrated skin.
        """
        if mode is ValueMode.PRESSURE and not self.calibration.known and self.unit is not None:
            remedy = "Give a calibration file, or calibrate with a known weight"
            raise LiveError("counts cannot be shown as pressure", value="no calibration", remedy=remedy)
        self._requested_mode = mode
        self._use_noise()

    @property
    def units(self) -> ReadingUnits:
        """Kind of the displayed values."""
        if self.calibration.known and self.mode is ValueMode.PRESSURE:
            return ReadingUnits.CALIBRATED
        known = self.unit is not None and self.unit.pascals is not None
        return ReadingUnits.PRESSURE if known else ReadingUnits.COUNTS

    def _plain(self, unit: Unit) -> Calibration:
        """Return the calibration where none is given."""
        plain = Calibration.plain(len(self._skin), unit)
        return plain.inverted if self._inverted else plain

    @property
    def inverted(self) -> bool:
        """Whether values that fall count as pressure: the gains are negative."""
        return bool(np.median(self.calibration.gain) < 0)

    def invert(self) -> None:
        """Use gains of the opposite sign from the next reading on; the tare stays valid."""
        self._inverted = not self._inverted
        self.calibration = self.calibration.inverted
        if self._given is not None:
            self._given = self.calibration
        self.falling.reset()
        self._use_noise()

    @property
    def taring(self) -> bool:
        """Whether the baseline is being measured."""
        return self._tare is not None

    @property
    def awaits_tare(self) -> bool:
        """Whether no contact is detected because the skin was not tared."""
        return self._tare_first and self.unit is Unit.COUNTS and not (self.tared or self.calibration.known)

    def tare(self, frames: int = USUAL_TARE) -> None:
        """Use the mean of the next readings as the baseline of the untouched skin, and their spread as noise.

        No contacts are detected meanwhile.
        """
        self._tare = Tare(len(self._values), frames)
        self.shear.begin_tare(frames)
        self.falling.reset()
        self.touched_in_tare = _NO_TAXELS
        self.held_in_tare = _NO_TAXELS

    def _take_tare(self, matched: MatchedValues) -> None:
        """Add a reading to a running tare."""
        if self._tare is None:
            return
        last = self._tare.add(self._values, matched.taxels)
        self.shear.take_tare(matched.sheared)
        if not last:
            return
        pressing = np.abs(self._gains) * np.sign(self.calibration.gain)
        touched = self._touched_tares.touched(self._tare, pressing)
        mean, self.spread, self._counts = self._tare.result(touched)
        self.shear.end_tare(touched)
        self._tail = tail_of_readings(self._tare.readings(touched) * self._gains)
        baseline = mean - self.calibration.offset
        self.touched_in_tare = np.flatnonzero(touched.any(axis=0))
        levels = np.where(self._counts > 0, pressing * (baseline - self._baseline), np.nan)
        self.held_in_tare = self._touched_tares.held(levels)
        self._tare = None
        self.tared = True
        self._baseline = baseline
        self._use_noise()

    def _use_noise(self) -> None:
        """Report the noise of the untouched skin in displayed units."""
        if self.spread is None:
            return
        counts = np.full(len(self.spread), USUAL_TARE) if self._counts is None else self._counts
        self.noise = estimate_noise(self.spread * np.abs(self._gains), counts, self._tail)
        self._report_noise(self.noise)

    def calibrate(self, calibration: Calibration) -> CalibrationStep:
        """Use a calibration of this skin, and display pressures; return the previous state for ``restore``."""
        before = CalibrationStep(self.calibration, self._given, self._requested_mode)
        self.restore(CalibrationStep(calibration, calibration, ValueMode.PRESSURE))
        return before

    def restore(self, step: CalibrationStep) -> None:
        """Use the calibration before a step, and display the same quantity as then."""
        self.calibration = step.calibration
        self._given = step.given
        self._requested_mode = step.mode
        self._use_noise()

    @property
    def unknown(self) -> bool:
        """Whether neither a calibration was given nor a tare begun."""
        return self._given is None and self._tare is None and not self.tared

    def adopt(self, used: CalibrationUsed) -> None:
        """Use gains, offsets and baseline of a recording.

        Raises:
            LiveError: They are of another skin.
        """
        arrays = (used.gain, used.offset, used.baseline, used.spread, used.counts)
        if any(values is not None and values.shape != self._values.shape for values in arrays):
            found = f"{len(used.gain)} taxels for {len(self._values)}"
            remedy = "Use the skin of the recording, or give a calibration of this skin"
            raise LiveError("the recorded calibration is of another skin", value=found, remedy=remedy)
        if used.known:
            self._given = self.calibration = Calibration(used.gain, used.offset, curve=used.curve, matrix=used.matrix)
        elif (used.gain < 0).all():
            self._inverted = True
            self.calibration = self._plain(self.unit or Unit.COUNTS)
        self._baseline = used.baseline
        if used.shear_baseline is not None:
            self.shear.baseline = used.shear_baseline
        self.spread = used.spread
        self._counts = used.counts
        self._tail = TailShape(used.tail_scale, used.tail_heaviness)
        self.tared = used.spread is not None
        self._use_noise()

    def changed_calibration(self, broken: IntArray, stuck: IntArray) -> CalibrationUsed | None:
        """Return the calibration if it has changed since the last call or reset, to display a recording with another.

        Args:
            broken: (k,) numbers of broken taxels, ascending.
            stuck: (k,) numbers of those that are stuck, ascending.
        """
        now = self.calibration
        recorded = self._recorded
        mode: Literal["raw", "baseline", "kPa"] = self.mode.value
        if (
            recorded is not None
            and recorded.gain is now.gain
            and recorded.baseline is self._baseline
            and recorded.mode == mode
            and np.array_equal(recorded.broken, broken)
            and np.array_equal(recorded.stuck, stuck)
        ):
            return None
        used = CalibrationUsed(
            now.gain,
            now.offset,
            self._baseline,
            self.spread,
            now.known,
            mode,
            self._counts,
            self._tail.scale,
            self._tail.heaviness,
            broken,
            now.curve,
            self.shear.baseline if self.shear.baseline.any() else None,
            now.matrix,
            stuck,
        )
        self._baseline = used.baseline
        self._recorded = used
        return used

    @property
    def change(self) -> FloatArray:
        """(taxels,) values above those of the untouched skin, in the sent unit."""
        change = self._values - self._baseline - self.calibration.offset
        return self.calibration.independent(change, self.shear.change)[0]

    @property
    def _gains(self) -> FloatArray:
        """(taxels,) displayed pascals per unit of the readings."""
        if self.mode is ValueMode.PRESSURE:
            matrix = self.calibration.matrix
            slope = self.calibration.slope
            # Noise of all three channels, which are assumed to have as much as the first.
            return slope if matrix is None else slope * np.linalg.norm(matrix[:, 0], axis=1)
        sign = np.sign(self.calibration.gain) if self.mode is ValueMode.BASELINE else np.ones(len(self._values))
        return np.asarray(self._scale * sign)

    @property
    def deviations(self) -> FloatArray | None:
        """(taxels,) standard deviations of the untouched taxels, in the sent unit; None if no tare measured them."""
        noise = self.noise
        return None if noise is None else np.asarray(noise.scale * noise.sd / np.abs(self._gains))

    def take_rescaling(self) -> FloatArray | None:
        """Return the factors (taxels,) of the displayed values since the last call; None if they are unchanged.

        They are 0 for a change from or to raw values, which contain the offsets.
        """
        mode = self.mode
        gains = np.abs(self._gains)
        before = self._displayed
        self._displayed = (mode, gains)
        if before is None or (before[0] is mode and np.array_equal(before[1], gains)):
            return None
        raw = ValueMode.RAW in (before[0], mode)
        return np.zeros(len(gains)) if raw else np.asarray(gains / before[1])

    @property
    def _scale(self) -> float:
        """Displayed pascals per unit of the readings where no calibration is used."""
        return float(Calibration.plain(1, self.unit or Unit.COUNTS).gain[0])

    def pressures(self) -> FloatArray:
        """Return the displayed pressures (taxels,) [Pa]."""
        calibration = self.calibration
        mode = self.mode
        if self._tare is not None and mode is not ValueMode.RAW:
            return np.zeros(len(self._values))  # the skin is untouched during a tare
        if mode is ValueMode.PRESSURE and calibration.matrix is not None:
            return calibration.pressures(self.change)
        if mode is ValueMode.PRESSURE:
            return calibration.values(self._values, self._baseline, mode)
        return self._scale * calibration.values(self._values, self._baseline + calibration.offset, mode)

    def shear_tractions(self) -> FloatArray | None:
        """Return the displayed shear (taxels, 2) [Pa]; None if none was received."""
        if not self.shear.received:
            return None
        mode = self.mode
        if mode is ValueMode.RAW:
            return self._scale * np.nan_to_num(self.shear.raw)
        if self._tare is not None:
            return np.zeros_like(self.shear.raw)
        if mode is ValueMode.PRESSURE:
            change = self._values - self._baseline - self.calibration.offset
            shear = self.calibration.independent(change, self.shear.change)[1]
            return np.abs(self.calibration.slope)[:, None] * shear
        return self._scale * self.shear.change

    def notice_falling(self, pressures: FloatArray) -> None:
        """Look for displayed ``pressures`` (taxels,) that fall where the skin seems to be touched."""
        if self.tared and self._tare is None and self.mode is not ValueMode.RAW:
            self.falling.add(pressures, self.noise)
