"""A taxel feels through a pad of its own, smaller than the area it answers for."""

from __future__ import annotations

from dataclasses import dataclass

from app.touch.sensor.ranges import check_range


@dataclass(frozen=True)
class AreaAveraging:
    """The taxel reads the mean pressure over a disc around it; what presses between the pads is not felt.

    A receptive field rather than a stage: it is built into the contact model (``app.touch.receptive_field``).

    Attributes:
        radius: Of the pad [m], 0.1 to 50 mm; ROBOSKIN has 1.9 mm.

    Raises:
        SimulationError: The radius is out of its range.
    """

    radius: float = 0.0019

    def __post_init__(self) -> None:
        check_range("area_averaging.radius", self.radius, 1e-4, 0.05)
