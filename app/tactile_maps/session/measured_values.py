"""What a frame of a real skin has besides: the values as they were sent, and what the shown ones may be called."""

from __future__ import annotations

from dataclasses import dataclass

from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.core.reading_units import ReadingUnits


@dataclass(frozen=True, eq=False)
class MeasuredValues:
    """Of one frame.

    Attributes:
        raw: (taxels,) the newest value of each as it was sent, before offset, baseline and gain; NaN where none came.
        unit: Of ``raw``: ``counts``, ``Pa`` or ``kPa``.
        sent: By the sender's clock [s]; None before the first reading.
        sequence: Running number of the packet; None where the sender counts none.
        units: What the frame's pressures may be called.
    """

    raw: FloatArray
    unit: str
    sent: float | None
    sequence: int | None
    units: ReadingUnits

    def __post_init__(self) -> None:
        freeze_arrays(self, "raw")
