"""Methods of flattening a disk, with one signature, and the table of their names.

Each takes a ``Disk`` and yields successively better maps of it; ``flatten`` checks whether the last one is one-to-one
and repairs it. Tutte's map and the conformal one (LSCM) are in ``initial_map``, since the other methods start from
them.

- harmonic: onto a disk with the border's arc lengths (libigl, cotangent weights). Cost: one factorisation, 12 ms for
  10,000 faces. Limits: areas are distorted, as the border is pressed onto a circle; obtuse triangles may flip.
- arap: as rigid as possible (Liu et al. 2008; libigl); alternates the best rotation of each triangle with a global fit.
  Cost: one factorisation, then 4 ms a round for 10,000 faces. Limits: exact on developable patches; flips on deep
  bodies.
- slim: scalable locally injective maps (Rabinovich et al. 2017; libigl), the same energy as our default, reweighted.
  Cost: 40 ms a round for 10,000 faces, ten to forty rounds. Limits: slow; it is the reference for the default method.
- unroll: exact on planes, cylinders and cones, in one pass over the faces. The normals of a cylinder or cone make one
  angle with its axis, so the axis is the direction in which they vary least. Each point has a distance from the apex
  and an angle around the axis, which the cone's opening scales on the map (a cylinder is a cone with its apex far
  away). Limits: all other surfaces.
- symmetric-dirichlet, the default: the map with the least stretch, by projected Newton on the symmetric Dirichlet
  energy. Cost: 4 µs a face and factorisation, four to eight of these. The parameter ``lengths`` trades lengths for
  angles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import igl
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.plugins import Plugin, Registry, guard_call
from tactile_maps.flattening import initial_map
from tactile_maps.flattening.initial_map import Disk, boundary_on_circle, projection
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.mesh import Mesh


def flatten_by_harmonic(disk: Disk) -> Iterator[FloatArray]:
    """Yield the map of the method ``harmonic``."""
    border = boundary_on_circle(disk.rest)[disk.loop]
    yield np.asarray(igl.harmonic(disk.positions, disk.faces, disk.loop, np.ascontiguousarray(border), 1))


_ARAP_INNER_ROUNDS = 10
_ARAP_ROUNDS = 20
_ARAP_TOLERANCE = 1e-5


def flatten_by_arap(disk: Disk) -> Iterator[FloatArray]:
    """Yield rounds of ten iterations from Tutte's map until no point moves by more than 1e-5 of the map's side."""
    data = igl.ARAPData()
    data.max_iter = _ARAP_INNER_ROUNDS
    # Without a fixed vertex the system is singular.
    held = disk.loop[:1].copy()
    igl.arap_precomputation(disk.positions, disk.faces, 2, held, data)
    plane = disk.start
    for _ in range(_ARAP_ROUNDS):
        after = np.asarray(igl.arap_solve(np.ascontiguousarray(disk.start[held]), data, np.ascontiguousarray(plane)))
        yield after
        if not np.abs(after - plane).max() > _ARAP_TOLERANCE:
            return
        plane = after


_SLIM_ROUNDS = 100
_SLIM_TOLERANCE = 1e-4


def flatten_by_slim(disk: Disk) -> Iterator[FloatArray]:
    """Yield rounds from Tutte's map until one reduces (energy - 4) by less than a share of 1e-4."""
    none = np.zeros(0, dtype=np.int64)
    nowhere = np.zeros((0, 2))
    energy = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    start = np.ascontiguousarray(disk.start)
    data = igl.slim_precompute(disk.positions, disk.faces, start, energy, none, nowhere, 0.0)
    reached = disk.energy.energy(disk.start)
    for _ in range(_SLIM_ROUNDS):
        plane = np.asarray(igl.slim_solve(data, 1))[:, :2]
        yield plane
        before = reached
        reached = disk.energy.energy(plane)
        if not before - reached > _SLIM_TOLERANCE * max(reached - 4, 1e-9):
            return


_FLAT = 1e-3
"""Variance of the normals below which a surface counts as a plane."""
_PARALLEL = 1e-4
"""Sine of half the opening angle below which a cone counts as a cylinder."""


def flatten_by_unrolling(disk: Disk) -> Iterator[FloatArray]:
    """Yield the map of the method ``unroll``."""
    surface = Mesh(disk.positions, disk.faces)
    normals = surface.face_normals
    weights = surface.face_areas / surface.area
    mean = weights @ normals
    spread = (weights[:, None] * (normals - mean)).T @ (normals - mean)
    values, axes = np.linalg.eigh(spread)
    if values[-1] < _FLAT:
        yield projection(disk.rest)
        return
    axis = axes[:, 0] * (1.0 if mean @ axes[:, 0] >= 0 else -1.0)
    sine = min(float(mean @ axis), 1.0)
    yield _rolled_off(disk, surface, axis, sine)


