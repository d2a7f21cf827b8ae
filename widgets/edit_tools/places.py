"""What the pointer means in either view, without Qt: the vertex, the seam or the vertices near it."""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.editing.document import MapDocument
from widgets.edit_tool import Place
from widgets.edit_tools.edges import as_edges, on_map, present_seams, runs
from widgets.select_hand import near

REACH_PX = 12.0
"""Nearer than this is meant, beside the skin and beside a seam."""

Vertex = tuple[int, int]
"""Patch, and vertex of its surface."""


def vertex_at(document: MapDocument, place: Place) -> Vertex | None:
    """The nearest corner of the face under the pointer; beside the map's patches the nearest of a border in reach."""
    if place.at is not None:
        number, corners = place.at.patch, document.skin.patches[place.at.patch].surface.faces[place.at.face]
        if place.point is None:
            there = document.skin.patches[number].surface.vertices[corners]
            away = np.linalg.norm(there - document.skin.position(place.at), axis=1)
        else:
            there = document.map.uv[number][document.charts[number].faces[place.at.face]]
            away = np.linalg.norm(there - place.point, axis=1)
        return number, int(corners[away.argmin()])
    return None if place.point is None else _on_border(document, place.point, REACH_PX * place.pixel)


def _on_border(document: MapDocument, point: FloatArray, reach: float) -> Vertex | None:
    best, found = reach, None
    for number in _seen(document):
        chart = document.charts[number]
        away = np.linalg.norm(document.map.outlines[number] - point, axis=1)
        if away.min() <= best:
            best, found = float(away.min()), (number, int(chart.vertex_of[chart.border[away.argmin()]]))
    return found


def seam_at(document: MapDocument, place: Place) -> tuple[int, IntArray] | None:
    """The patch and the run (k,) of vertices, from branch to branch, of the seam in reach of the pointer."""
    best, found = REACH_PX * place.pixel, None
    for number in _seen(document) if place.point is not None else [] if place.at is None else [place.at.patch]:
        for run in runs(present_seams(document, number)):
            away = _distance(document, number, as_edges(run), place)
            if away <= best:
                best, found = away, (number, run)
    return found


def _distance(document: MapDocument, number: int, edges: IntArray, place: Place) -> float:
    """From the pointer to the nearest of ``edges`` (s, 2), on the map or on the body [m]."""
    if place.point is not None:
        point, segments = place.point, on_map(document, number, edges)
    else:
        assert place.at is not None
        point, segments = document.skin.position(place.at), document.skin.patches[number].surface.vertices[edges]
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.maximum(np.einsum("sk,sk->s", along, along), np.finfo(float).tiny)
    share = np.clip(np.einsum("sk,sk->s", point - start, along) / length, 0, 1)
    return float(np.linalg.norm(start + share[:, None] * along - point, axis=1).min(initial=np.inf))


def brushed(document: MapDocument, before: Place, place: Place, radius: float) -> dict[int, IntArray]:
    """By patch the vertices that a brush of ``radius`` [px] covered on its straight way from one place to the next.

    However small it is, on the skin it covers the vertex nearest to its middle.
    """
    reach = radius * place.pixel
    if place.point is not None:
        start = place.point if before.point is None else before.point
        covered = {
            k: np.unique(document.charts[k].vertex_of[near(np.stack([start, place.point]), document.map.uv[k], reach)])
            for k in _seen(document)
        }
    elif place.at is not None:
        covered = {place.at.patch: np.flatnonzero(_brushed_on_body(document, before, place, reach))}
    else:
        covered = {}
    if place.at is not None:
        nearest = vertex_at(document, place)
        assert nearest is not None
        covered[nearest[0]] = np.union1d(covered.get(nearest[0], []), [nearest[1]]).astype(np.int64)
    return {number: vertices for number, vertices in covered.items() if len(vertices)}


def _brushed_on_body(document: MapDocument, before: Place, place: Place, reach: float) -> BoolArray:
    """(n,) vertices near the way that look the way the skin does there: a thin patch's far side is not painted."""
    assert place.at is not None
    surface, here = document.skin.patches[place.at.patch].surface, document.skin.position(place.at)
    same = before.at is not None and before.point is None and before.at.patch == place.at.patch
    start = document.skin.position(before.at) if same and before.at is not None else here
    facing = surface.vertex_normals @ document.skin.normal(place.at) > 0
    return facing & near(np.stack([start, here]), surface.vertices, reach)


def _seen(document: MapDocument) -> list[int]:
    """Patches that the map view shows."""
    return [number for number, patch in enumerate(document.patches) if patch.visible]
