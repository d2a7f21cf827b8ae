"""Seams drawn, erased and proposed, and areas of interest painted where none may go. All need reflattening.

A seam that would cut a patch in two is refused. A patch is a piece of skin with its own taxels, which the simulation,
the controller and recordings know by number; splitting it is a change of the skin, which an edit of the map never is.
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
"""How many times longer a seam may be to go around an area of interest."""


class SeamCutsPatch(MapError):
    """The seam would cut the patch in two."""


class SeamInInterest(MapError):
    """The seam would go through an area of interest."""


def draw_seam(document: MapDocument, number: int, through: Sequence[int]) -> ReflattenRequest:
    """A seam along edges through vertices of the patch's surface, around areas of interest where there is a way.

    Seams that were there stay, but those that nobody asked for are chosen anew.

    Raises:
        SeamCutsPatch: With the drawn seams and the border it cuts the patch in two.
        SeamInInterest: There is no way around an area of interest.
        MapError: No such patch or vertex, fewer than two vertices, or no way between two of them.

    Cost: a Dijkstra a piece and two sorts of the edges; 10 ms for 10,000 faces.
    """
    surface, plan = _surface_and_plan(document, number)
    bad = [vertex for vertex in through if not 0 <= vertex < len(surface.vertices)]
    if bad:
        raise MapError("the patch has no such vertex", place=document.patches[number].name, value=bad[0])
    places = [vertex for vertex, _ in groupby(through)]  # a pointer that rests marks a place twice
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
    """Seams closed: ``edges`` (s, 2) of the patch's present seams, as vertex pairs of its surface.

    The other present seams become drawn ones, and none is added but what the patch's topology asks for: a tube is cut
    again along the shortest way, whatever is erased.

    Raises:
        MapError: No such patch, or an edge that is no seam.
    """
    surface, plan = _surface_and_plan(document, number)
    present = np.sort(np.concatenate([document.charts[number].seams, plan.drawn]), axis=1)
    erased = _among(present, edges, len(surface.vertices))
    if erased.sum() == 0 or not _among(np.asarray(edges).reshape(-1, 2), present, len(surface.vertices)).all():
        raise MapError("there is no seam to erase", place=document.patches[number].name, value=np.asarray(edges).size)
    drawn = np.unique(present[~erased], axis=0)
    return _with_seams(document, number, "Erase a seam", replace(plan, drawn=drawn, extra=0))


def propose_seam(document: MapDocument, number: int, *, more: int = 1) -> ReflattenRequest:
    """``more`` seams than the patch has, each to the place farthest from the border and the seams before.

    Its ``ReflattenResult.gains`` says what it would gain; ``apply_result`` accepts it as it was shown.

    Raises:
        MapError: No such patch, or not at least one seam more.
    """
    if more < 1:
        raise MapError("at least one seam must be proposed", value=more)
    _, plan = _surface_and_plan(document, number)
    return _with_seams(document, number, "Propose a seam", replace(plan, extra=extra_seams(document, number) + more))


def extra_seams(document: MapDocument, number: int) -> int:
    """How many seams the patch has besides the drawn ones and those that its topology asks for."""
    _, plan = _surface_and_plan(document, number)
    if plan.extra is not None:
        return plan.extra
    return sum(found.count for found in document.charts[number].findings if found.kind == "seam-added")


def paint_interest(
    document: MapDocument, number: int, vertices: Sequence[int] | IntArray, *, importance: float = INTEREST_WEIGHT
) -> ReflattenRequest:
    """Vertices of the patch's surface made an area of interest, or with ``importance`` 0 an ordinary one again.

    Seams already drawn through it stay; it is for a person to erase what a person drew.

    Raises:
        MapError: No such patch or vertex, or an importance that is not a number from 0 up.
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
    """``paint_interest`` for vertices of several patches, by patch number, in one step.

    Raises:
        MapError: As ``paint_interest``.
    """
    asked = [paint_interest(document, number, own, importance=importance) for number, own in painted.items()]
    return ReflattenRequest(asked[0].name if asked else "", tuple(job for part in asked for job in part.jobs))


def _surface_and_plan(document: MapDocument, number: int) -> tuple[Mesh, SeamPlan]:
    document.chosen([number])
    return document.skin.patches[number].surface, document.patches[number].seams


def _with_seams(document: MapDocument, number: int, name: str, plan: SeamPlan) -> ReflattenRequest:
    return request_reflatten(document, name, [(number, replace(document.patches[number], seams=plan))])


def _in_one_piece(surface: Mesh, drawn: IntArray) -> bool:
    """Whether every face can still be reached from every other without crossing ``drawn`` edges."""
    connectivity = surface.connectivity
    closed = ~_among(connectivity.edges[connectivity.twin_edges], drawn, len(surface.vertices))
    return bool(components_of(connectivity.twins[closed], len(surface.faces)).max() == 0)


def _among(edges: IntArray, others: IntArray, count: int) -> BoolArray:
    """(e,) which ``edges`` are among ``others``, whichever way round."""
    keys = [np.sort(np.asarray(pairs).reshape(-1, 2), axis=1) @ [count, 1] for pairs in (edges, others)]
    return np.isin(keys[0], keys[1])
