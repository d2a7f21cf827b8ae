"""Import of another layout of the same skin, for comparison with the document or as an edit.

A saved map is adopted unchanged. A drawing has only the positions of taxels, nothing between them, and may have two of
them at one position. The map is therefore fitted to it in two edits that can be undone and corrected:
``arrange_as_drawn`` places each patch over its drawing, and ``pin_as_drawn`` pins taxels to their drawn positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError, SkinError, counted
from tactile_maps.editing.arrange import repack
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import load_document
from tactile_maps.editing.reflatten import ReflattenRequest, request_reflatten
from tactile_maps.flattening.chart import Pin
from tactile_maps.geometry.surface.closest_point import closest_point
from tactile_maps.maps.evaluation.comparison import TaxelLayout, drawn_layout
from tactile_maps.maps.formats.svg import ROUNDING
from tactile_maps.maps.model.layout import MapLayout, Placement, fit_placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.formats.icub.layout import apply_layout, read_icub_layout
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.taxel_placement.sampling import farthest_points

ImportedLayout = MapDocument | TaxelLayout
"""Another layout: a whole map, or only the positions of the taxels."""

MOST_PINS = 60
"""Number of pins per patch for a drawing; more hardly improve the fit and are hard to edit."""


def same_skin(first: Skin, second: Skin) -> bool:
    """Return whether two skins have the same patches on the same links, with equal surfaces and taxels, names aside."""
    if first is second:
        return True
    if len(first.patches) != len(second.patches):
        return False
    pairs = zip(first.patches, second.patches, strict=True)
    return all(
        _same_surface(one, other)
        and np.array_equal(one.taxels.faces, other.taxels.faces)
        and np.array_equal(one.taxels.weights, other.taxels.weights)
        for one, other in pairs
    )


def adopt_document(document: MapDocument, other: MapDocument) -> MapDocument:
    """Return the document with charts, layout and settings of ``other``; the skin is unchanged.

    Raises:
        MapError: The other document has another skin.
    """
    if not same_skin(document.skin, other.skin):
        raise _another_skin(other.skin, document.skin)
    if other.map is document.map and other.patches == document.patches and other.order == document.order:
        return document
    return replace(other, map=replace(other.map, skin=document.skin))


def adopt_patches(document: MapDocument, other: MapDocument) -> MapDocument:
    """Return the document with chart, placement and settings of each patch that ``other`` also has.

    Two patches correspond if their links and surfaces are equal; their taxels may differ. The remaining patches move to
    the free space closest to where they are.
    """
    matches = _corresponding(document.skin, other.skin)
    charts = list(document.charts)
    placements = list(document.layout.placements)
    patches = list(document.patches)
    for own, theirs in matches.items():
        charts[own] = other.charts[theirs]
        placements[own] = other.layout.placements[theirs]
        edit = other.patches[theirs]
        pins = tuple(replace(pin, at=replace(pin.at, patch=own)) for pin in edit.pins)
        patches[own] = replace(edit, pins=pins)
    layout = replace(document.layout, placements=tuple(placements))
    map_ = replace(document.map, charts=tuple(charts), layout=layout)
    adopted = MapDocument(map_, tuple(patches), document.order)
    return repack(adopted, set(range(len(patches))) - matches.keys()) if matches else document


@dataclass(frozen=True, eq=False)
class AdoptedEdits:
    """Edits on another skin.

    Attributes:
        document: The document of that skin with the edits.
        unedited: The same without edits, but with the patches that are new in the places to which the edits moved them.
        lost: Names of the patches with edits that the skin does not have.
    """

    document: MapDocument
    unedited: MapDocument
    lost: tuple[str, ...]


def adopt_edits(document: MapDocument, edited: MapDocument, unedited: MapDocument) -> AdoptedEdits:
    """Transfer edits to the document of another skin by ``adopt_patches``, if a patch with edits is on both skins.

    Args:
        document: Document of the other skin, without edits.
        edited: Document with edits.
        unedited: The same one without edits.
    """
    matches = _corresponding(document.skin, edited.skin)
    common = set(matches.values())
    changed = [number for number in range(len(edited.patches)) if _is_edited(number, edited, unedited)]
    lost = tuple(edited.patches[number].name for number in changed if number not in common)
    if common.isdisjoint(changed):
        return AdoptedEdits(document, document, lost)
    adopted = adopt_patches(document, edited)
    own = enumerate(zip(document.layout.placements, adopted.layout.placements, strict=True))
    placements = tuple(before if number in matches else after for number, (before, after) in own)
    map_ = replace(document.map, layout=replace(document.layout, placements=placements))
    return AdoptedEdits(adopted, replace(document, map=map_), lost)


def _is_edited(number: int, edited: MapDocument, unedited: MapDocument) -> bool:
    return (
        edited.charts[number] is not unedited.charts[number]
        or edited.patches[number] is not unedited.patches[number]
        or edited.layout.placements[number] != unedited.layout.placements[number]
    )


KEPT_DISTANCE = 0.005
"""Largest distance of a point of the body from another skin of its link at which it is regarded as the same [m]."""


def points_on_other_map(points: FloatArray, before: TactileMap, after: TactileMap) -> FloatArray | None:
    """Return where points of one map are on the map of another skin of the same robot.

    Args:
        points: (k, 2) points on ``before`` [m].
        before: Map on which they are defined.
        after: Map of the other skin.

    Returns:
        (k, 2) points on ``after`` [m], of the closest places on the same links; None if a point is not on the skin of
        ``before``, or more than ``KEPT_DISTANCE`` from that of ``after``.
    """
    patch, face, weights = before.to_body_many(points)
    if (face < 0).any():
        return None
    found = np.empty((len(points), 2))
    for k, number in enumerate(patch.tolist()):
        own = before.skin.patches[number]
        place = weights[k] @ own.surface.vertices[own.surface.faces[face[k]]]
        nearest = KEPT_DISTANCE
        point = None
        for other, candidate in enumerate(after.skin.patches):
            if candidate.link == own.link:
                faces, inside, distances = closest_point(candidate.surface).query(place)
                if distances[0] <= nearest:
                    nearest = float(distances[0])
                    point = after.to_map_many(np.array([other]), faces, inside)[0]
        if point is None:
            return None
        found[k] = point
    return found


def _corresponding(first: Skin, second: Skin) -> dict[int, int]:
    """Numbers of the patches of ``second`` by those of ``first`` with the same link and surface."""
    found: dict[int, int] = {}
    for number, patch in enumerate(first.patches):
        for other, candidate in enumerate(second.patches):
            if other not in found.values() and _same_surface(patch, candidate):
                found[number] = other
                break
    return found


def _same_surface(first: Patch, second: Patch) -> bool:
    return (
        first.link == second.link
        and np.array_equal(first.surface.faces, second.surface.faces)
        and np.array_equal(first.surface.vertices, second.surface.vertices)
    )


def read_other_layout(paths: Sequence[str | Path], document: MapDocument) -> ImportedLayout:
    """Read another layout of the document's skin: one file, or an iCub layout (.ini) with its positions file.

    Args:
        paths: A document or map saved by this program, or a drawing: taxels with map points in any supported format.
        document: Document of the same skin.

    Raises:
        MapError: The file cannot be read, is for another skin, or has no map points.
        SkinError: Its taxels are not valid.
    """
    files = sorted((Path(path) for path in paths), key=lambda path: path.suffix.lower() != ".ini")
    if len(files) == 2 and files[0].suffix.lower() == ".ini":
        return drawing_from_taxels([apply_layout(read_taxels(files[1]), read_icub_layout(files[0]))], document.skin)
    if len(files) != 1:
        remedy = "Choose one file, or an iCub layout (.ini) and its positions"
        raise MapError("the files are not one layout", value=f"{len(files)} files", remedy=remedy)
    if files[0].suffix.lower() == ".ini":
        remedy = "Choose it together with the positions file of the same patch"
        raise MapError("a layout has no positions on the body", file=files[0], remedy=remedy)
    if files[0].suffix.lower() == ".npz":
        return _saved_or_drawn(files[0], document)
    return drawing_from_taxels(read_taxel_sets(files[0]), document.skin)


def drawing_from_taxels(sets: Sequence[TaxelSet], skin: Skin) -> TaxelLayout:
    """Return the map points of ``sets``, each assigned to the taxels of its link, or to the nearest of all.

    Raises:
        MapError: Same as for ``drawn_layout``.
    """
    points = []
    numbers = []
    for taxels in [taxels for taxels in sets if taxels.mapped.any()] or sets:
        on_link = [patch.link == taxels.link or taxels.link not in skin.links for patch in skin.patches]
        own = np.flatnonzero(np.asarray(on_link)[skin.patch_of])
        layout = drawn_layout(taxels, Skin(tuple(p for p, mine in zip(skin.patches, on_link, strict=True) if mine)))
        assert layout.numbers is not None
        points.append(layout.points)
        numbers.append(own[layout.numbers])
    _, first = np.unique(np.concatenate(numbers), return_index=True)
    return TaxelLayout(np.concatenate(points)[first], np.concatenate(numbers)[first])


def arrange_as_drawn(document: MapDocument, drawing: TaxelLayout) -> MapDocument:
    """Place each patch over its drawing as well as its chart allows: moved, rotated and mirrored, at true size.

    The whole drawing is enlarged until its smallest patch has its true size, so that separate patches remain separate.
    Patches that are not drawn are unchanged.

    Raises:
        MapError: No taxel is drawn, or a patch would be beyond ``FARTHEST_OFFSET``.
    """
    fits = _fits(document, drawing)
    enlarged = 1 / min(fit.scale for fit in fits.values())
    placements = list(document.layout.placements)
    for number, fit in fits.items():
        points, plane = _drawn(document, drawing, number)
        turn = Placement(fit.angle, mirrored=fit.mirrored)
        x, y = enlarged * points.mean(axis=0) - turn.apply(plane).mean(axis=0)
        placements[number] = replace(turn, offset=(float(x), float(y)))
    layout = MapLayout(tuple(placements))
    return document if layout == document.layout else document.with_layout(layout)


def place_as_drawn(document: MapDocument, drawing: TaxelLayout, *, placed: bool = True) -> MapDocument:
    """Place each patch exactly where the taxels of a drawing at true size are, enlarged as there.

    Patches that are not drawn, or are at their places already, are unchanged.

    Args:
        document: The document.
        drawing: Drawn taxel positions [m].
        placed: Whether these are positions on the map; otherwise the drawing is centred on the drawn patches.

    Raises:
        MapError: No taxel is drawn, or a patch would be beyond ``FARTHEST_OFFSET``.
    """
    fits = _fits(document, drawing)
    if not placed:
        pairs = [_drawn(document, drawing, number) for number in fits]
        points = np.concatenate([points for points, _ in pairs])
        before = [document.layout.placements[n].apply(plane) for n, (_, plane) in zip(fits, pairs, strict=True)]
        shift = np.concatenate(before).mean(axis=0) - points.mean(axis=0)
        drawing = replace(drawing, points=drawing.points + shift)
        fits = _fits(document, drawing)
    placements = list(document.layout.placements)
    for number, fit in fits.items():
        points, plane = _drawn(document, drawing, number)
        if np.abs(placements[number].apply(plane) - points).max() > ROUNDING:
            placements[number] = fit
    layout = MapLayout(tuple(placements))
    return document if layout == document.layout else document.with_layout(layout)


def is_drawn_so(document: MapDocument, drawing: TaxelLayout) -> bool:
    """Whether the charts of the document have the shape of the drawing, to a thousandth of the patch's size."""
    for number, fit in _fits(document, drawing).items():
        points, plane = _drawn(document, drawing, number)
        if np.abs(fit.apply(plane) - points).max() > 1e-3 * np.ptp(points, axis=0).max():
            return False
    return True


