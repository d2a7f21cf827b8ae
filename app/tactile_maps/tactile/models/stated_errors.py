"""Stated errors of contact models, which tests verify. No other place states them.

Errors are those of the model alone, for one load that is on the skin as a whole. The part of a load on bare surface,
if more than 1 %, and the ratio of readings to force on bent skin are stated by notes of each contact. Contacts are
reported from a threshold of pressure on: force that stays below it on every taxel is read, but it is not part of any
contact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class StatedError:
    """Largest error of one contact model.

    Attributes:
        force: Share by which the sum of pressure times area may differ from the force; 0 for exact to rounding.
        centre: Distance of the centre of pressure from that of the load, in spacings of the taxels: the square root of
            their mean area. Even exact pressures have an error, since a taxel reads a mean over its area.
        pressure: Share of the force that is read on wrong taxels, at the depth of the taxels below the cover.
    """

    force: float
    centre: float
    pressure: float

    def of(self, output: str) -> str:
        """Return the error of one output of a scene in words."""
        if output == "force":
            return f"force within {100 * self.force:.2g} %" if self.force else "force exact"
        if output == "centre_of_pressure":
            return f"centre within {self.centre:g} taxel spacings"
        return f"up to {100 * self.pressure:.2g} % of the force on wrong taxels"


STATED_ERRORS: Mapping[str, StatedError] = MappingProxyType(
    {
        "point": StatedError(force=0.0, centre=0.75, pressure=0.9),
        "water-fill": StatedError(force=0.0, centre=0.6, pressure=0.2),
        "punch": StatedError(force=0.0, centre=0.45, pressure=0.6),
        "half-space": StatedError(force=0.0, centre=0.5, pressure=0.04),
        "foundation": StatedError(force=0.05, centre=0.6, pressure=0.2),
        "depth": StatedError(force=1.0, centre=1.0, pressure=1.0),
    }
)
"""Stated errors by contact model. The pressure error of ``punch`` exceeds 0.2 only for a force outside the middle of a
contact: the reference, the half-space, does not include that moment."""


def stated_error_text(model: str, outputs: Sequence[str]) -> str:
    """Return the stated errors of ``model`` for some of a scene's tactile outputs; empty for a model without any."""
    stated = STATED_ERRORS.get(model)
    return "" if stated is None else ", ".join(dict.fromkeys(map(stated.of, outputs)))
