"""Ways of flattening a disk, all called alike, and the table that names them.

Each takes a ``Disk`` and yields ever better maps of it; ``flatten`` checks whether the last one is one-to-one, and
mends it. Tutte's map and the conformal one (LSCM) are in ``initial_map``, since they are the start of the others.

- harmonic: onto a disk of the border's own arc lengths (libigl, cotangent weights). Cost: one factorisation, 12 ms for
  10,000 faces. Loses: areas, as the border is pressed onto a circle; obtuse triangles may flip.
- arap: as rigid as possible (Liu et al. 2008; libigl), each triangle turned at best, then all stitched together. Cost:
  one factorisation, then 4 ms a round for 10,000 faces. Loses: nothing on developable patches; flips on deep bodies.
- slim: scalable locally injective maps (Rabinovich et al. 2017; libigl), the same energy as our own, reweighted. Cost:
  40 ms a round for 10,000 faces, ten to forty rounds. Loses: time; the peer that our own is measured against.
- unroll: exact on planes, cylinders and cones, at the cost of one pass over the faces. The surface's normals make one
  angle with the axis of a cylinder or cone, so the axis is the direction in which they vary least. Around it every
  point has a distance from the apex and an angle, which the cone's opening makes smaller on the map (a cylinder is a
  cone with its apex far away). Loses: all that is not such a surface.
- symmetric-dirichlet, our own and the default: the map that stretches and squeezes least, by projected Newton on the
  symmetric Dirichlet energy. Cost: 4 µs a face and factorisation, four to eight of these. Loses: as little as any map
  can; the slider ``lengths`` trades lengths for angles.
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
from tactile_maps.core.plugins import Plugin, Registry, check_call
from tactile_maps.flattening import initial_map
from tactile_maps.flattening.initial_map import Disk, boundary_on_circle, projection
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.mesh import Mesh


def flatten_by_harmonic(disk: Disk) -> Iterator[FloatArray]:
    """The one round of the method ``harmonic``."""
    border = boundary_on_circle(disk.rest)[disk.loop]
    yield np.asarray(igl.harmonic(disk.positions, disk.faces, disk.loop, np.ascontiguousarray(border), 1))


_ARAP_INNER_ROUNDS = 10
_ARAP_ROUNDS = 20
_ARAP_TOLERANCE = 1e-5


def flatten_by_arap(disk: Disk) -> Iterator[FloatArray]:
    """Rounds of ten iterations from Tutte's map, until nothing moves by more than 1e-5 of the map's side."""
    data = igl.ARAPData()
    data.max_iter = _ARAP_INNER_ROUNDS
    # With nothing held the system is singular: one border vertex stays.
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
    """Rounds from Tutte's map until one gains less than 1e-4 of what could be gained."""
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
"""Normals that vary by less than this are a plane's."""
_PARALLEL = 1e-4
"""Sine of the half opening under which a cone counts as a cylinder."""


def flatten_by_unrolling(disk: Disk) -> Iterator[FloatArray]:
    """The one round of the method ``unroll``."""
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
    """A cone's points by distance from the apex and angle around the axis; a cylinder's by arc and height."""
    along = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    along /= np.linalg.norm(along)
    across = np.cross(axis, along)
    centres = surface.vertices[surface.faces].mean(axis=1)
    normals = surface.face_normals
    flat = np.stack([normals @ along, normals @ across], axis=1)
    # The normals' lines all meet the axis: least squares for where it crosses the plane through the origin.
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
    # Seen from outside the radius falls along the axis, seen from inside it grows.
    outside = (level - middle) * flat
    apex = height + np.sign(outside.sum()) * radius * np.sqrt(1 - sine**2) / sine
    far = np.hypot(radius, apex.mean() - height)
    return np.stack([far * np.sin(angle * sine), -far * np.cos(angle * sine)], axis=1)


def _unwrapped_angles(angle: FloatArray, edges: IntArray) -> FloatArray:
    """Angles without jumps from vertex to vertex over the cut surface."""
    both = np.concatenate([edges, edges[:, ::-1]])
    graph = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(len(angle),) * 2).tocsr()
    order, before = breadth_first_order(graph, 0)
    result = angle.copy()
    for vertex in order[1:].tolist():
        step = angle[vertex] - angle[before[vertex]]
        result[vertex] = result[before[vertex]] + step - 2 * np.pi * np.round(step / (2 * np.pi))
    return result


LEAST_LENGTHS = 0.02
"""Angles alone leave the scale of every place free; so much of the energy of lengths holds it."""


def flatten_by_newton(disk: Disk, *, lengths: float = 1.0) -> Iterator[FloatArray]:
    """Rounds from the first map to the optimum."""
    for iterate in minimise(blended_energy(disk, lengths), disk.taut):
        yield iterate.plane


def blended_energy(disk: Disk, lengths: float) -> SymmetricDirichlet:
    """What is minimised at a place of the slider: 1 keeps lengths, 0 keeps angles."""
    if lengths >= 1.0:
        return disk.energy
    return SymmetricDirichlet(disk.rest, lengths=max(lengths, LEAST_LENGTHS))


@dataclass(frozen=True)
class Method:
    """One way of flattening a disk.

    Attributes:
        name: As the user writes it.
        title: What it keeps, in a few words.
        run: Yields ever better planes (k, 2) of a disk for a place of the slider between angles (0) and lengths (1).
        lengths: What our own minimiser keeps instead where the method's map is not one-to-one: 1 lengths, 0 angles.
        slides: Whether the slider does anything.
    """

    name: str
    title: str
    run: Callable[[Disk, float], Iterator[FloatArray]]
    lengths: float = 1.0
    slides: bool = False


def _guarded(plugin: Plugin, method: Method) -> Method:
    """A plug-in's method, whose planes are looked at before anybody takes them."""
    check_call(plugin, method.run, "disk", "lengths")

    def run(disk: Disk, lengths: float) -> Iterator[FloatArray]:
        with plugin.at_work():
            planes = iter(method.run(disk, lengths))
        while True:
            with plugin.at_work():
                plane = next(planes, None)
                if plane is None:
                    return
                plane = np.array(plane, dtype=np.float64)
            if plane.shape != disk.start.shape or not np.isfinite(plane).all():
                raise plugin.error("it gave no finite place for each vertex", f"shape {plane.shape}")
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
"""By name."""


def find_method(name: str) -> Method:
    """The method called ``name``.

    Raises:
        MapError: There is none.
    """
    if name not in METHODS:
        raise MapError("there is no such method", place="method", value=name, remedy=METHODS.remedy(name))
    return METHODS[name]