def pin_as_drawn(document: MapDocument, drawing: TaxelLayout, *, most: int = MOST_PINS) -> ReflattenRequest:
    """Pin evenly distributed taxels to their drawn positions, in place of existing pins.

    Each patch keeps its cuts; where the drawing is cut elsewhere, its pins do not reach their targets.

    Args:
        document: The document; placements do not matter.
        drawing: Drawn taxel positions.
        most: Largest number of pins per patch.

    Raises:
        MapError: No taxel is drawn.
    """
    edits = []
    for number, fit in _fits(document, drawing).items():
        points, _ = _drawn(document, drawing, number)
        goals = fit.back(points)
        taxels = _taxels(document, drawing, number)
        chosen = _spread_out(document.map.taxel_points[taxels], most)
        pins = tuple(
            Pin(document.skin.taxel_point(int(taxels[k])), (float(goals[k, 0]), float(goals[k, 1]))) for k in chosen
        )
        edits.append((number, replace(document.patches[number], pins=pins)))
    return request_reflatten(document, "Pin as in the drawing", edits)


def _saved_or_drawn(path: Path, document: MapDocument) -> ImportedLayout:
    """Read an npz file, which may contain either kind of layout."""
    try:
        other = load_document(path)
    except MapError as refused:
        try:
            sets = read_taxel_sets(path)
        except SkinError:
            raise refused from None
        return drawing_from_taxels(sets, document.skin)
    if not same_skin(document.skin, other.skin):
        raise _another_skin(other.skin, document.skin, file=path)
    return other


