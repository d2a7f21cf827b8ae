"""The usable part of a wrapped link: visible from outside, clear of other links, with smooth borders.

Visible parts can be reached by a finger along a straight line from outside. They are found by depth maps from fixed
directions: points are binned on a plane perpendicular to the direction, and those well behind the foremost point of
their bin are hidden. Results are deterministic.

Clear parts keep a distance from all other links and are inside none of them (winding number). The rest is split into
connected components, small holes are filled, and ragged borders are trimmed and smoothed.
"""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np
from scipy.sparse import diags

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.geometry.surface.closest_point import closest_point
from tactile_maps.geometry.surface.connectivity import (
    Connectivity,
    averaging_matrix,
    faces_touching,
    remove_unreferenced,
)
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.geometry.surface.raycast import fibonacci_sphere

DIRECTIONS = 60
_MOST_VOXELS = 4_000_000
"""Largest number of voxels of a table, 32 MB; with more, points are sorted."""
_FACING = 0.5
_MIN_DIRECTIONS = 2


def visible_from_outside(surface: Mesh, blockers: Sequence[FloatArray], *, voxel: float) -> BoolArray:
    """Return (n,) whether each vertex is visible from at least two of 60 directions that it faces.

    Args:
        surface: Evenly meshed surface with edges of about ``voxel``.
        blockers: Points (k, 3) of shapes that may hide it, in the frame of the surface, as dense as those of
            ``sample_surface``.
        voxel: Edge length [m]; a bin is two edges wide.
    """
    points = np.concatenate([surface.vertices, *(_one_point_per_voxel(cloud, voxel) for cloud in blockers)])
    count = len(surface.vertices)
    seen = np.zeros(count, dtype=int)
    for direction in fibonacci_sphere(DIRECTIONS):
        depth = points @ direction
        foremost = _foremost(points, depth, count, direction, 2 * voxel)
        facing = surface.vertex_normals @ direction
        # On a slope the foremost point of a bin is ahead by the width of the bin times the slope.
        slack = 2 * voxel * (1.5 + np.sqrt(np.maximum(1 - facing**2, 0)) / np.maximum(facing, _FACING))
        seen += (facing > _FACING) & (depth[:count] > foremost - slack)
    return seen >= _MIN_DIRECTIONS


def _foremost(points: FloatArray, depth: FloatArray, count: int, direction: FloatArray, bin_size: float) -> FloatArray:
    """Return (count,) the greatest depth along ``direction`` in the bin of each of the first points."""
    u = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    sides = (points @ u, points @ v)
    near = depth >= depth[:count].min()
    for side in sides:  # points next to or behind all of them hide none
        near &= (side > side[:count].min() - bin_size) & (side < side[:count].max() + bin_size)
    i, j = (((side[near] - side.min()) / bin_size).astype(np.int64) for side in sides)
    cell = i * (j.max() + 1) + j
    deepest = np.full(cell.max() + 1, -np.inf)
    np.maximum.at(deepest, cell, depth[near])
    return np.asarray(deepest[cell[:count]])


def sample_surface(mesh: Mesh, voxel: float) -> FloatArray:
    """Return points (k, 3) for ``visible_from_outside`` with this ``voxel`` [m].

    They are the corners of faces and, on faces larger than a bin, points in rows between them.

    Cost: 1 ms for 10,000 faces.
    """
    corners = mesh.corners
    x, y, z = np.moveaxis(corners - np.roll(corners, 1, axis=1), 2, 0)
    longest = np.sqrt((x * x + y * y + z * z).T.max(axis=0))
    steps = np.minimum(np.ceil(longest / (1.5 * voxel)).astype(int), 64)
    clouds = [corners.reshape(-1, 3)]
    for number in np.unique(steps[steps > 1]):
        i, j = np.meshgrid(np.arange(number + 1), np.arange(number + 1), indexing="ij")
        inside = i + j <= number
        a = i[inside] / number
        b = j[inside] / number
        clouds.append((np.stack([1 - a - b, a, b], axis=1) @ corners[steps == number]).reshape(-1, 3))
    return np.concatenate(clouds)


def _one_point_per_voxel(points: FloatArray, voxel: float) -> FloatArray:
    """Return the first point of each occupied voxel, which is enough for bins that are two voxels wide."""
    key = np.zeros(len(points), dtype=np.int64)
    size = 1
    for column in np.ascontiguousarray(points.T):
        cell = ((column - column.min()) / voxel).astype(np.int64)
        count = int(cell.max()) + 1
        key = key * count + cell
        size = size * count
    if size > _MOST_VOXELS:
        return points[np.unique(key, return_index=True)[1]]
    first = np.full(size, len(points))  # a table instead of sorting saves a third of the time of a cover
    first[key[::-1]] = np.arange(len(points))[::-1]
    return points[first[first < len(points)]]


_SMOOTHED_ROWS = 3