def _rolled_off(disk: Disk, surface: Mesh, axis: FloatArray, sine: float) -> FloatArray:
    """Return a cone's points by distance from the apex and angle around the axis; a cylinder's by arc and height."""
    along = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    along /= np.linalg.norm(along)
    across = np.cross(axis, along)
    centres = surface.vertices[surface.faces].mean(axis=1)
    normals = surface.face_normals
    flat = np.stack([normals @ along, normals @ across], axis=1)
    # The lines along all normals meet the axis: least squares for its intersection with the plane through the origin.
    away = np.stack([-flat[:, 1], flat[:, 0]], axis=1)
    level = np.stack([centres @ along, centres @ across], axis=1)
    middle, *_ = np.linalg.lstsq(away, (away * level).sum(axis=1), rcond=None)
    x = disk.positions @ along - middle[0]
    y = disk.positions @ across - middle[1]
    height = disk.positions @ axis
    radius = np.hypot(x, y)
    angle = _unwrapped_angles(np.arctan2(y, x), disk.rest.edges)
    if sine < _PARALLEL:
        return np.stack([angle * radius.mean(), height], axis=1)
    # With outward normals the radius decreases along the axis, with inward normals it increases.
    outside = (level - middle) * flat
    apex = height + np.sign(outside.sum()) * radius * np.sqrt(1 - sine**2) / sine
    far = np.hypot(radius, apex.mean() - height)
    return np.stack([far * np.sin(angle * sine), -far * np.cos(angle * sine)], axis=1)


def _unwrapped_angles(angle: FloatArray, edges: IntArray) -> FloatArray:
    """Return angles without jumps between adjacent vertices of the cut surface."""
    both = np.concatenate([edges, edges[:, ::-1]])
    graph = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(len(angle),) * 2).tocsr()
    order, before = breadth_first_order(graph, 0)
    result = angle.copy()
    for vertex in order[1:].tolist():
        step = angle[vertex] - angle[before[vertex]]
        result[vertex] = result[before[vertex]] + step - 2 * np.pi * np.round(step / (2 * np.pi))
    return result


LEAST_LENGTHS = 0.02
"""Least share of the energy of lengths: angles alone leave the local scale undetermined."""


def flatten_by_newton(disk: Disk, *, lengths: float = 1.0) -> Iterator[FloatArray]:
    """Yield rounds from the first map to the optimum."""
    for iterate in minimise(blended_energy(disk, lengths), disk.taut):
        yield iterate.plane


def blended_energy(disk: Disk, lengths: float) -> SymmetricDirichlet:
    """Return the energy for a value of the slider: 1 keeps lengths, 0 keeps angles."""
    if lengths >= 1.0:
        return disk.energy
    return SymmetricDirichlet(disk.rest, lengths=max(lengths, LEAST_LENGTHS))


@dataclass(frozen=True)
class Method:
    """A method of flattening a disk.

    Attributes:
        name: Name for users.
        title: The property it preserves, in a few words.
        run: Yields successively better planes (k, 2) of a disk, for a slider value between angles (0) and lengths (1).
        lengths: Slider value of the built-in minimiser where the map of this method is not one-to-one.
        slides: Whether the method uses the slider.
    """

    name: str
    title: str
    run: Callable[[Disk, float], Iterator[FloatArray]]
    lengths: float = 1.0
    slides: bool = False


def _guarded(plugin: Plugin, method: Method) -> Method:
    """Return a plug-in's method whose planes have a finite place for each vertex, or raise."""
    start = guard_call(plugin, method.run, "disk", "lengths")

    def run(disk: Disk, lengths: float) -> Iterator[FloatArray]:
        planes = start(disk, lengths)
        with plugin.at_work():
            for found in planes:
                plane = np.array(found, dtype=np.float64)
                if plane.shape != disk.start.shape or not np.isfinite(plane).all():
                    raise plugin.error("the method did not return finite vertex positions", f"shape {plane.shape}")
                yield plane

    return replace(method, run=run)


METHODS: Registry[Method] = Registry(
    "map_methods",
    Method,
    (
        Method(
            "symmetric-dirichlet",
            "angles and lengths in balance; always valid",
            lambda disk, lengths: flatten_by_newton(disk, lengths=lengths),
            slides=True,
        ),
        Method("tutte", "nothing but validity", lambda disk, _: initial_map.flatten_by_tutte(disk)),
        Method("harmonic", "smoothness, border on a circle", lambda disk, _: flatten_by_harmonic(disk), lengths=0.0),
        Method("lscm", "angles", lambda disk, _: initial_map.flatten_by_lscm(disk), lengths=0.0),
        Method("arap", "lengths, by rigid triangles", lambda disk, _: flatten_by_arap(disk)),
        Method("slim", "angles and lengths in balance, by libigl", lambda disk, _: flatten_by_slim(disk)),
        Method("unroll", "planes, cylinders and cones, exactly", lambda disk, _: flatten_by_unrolling(disk)),
    ),
    _guarded,
)
"""Methods by name."""


def find_method(name: str) -> Method:
    """Return the method ``name``.

    Raises:
        MapError: The name is unknown.
    """
    if name not in METHODS:
        raise MapError("unknown method", place="method", value=name, remedy=METHODS.remedy(name))
    return METHODS[name]