def _another_skin(other: Skin, own: Skin, *, file: Path | None = None) -> MapError:
    sizes = [f"{counted(len(skin), 'taxel')} in {counted(len(skin.patches), 'patch')}" for skin in (other, own)]
    found = sizes[0] if sizes[0] == sizes[1] else f"{sizes[0]}, here {sizes[1]}"
    remedy = "Open the robot that it was made for, or choose a map of this one"
    return MapError("the map is of another skin", file=file, value=found, remedy=remedy)


def _taxels(document: MapDocument, drawing: TaxelLayout, number: int) -> IntArray:
    """Return the drawn taxels (k,) of a patch."""
    numbers = np.arange(len(drawing.points)) if drawing.numbers is None else drawing.numbers
    first, end = document.skin.first[number : number + 2]
    return numbers[(numbers >= first) & (numbers < end)]


def _drawn(document: MapDocument, drawing: TaxelLayout, number: int) -> tuple[FloatArray, FloatArray]:
    """Return the drawn positions (k, 2) of a patch's taxels, and their chart points (k, 2)."""
    numbers = np.arange(len(drawing.points)) if drawing.numbers is None else drawing.numbers
    taxels = _taxels(document, drawing, number)
    row = np.argsort(numbers)[np.searchsorted(np.sort(numbers), taxels)]
    plane = document.layout.placements[number].back(document.map.taxel_points[taxels])
    return drawing.points[row], plane


def _fits(document: MapDocument, drawing: TaxelLayout) -> dict[int, Placement]:
    """Return for each patch with two drawn positions or more the placement of its chart over them, at drawing scale."""
    fits = {}
    for number in range(len(document.patches)):
        points, plane = _drawn(document, drawing, number)
        if len(points) > 1 and np.ptp(points, axis=0).any() and np.ptp(plane, axis=0).any():
            fits[number] = fit_placement(plane, points)
    if not fits:
        raise MapError("the drawing has no taxel of this skin", remedy="Choose a drawing of this skin")
    return fits


def _spread_out(points: FloatArray, most: int) -> IntArray:
    """Return indices of at most ``most`` different points (k, 2), each as far as possible from the previous ones."""
    start = np.linalg.norm(points - points.mean(axis=0), axis=1).argmax()
    return farthest_points(points, min(most, len(np.unique(points, axis=0))), np.array([start]))
