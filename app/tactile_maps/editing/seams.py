"""Seams: drawn, erased and proposed; and areas of interest that seams avoid. All edits require reflattening.

A seam that would cut a patch in two is rejected. A patch is a part of the skin with its own taxels, which simulation,
controllers and recordings refer to by number; splitting it would change the skin, which an edit of the map never does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from tactile_maps.core.arrays import BoolArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import ReflattenRequest, request_reflatten
from tactile_maps.flattening.cut import SeamPlan, shortest_edge_path
from tactile_maps.geometry.surface.connectivity import components_of
from tactile_maps.geometry.surface.mesh import Mesh

INTEREST_WEIGHT = 100.0
"""Ratio by which a seam may be longer to avoid an area of interest."""


class SeamCutsPatch(MapError):
    """The seam would cut the patch in two."""


class SeamInInterest(MapError):
    """The seam would go through an area of interest."""


def draw_seam(document: MapDocument, number: int, through: Sequence[int]) -> ReflattenRequest:
    """Draw a seam along edges through vertices of the patch's surface, around areas of interest if possible.

    Drawn seams remain; automatic seams are chosen again.

    Raises:
        SeamCutsPatch: Together with drawn seams and the border it would cut the patch in two.
        SeamInInterest: It cannot avoid an area of interest.
        MapError: Unknown patch or vertex, fewer than two vertices, or two that are not connected.

    Cost: a Dijkstra per part and two sorts of the edges; 10 ms for 10,000 faces.
    """
    surface, plan = _surface_and_plan(document, number)
    bad = [vertex for vertex in through if not 0 <= vertex < len(surface.vertices)]
    if bad:
        raise MapError("the patch has no such vertex", place=document.patches[number].name, value=bad[0])
    places = [vertex for vertex, _ in groupby(through)]  # a resting pointer marks a vertex twice
    path = shortest_edge_path(surface, places, importance=plan.importance)
    name = document.patches[number].name
    if plan.importance is not None and (plan.importance[path] > 0).all(axis=1).any():
        raise SeamInInterest(
            "the seam would go through an area of interest", place=name, remedy="Draw around it, or erase the area"
        )
    drawn = np.unique(np.concatenate([plan.drawn, path]), axis=0)
    if not _in_one_piece(surface, drawn):
        raise SeamCutsPatch(
            "the seam would cut the patch in two", place=name, remedy="Leave a gap in it, or end it before the border"
        )
    return _with_seams(document, number, "Draw a seam", replace(plan, drawn=drawn))


def erase_seams(document: MapDocument, number: int, edges: IntArray) -> ReflattenRequest:
    """Close seams: ``edges`` (s, 2) of the patch's current seams, as vertex pairs of its surface.

    The remaining seams become drawn ones, and only seams that the topology requires are added: a tube is always cut
    along a shortest path, whatever is erased.

    Raises:
        MapError: Unknown patch, or an edge that is not a seam.
    """
    surface, plan = _surface_and_plan(document, number)
    present = np.sort(np.concatenate([document.charts[number].seams, plan.drawn]), axis=1)
    erased = _among(present, edges, len(surface.vertices))
    if erased.sum() == 0 or not _among(np.asarray(edges).reshape(-1, 2), present, len(surface.vertices)).all():
        raise MapError(
            "no seam to erase at these edges", place=document.patches[number].name, value=np.asarray(edges).size
        )
    drawn = np.unique(present[~erased], axis=0)
    return _with_seams(document, number, "Erase a seam", replace(plan, drawn=drawn, extra=0))


def propose_seam(document: MapDocument, number: int) -> ReflattenRequest:
    """Request an additional seam, to the point farthest from border and existing seams.

    ``ReflattenResult.gains`` of the result is the improvement; ``apply_result`` accepts the previewed result.

    Raises:
        MapError: Unknown patch.
    """
    _, plan = _surface_and_plan(document, number)
    return _with_seams(document, number, "Propose a seam", replace(plan, extra=extra_seams(document, number) + 1))


def extra_seams(document: MapDocument, number: int) -> int:
    """Return the number of seams in addition to drawn ones and those that the topology requires."""
    _, plan = _surface_and_plan(document, number)
    if plan.extra is not None:
        return plan.extra
    return sum(found.count for found in document.charts[number].findings if found.kind == "seam-added")


def paint_interest(
    document: MapDocument, number: int, vertices: Sequence[int] | IntArray, *, importance: float = INTEREST_WEIGHT
) -> ReflattenRequest:
    """Mark vertices of the patch's surface as area of interest, or as ordinary with ``importance`` 0.

    Seams already drawn through it remain until the user erases them.

    Raises:
        MapError: Unknown patch or vertex, or an importance that is negative or not finite.
    """
    surface, plan = _surface_and_plan(document, number)
    painted = np.asarray(vertices, dtype=np.int64)
    count = len(surface.vertices)
    if ((painted < 0) | (painted >= count)).any():
        raise MapError("the patch has no such vertex", place=document.patches[number].name, value=painted.max())
    values = np.zeros(count) if plan.importance is None else plan.importance.copy()
    values[painted] = importance
    name = "Paint an area of interest" if importance else "Erase an area of interest"
    return _with_seams(document, number, name, replace(plan, importance=values if values.any() else None))


def paint_areas(
    document: MapDocument, painted: Mapping[int, Sequence[int] | IntArray], *, importance: float = INTEREST_WEIGHT
) -> ReflattenRequest:
    """Apply ``paint_interest`` to vertices of several patches, by patch number, in one step.

    Raises:
        MapError: Same as for ``paint_interest``.
    """
    requests = [paint_interest(document, number, own, importance=importance) for number, own in painted.items()]
    return ReflattenRequest(requests[0].name if requests else "", tuple(job for part in requests for job in part.jobs))


def _surface_and_plan(document: MapDocument, number: int) -> tuple[Mesh, SeamPlan]:
    document.chosen([number])
    return document.skin.patches[number].surface, document.patches[number].seams


def _with_seams(document: MapDocument, number: int, name: str, plan: SeamPlan) -> ReflattenRequest:
    return request_reflatten(document, name, [(number, replace(document.patches[number], seams=plan))])


def _in_one_piece(surface: Mesh, drawn: IntArray) -> bool:
    """Return whether every face can be reached from every other without crossing ``drawn`` edges."""
    connectivity = surface.connectivity
    closed = ~_among(connectivity.edges[connectivity.twin_edges], drawn, len(surface.vertices))
    return bool(components_of(connectivity.twins[closed], len(surface.faces)).max() == 0)


def _among(edges: IntArray, others: IntArray, count: int) -> BoolArray:
    """Return whether each of ``edges`` (e, 2) is among ``others``, in either direction."""
    keys = [np.sort(np.asarray(pairs).reshape(-1, 2), axis=1) @ [count, 1] for pairs in (edges, others)]
    return np.isin(keys[0], keys[1])