def vertices_clear_of(surface: Mesh, others: Sequence[tuple[Pose, Mesh]], *, distance: float) -> BoolArray:
    """Return (n,) whether each vertex is at least ``distance`` [m] from every other mesh and inside none of them.

    Args:
        surface: The candidate surface.
        others: Cleaned meshes, closed or not, and their poses in the frame of the surface.
        distance: Required distance [m].
    """
    clear = np.ones(len(surface.vertices), dtype=bool)
    middle = surface.bounds.mean(axis=0)
    reach = distance + surface.size / 2
    for pose, other in others:
        low, high = other.bounds
        centre = pose.inverse.points(middle)
        if (centre < low - reach).any() or (centre > high + reach).any():
            continue
        points = pose.inverse.points(surface.vertices)
        near = np.flatnonzero(clear & _in_box(points, low - distance, high + distance))
        if not len(near):
            continue
        clear[near] = closest_point(other).query(points[near])[2] >= distance
        within = near[clear[near] & _in_box(points[near], low, high)]
        if len(within):
            winding = igl.fast_winding_number(other.vertices, other.faces, np.ascontiguousarray(points[within]))
            clear[within] = np.abs(winding) <= 0.5
    return clear


def _in_box(points: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Return (n,) whether points (n, 3) are in a box, by columns, which is four times as fast as by rows."""
    inside = np.ones(len(points), dtype=bool)
    for column, least, most in zip(points.T, low, high, strict=True):
        inside &= (column > least) & (column < most)
    return inside


def usable_components(surface: Mesh, usable: BoolArray, *, smallest: float, largest_hole: float) -> list[Mesh]:
    """Return the connected pieces of the faces whose corners are all usable, largest first.

    Small holes are filled, ragged borders are trimmed and smoothed.

    Args:
        surface: Manifold surface.
        usable: (n,) usable vertices.
        smallest: Smallest area of a piece [m²].
        largest_hole: Largest area of a hole that is filled [m²].
    """
    keep = np.asarray(usable[surface.faces].all(axis=1))
    keep = _drop_small_components(surface, keep, smallest)
    keep = ~_drop_small_components(surface, ~keep, largest_hole)
    keep = _trim_border(surface, keep)
    faces = surface.faces[keep]
    labels = Connectivity(faces).components
    pieces = []
    for label in range(labels.max(initial=-1) + 1):
        numbered, used = remove_unreferenced(faces[labels == label])
        piece = Mesh(surface.vertices[used], numbered)
        if piece.area >= smallest:
            pieces.append(Mesh(_smooth_border(piece), numbered))
    return sorted(pieces, key=lambda piece: -piece.area)


def _drop_small_components(surface: Mesh, keep: BoolArray, smallest: float) -> BoolArray:
    """Drop connected groups of kept faces whose area is below ``smallest``."""
    if not keep.any():
        return keep
    labels = Connectivity(surface.faces[keep]).components
    areas = np.bincount(labels, weights=surface.face_areas[keep])
    result = keep.copy()
    result[np.flatnonzero(keep)[areas[labels] < smallest]] = False
    return result


def _trim_border(surface: Mesh, keep: BoolArray) -> BoolArray:
    """Remove faces attached by one edge, and faces at vertices where two fans meet, until none is left."""
    keep = keep.copy()
    while keep.any():
        faces = surface.faces[keep]
        connectivity = Connectivity(faces)
        border = np.sort(connectivity.boundary_edges, axis=1)
        count = np.bincount(border.ravel(), minlength=len(surface.vertices))
        pairs = {tuple(edge) for edge in border.tolist()}
        suspects = np.flatnonzero((count[faces] > 0).all(axis=1))
        sides = [sum(tuple(sorted((f[k], f[k - 2]))) in pairs for k in range(3)) for f in faces[suspects].tolist()]
        drop = faces_touching(faces, connectivity.bow_tie_vertices, len(surface.vertices))
        drop[suspects[np.array(sides, dtype=int) >= 2]] = True
        if not drop.any():
            return keep
        keep[np.flatnonzero(keep)[drop]] = False
    return keep


def _smooth_border(piece: Mesh, rounds: int = 12) -> FloatArray:
    """Return the vertices with a smooth border and evenly spaced rows behind it; each stays in its tangent plane."""
    border = piece.connectivity.boundary_edges
    edges = piece.edges
    count = len(piece.vertices)
    if not len(border):
        return piece.vertices
    on_border = np.zeros(count, dtype=bool)
    on_border[border] = True
    behind = on_border.copy()
    for _ in range(_SMOOTHED_ROWS):
        behind[edges[behind[edges].any(axis=1)]] = True
    average = averaging_matrix(edges, count)
    # Border vertices are averaged along the border only, the others over all neighbours.
    average = (
        diags(on_border.astype(float)) @ averaging_matrix(border, count) + diags((~on_border).astype(float)) @ average
    )
    vertices = piece.vertices
    normals = piece.vertex_normals
    for _ in range(rounds):
        step = np.where(behind[:, None], 0.5 * (average @ vertices - vertices), 0.0)
        vertices = vertices + step - (step * normals).sum(axis=1, keepdims=True) * normals
    return vertices
