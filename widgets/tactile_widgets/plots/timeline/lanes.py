"""Lanes of the plots over a whole recording: standard lanes and lanes that the user added. No Qt."""

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
    """Curve over time.

    Attributes:
        title: Title with unit, for example "Contact force (N)".
        unit: Unit of the drawn values; empty if there is none.
        column: Column of the values.
        factor: Conversion factor from SI to ``unit``.
        floor: Lower bound of the axis maximum [unit]; None for a curve that can be negative.
        always: Whether it is shown even if it has no finite values.
    """

    title: str
    unit: str
    column: int
    factor: float
    floor: float | None
    always: bool = False


def standard_lanes(units: ReadingUnits) -> tuple[Lane, ...]:
    """Return the lanes of force, pressure and the error on the map."""
    return (
        Lane(units.strength_title, units.force or "relative", CURVES.index("force"), 1.0, 1.0, always=True),
        Lane(peak_title(units), units.unit, CURVES.index("peak"), 1e-3, 1.0),
        Lane("Error on the map (mm)", "mm", CURVES.index("error"), 1e3, 1.0),
    )


@dataclass(frozen=True)
class AddedLane:
    """Lane that the user added.

    Attributes:
        key: Plot that it corresponds to.
        quantity: Quantity that is read from each frame.
        unit: Unit of the drawn values.
        factor: Conversion factor from SI to ``unit``.
        signed: Whether it can be negative.
    """

    key: PlotKey
    quantity: FrameQuantity
    unit: str
    factor: float = 1.0
    signed: bool = False

    def lane(self, column: int) -> Lane:
        """Return the lane for this column of the values."""
        title = f"{self.key.title} ({self.unit})"
        return Lane(title, self.unit, column, self.factor, None if self.signed else 1.0, always=True)


OVER_A_RECORDING = frozenset(
    {
        PlotKind.FORCE,
        PlotKind.PRESSURE,
        PlotKind.ERROR,
        PlotKind.TAXEL,
        PlotKind.LINK,
        PlotKind.JOINT,
        PlotKind.JOINT_SPEED,
        PlotKind.GROUP_FORCE,
        PlotKind.GROUP_PRESSURE,
        PlotKind.RASTER,
        PlotKind.SHEAR,
        PlotKind.FRICTION,
    }
)
"""Kinds of plots that can be shown over a whole recording."""


def added_lanes(keys: Iterable[PlotKey], prepared: PreparedScene, units: ReadingUnits) -> tuple[AddedLane, ...]:
    """Return the lanes of added plots for a recording of ``prepared``; quantities that it does not have are omitted."""
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
        case PlotKind.SHEAR if units.force and prepared.skin.three_axis.any():
            return AddedLane(key, FrameQuantity(QuantityKind.SHEAR_FORCE), units.force)
        case PlotKind.FRICTION if prepared.skin.three_axis.any():
            return AddedLane(key, FrameQuantity(QuantityKind.FRICTION_IN_USE), "%", 100.0)
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
