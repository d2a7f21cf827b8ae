"""Calibration of a connected skin with known weights, step by step, with undo."""

from __future__ import annotations

from dataclasses import replace

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import Calibration, FallingReadingsError
from tactile_maps.live.calibration.weighing import RecentReadings, Weighing, WeighingState
from tactile_maps.live.session.session_clock import SessionClock
from tactile_maps.live.session.skin_readings import CalibrationStep, SkinReadings


class KnownWeights:
    """Calibrations of a skin with known weights. Mutable.

    Args:
        readings: Values and calibration of the skin.
        areas: (taxels,) areas of the taxels [m²].
        clock: Session time of the readings.
    """

    def __init__(self, readings: SkinReadings, areas: FloatArray, clock: SessionClock) -> None:
        self._readings = readings
        self._areas = areas
        self._clock = clock
        self._weighing: Weighing | None = None
        self._recent: RecentReadings | None = None
        self._state = WeighingState()
        self._negative: tuple[Calibration, float] | None = None
        self._undo: list[CalibrationStep] = []

    @property
    def state(self) -> WeighingState:
        """Progress of the newest calibration."""
        left = None if self._weighing is None else self._weighing.left(self._clock.time)
        return replace(self._state, left=left, undoable=bool(self._undo))

    def remember(self, seconds: float) -> None:
        """Keep the readings of the last ``seconds`` [s] for ``weigh``; raises LiveError if that is out of range."""
        self._recent = RecentReadings(seconds)

    def weigh(self, mass: float) -> Calibration:
        """Calibrate with a known weight [kg] that is on the skin now; return the new calibration.

        Uses the mean of the readings kept by ``remember``, otherwise the newest reading.

        Raises:
            LiveError: The readings do not change by more than noise, the weight is not at rest, or the skin was not
                tared.
        """
        self._check_tared()
        before = self._readings.calibration
        change = self._readings.change if self._recent is None else self._recent.mean(before.slope * self._areas)
        after = before.with_weight(change, self._areas, mass, noise=self._readings.deviations)
        self._undo.append(self._readings.calibrate(after))
        return after

    def begin(self, mass: float, seconds: float, *, taxels: IntArray | None = None) -> None:
        """Calibrate with a known weight on the skin, by the mean of the next readings.

        ``state`` contains the progress; ``undo`` restores the previous calibration.

        Args:
            mass: Mass of the weight [kg].
            seconds: Time over which readings are averaged [s], at most 60.
            taxels: (k,) taxels under the weight: only their readings count, see ``Calibration.with_weight``; None for
                any.

        Raises:
            LiveError: The skin was not tared, or mass, time or taxels are invalid.
        """
        self._check_tared()
        self._weighing = Weighing(mass, seconds, taxels, self._clock.time)
        self.forget()

    def cancel(self) -> None:
        """End a running calibration; the skin keeps its present one."""
        self._weighing = None

    def forget(self) -> None:
        """Forget the factor or problem of the newest calibration, and its negative gains; a running one continues."""
        self._state = WeighingState()
        self._negative = None

    def undo(self) -> None:
        """Restore the calibration before the newest weight, and end a running one."""
        self._weighing = None
        self.forget()
        if self._undo:
            self._readings.restore(self._undo.pop())

    def apply_negative_gain(self) -> None:
        """Use the negative gains of a weight under which the readings fell; does nothing without one."""
        if self._negative is None:
            return
        calibration, factor = self._negative
        self._negative = None
        self._undo.append(self._readings.calibrate(calibration))
        self._state = WeighingState(factor=factor)

    def add_reading(self) -> None:
        """Use the newest reading for a running calibration and for ``weigh``."""
        self._take_weighing()
        if self._recent is not None and self._readings.tared:
            self._recent.add(self._readings.change, self._clock.time)

    def _take_weighing(self) -> None:
        if self._weighing is None or not self._weighing.add(self._readings.change, self._clock.time):
            return
        weighing = self._weighing
        self._weighing = None
        before = self._readings.calibration
        noise = self._readings.deviations
        try:
            calibration, factor = weighing.calibrated(before, self._areas, noise)
        except FallingReadingsError as error:
            calibration, factor = weighing.calibrated(before.inverted, self._areas, noise)
            self._negative = calibration, -factor
            self._state = WeighingState(problem=str(error), falling=True)
        except LiveError as error:
            self._state = WeighingState(problem=str(error))
        else:
            self._undo.append(self._readings.calibrate(calibration))
            self._state = WeighingState(factor=factor)

    def _check_tared(self) -> None:
        if not self._readings.tared:
            raise LiveError("the skin was not tared", remedy="Tare it untouched, then add the weight")
