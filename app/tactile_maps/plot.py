"""Plots of maps, pressures, contacts and forces with matplotlib, for notebooks and papers.

Every function draws on the given Axes, or on those of a new figure, and returns them. Lengths are in millimetres in the
coordinates of the map, pressures in kPa. matplotlib is imported when the first plot is drawn.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BORDER = "0.35"
_SEAM = "tab:purple"
_TAXEL = "0.55"
_CONTACT = "tab:blue"


def draw_map(
    map_: TactileMap,
    pressures: FloatArray | None = None,
    *,
    contacts: Sequence[ContactRegion] = (),
    full_scale: float | None = None,
    width: int = 512,
    units: ReadingUnits = ReadingUnits.CALIBRATED,
    ax: Axes | None = None,
) -> Axes:
    """Draw a map: borders, seams (dashed), taxels, pressures and contacts.

    Args:
        map_: The map.
        pressures: (taxels,) [Pa], shown as the tactile image with its colour bar; None for the bare map.
        contacts: Contacts to mark, see ``draw_contacts``.
        full_scale: Pressure of the brightest colour [kPa]; by default the highest pressure.
        width: Pixels of the image along its longer side.
        units: Units of pressures and forces: ``frame.units``.
        ax: Axes to draw on; by default those of a new figure.

    Returns:
        The Axes; their ``figure`` has ``savefig``.

    Raises:
        MapError: The number of pressures is not the number of taxels.

    Example:
        >>> pressures = tm.press_skin(skin, skin.taxel_point(30))
        >>> ax = tm.draw_map(tactile_map, pressures, contacts=tm.read_contacts(tactile_map, pressures))
        >>> ax.get_xlabel()
        'map x [mm]'

    Cost: 0.1 s, most of it to build the image.
    """
    ax = _axes(ax)
    if pressures is not None:
        _draw_pressures(map_, np.asarray(pressures, dtype=np.float64), full_scale, width, units, ax)
    for patch, outline, seams in zip(map_.skin.patches, map_.outlines, map_.seams, strict=True):
        closed = 1e3 * np.concatenate([outline, outline[:1]])
        ax.plot(closed[:, 0], closed[:, 1], color=_BORDER, linewidth=0.8)
        for seam in seams:
            ax.plot(1e3 * seam[:, 0], 1e3 * seam[:, 1], color=_SEAM, linewidth=1.0, linestyle="--")
        middle = 0.5 * (closed[:, 0].min() + closed[:, 0].max())
        top = closed[:, 1].max()
        ax.annotate(patch.name, (middle, top), (0, 3), textcoords="offset points", ha="center", fontsize="small")
    taxels = 1e3 * map_.taxel_points
    ax.plot(taxels[:, 0], taxels[:, 1], ".", color=_TAXEL, markersize=1.5)
    draw_contacts(contacts, units=units, ax=ax)
    ax.set_aspect("equal")
    ax.set_xlabel("map x [mm]")
    ax.set_ylabel("map y [mm]")
    return ax


def draw_contacts(
    contacts: Sequence[ContactRegion],
    *,
    units: ReadingUnits = ReadingUnits.CALIBRATED,
    ax: Axes | None = None,
) -> Axes:
    """Mark contacts on a map: centre of pressure, the ellipse with the region's second moments, and the force.

    Args:
        contacts: Contacts of one reading.
        units: Units of the forces: ``frame.units``.
        ax: Axes to draw on, usually those of ``draw_map``; by default those of a new figure.

    Example:
        >>> ax = tm.draw_map(tactile_map)
        >>> ax = tm.draw_contacts(session.frame.regions, ax=ax)
    """
    ax = _axes(ax)
    turn = np.linspace(0, 2 * np.pi, 65)
    for contact in contacts:
        x, y = 1e3 * contact.map_point
        ellipse = np.outer(np.cos(turn), contact.map_axes[0]) + np.outer(np.sin(turn), contact.map_axes[1])
        ax.plot(x + 1e3 * ellipse[:, 0], y + 1e3 * ellipse[:, 1], color=_CONTACT, linewidth=1.2)
        ax.plot([x], [y], "+", color=_CONTACT)
        label = units.contact_words(contact.force, contact.peak, 2, space=" ")
        ax.annotate(label, (x, y), (6, 6), textcoords="offset points", color=_CONTACT, fontsize="small")
    return ax


def draw_forces(frames: Iterable[Frame], *, ax: Axes | None = None) -> Axes:
    """Draw the force of every contact over time, one line per contact; without a unit for uncalibrated readings.

    Args:
        frames: Frames of a session or a recording (``open_recording`` returns them in order).
        ax: Axes to draw on; by default those of a new figure.

    Example:
        >>> ax = tm.draw_forces(tm.open_recording("touch.mcap"))
        >>> ax.get_ylabel()
        'force [N]'
    """
    ax = _axes(ax)
    lines: dict[int, tuple[str, list[float], list[float]]] = {}
    known = True
    for frame in frames:
        known &= frame.units.force is not None
        for contact in frame.regions:
            _, times, forces = lines.setdefault(contact.id, (contact.link, [], []))
            times.append(frame.time)
            forces.append(contact.force)
    for number, (link, times, forces) in lines.items():
        ax.plot(times, forces, ".-", markersize=3, label=f"contact {number} on {link}")
    if lines:
        ax.legend(fontsize="small")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("force [N]" if known else "strength (relative)")
    return ax


def _draw_pressures(
    map_: TactileMap, pressures: FloatArray, full_scale: float | None, width: int, units: ReadingUnits, ax: Axes
) -> None:
    if pressures.shape != (len(map_.skin),):
        remedy = f"Give one number for each of the {len(map_.skin)} taxels"
        raise MapError("the pressures do not fit this skin", value=f"shape {pressures.shape}", remedy=remedy)
    image = TactileImage(map_, width=width)
    (left, bottom), (right, top) = 1e3 * image.extent
    values = np.ma.masked_where(~image.shown, image.render(pressures))
    brightest = max(1e-3 * float(pressures.max(initial=0.0)), 1e-9) if full_scale is None else full_scale
    shown = ax.imshow(values, extent=(left, right, bottom, top), vmin=0.0, vmax=brightest, cmap="YlOrRd")
    ax.figure.colorbar(shown, ax=ax, label=units.axis_label, shrink=0.8)


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    from matplotlib import pyplot  # chooses a backend: imported only for a new figure

    return pyplot.subplots(layout="constrained")[1]
