"""The lanes of the plots over a whole recording: the standard ones, and what a person added. No Qt."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.recording.overview.curves import CURVES, FrameQuantity, QuantityKind
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.plots.choice.plot_choice import PlotKey, PlotKind, TaxelGroup
from tactile_widgets.plots.traces.trace_plots import peak_title


@dataclass(frozen=True)
class Lane:
    """One curve by time.

    Attributes:
        title: With its unit, like "Contact force (N)".
        unit: Of what is drawn; empty for none.
        column: Of the curves.
        factor: From SI to ``unit``.
        floor: Its axis reaches at least so far up [unit]; None for one that goes below zero too.
        always: Whether it is shown even where it says nothing.
    """

    title: str
    unit: str
    column: int
    factor: float
    floor: float | None
    always: bool = False


def standard_lanes(units: ReadingUnits) -> tuple[Lane, ...]:
    """Force, pressure and the error on the map."""
    return (
        Lane(units.strength_title, units.force or "relative", CURVES.index("force"), 1.0, 1.0, always=True),
        Lane(peak_title(units), units.unit, CURVES.index("peak"), 1e-3, 1.0),
        Lane("Error on the map (mm)", "mm", CURVES.index("error"), 1e3, 1.0),
    )


@dataclass(frozen=True)
class AddedLane:
    """What a person added, as it can be read from a recording.

    Attributes:
        key: The plot.
        quantity: What is read of each frame.
        unit: As in ``Lane``.
        factor: The same.
        signed: Whether it goes below zero.
    """

    key: PlotKey
    quantity: FrameQuantity
    unit: str
    factor: float = 1.0
    signed: bool = False

    def lane(self, column: int) -> Lane:
        """Its lane, of this column of the curves."""
        title = f"{self.key.title} ({self.unit})"
        return Lane(title, self.unit, column, self.factor, None if self.signed else 1.0, always=True)


OVER_A_RECORDING = frozenset(
    {
        PlotKind.FORCE, PlotKind.PRESSURE, PlotKind.ERROR, PlotKind.TAXEL, PlotKind.LINK, PlotKind.JOINT,
        PlotKind.JOINT_SPEED, PlotKind.GROUP_FORCE, PlotKind.GROUP_PRESSURE,
    }
)  # fmt: skip
"""Kinds of plots whose curve can be shown over a whole recording."""


def added_lanes(keys: Iterable[PlotKey], prepared: PreparedScene, units: ReadingUnits) -> tuple[AddedLane, ...]:
    """Those of the plots that a person added, for a recording of ``prepared``; what it does not have is left out."""
    found = (_added(key, prepared, units) for key in keys)
    return tuple(lane for lane in found if lane is not None)


def _added(key: PlotKey, prepared: PreparedScene, units: ReadingUnits) -> AddedLane | None:
    match key.kind:
        case PlotKind.JOINT | PlotKind.JOINT_SPEED:
            return _of_joint(key, prepared)
        case PlotKind.LINK:
            patches = [number for number, patch in enumerate(prepared.skin.patches) if patch.link == key.of]
            quantity = FrameQuantity(QuantityKind.CONTACT_FORCE, tuple(patches))
            return AddedLane(key, quantity, units.force or "relative") if patches else None
        case PlotKind.TAXEL | PlotKind.GROUP_PRESSURE | PlotKind.GROUP_FORCE:
            return _of_taxels(key, prepared, units)
    return None


def _of_joint(key: PlotKey, prepared: PreparedScene) -> AddedLane | None:
    for number, joint in enumerate(prepared.robot.joints):
        if joint.name == key.of:
            speed = key.kind is PlotKind.JOINT_SPEED
            unit = ("m" if joint.slide else "rad") + ("/s" if speed else "")
            kind = QuantityKind.JOINT_SPEED if speed else QuantityKind.JOINT_POSITION
            return AddedLane(key, FrameQuantity(kind, (number,)), unit, signed=True)
    return None


def _of_taxels(key: PlotKey, prepared: PreparedScene, units: ReadingUnits) -> AddedLane | None:
    group = TaxelGroup.parse(key.of)
    taxels = (int(key.of),) if key.kind is PlotKind.TAXEL else group.taxels if group is not None else ()
    if not taxels or max(taxels) >= len(prepared.skin):
        return None
    if key.kind is PlotKind.GROUP_FORCE:
        areas = tuple(prepared.skin.areas[list(taxels)].tolist())
        quantity = FrameQuantity(QuantityKind.SKIN_FORCE, taxels, areas)
        return AddedLane(key, quantity, units.force) if units.force else None
    return AddedLane(key, FrameQuantity(QuantityKind.PEAK_PRESSURE, taxels), units.unit, 1e-3)
