"""Taxels on a surface as a person asks for them: number or pitch, pattern, density, zones to keep out of.

``PlacementSpec`` says what is wanted, ``place_taxels`` does it on a surface that is fine enough (``refine_for_spec``
divides one that is not). The even pattern is in ``sampling``, the hexagonal lattice and the triangular modules are in
``patterns``.

Keep-out zones: a face is kept out if any of it may lie in a zone, so that a taxel anywhere on the other faces is
outside for certain. Kept-out faces carry no quadrature: there is a connector, a screw or a joint, and nothing to feel
with.

Density: how many taxels per area, relative to other places of the surface, as painted or by curvature (Rusinkiewicz
2004).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, assert_never, get_args

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays, readonly, set_fields
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.geodesics import distances_from, edge_graph
from tactile_maps.geometry.remesh.refine import SubdividedMesh, subdivide, subdivided_count
from tactile_maps.geometry.surface.closest_point import barycentric
from tactile_maps.geometry.surface.connectivity import averaging_matrix
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Taxels
from tactile_maps.skin.taxel_placement.patterns import place_lattice, place_modules
from tactile_maps.skin.taxel_placement.sampling import place_evenly

Pattern = Literal["even", "hexagonal", "modules"]
MODULE_PITCH = 0.0065
"""Distance of taxels on the triangular modules of iCub and CySkin [m]."""
MAX_PLACED_TAXELS = 100_000
_PITCH_RANGE = 1e-5, 1.0


@dataclass(frozen=True, eq=False)
class SphereZone:
    """Keep out of a ball: ``centre`` (3,) [m], ``radius`` [m], in the surface's frame."""

    centre: FloatArray
    radius: float

    def __post_init__(self) -> None:
        set_fields(self, centre=_vector(self.centre, "ball"))
        if not 0 < self.radius < np.inf:
            raise SkinError("an excluded ball needs a radius above zero", place="keep out", value=self.radius)


@dataclass(frozen=True, eq=False)
class BoxZone:
    """Keep out of a box along the axes of the surface's frame: corners ``low`` and ``high`` (3,) [m]."""

    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        set_fields(self, low=_vector(self.low, "box"), high=_vector(self.high, "box"))
        if (self.low > self.high).any():
            raise SkinError(
                "the lower corner of an excluded box is above the upper one", place="keep out", value=self.low.tolist()
            )


@dataclass(frozen=True)
class BoundaryZone:
    """Keep ``width`` [m] away from the surface's border, measured along its edges."""

    width: float

    def __post_init__(self) -> None:
        if not 0 <= self.width < np.inf:
            raise SkinError("an excluded strip needs a width", place="keep out", value=self.width)


@dataclass(frozen=True, eq=False)
class PaintedZone:
    """Keep off every face with a marked corner: ``vertices`` (n,) true where marked."""

    vertices: BoolArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "vertices", dtype=bool)


KeepOutZone: TypeAlias = SphereZone | BoxZone | BoundaryZone | PaintedZone


@dataclass(frozen=True, eq=False)
class PlacementSpec:
    """Wanted taxels.

    Attributes:
        pitch: Distance between neighbours [m], over the surface on average where the density varies.
        taxels: How many. State it or the pitch, not both; for neither, modules have their usual pitch.
        pattern: ``even``; ``hexagonal``, a lattice that bends with the surface; ``modules`` of ten taxels, as many
            triangles as fit.
        density: Taxels per area in proportion to this: None for the same everywhere, ``curvature`` for more where the
            surface bends, or a value above zero for each vertex. Only ratios count, and only for ``even``.
        keep_out: Where no taxel lies and nothing is felt.
        seed: The same taxels from the same seed.
    """

    pitch: float | None = None
    taxels: int | None = None
    pattern: Pattern = "even"
    density: Literal["curvature"] | FloatArray | None = None
    keep_out: tuple[KeepOutZone, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        if self.pattern not in get_args(Pattern):
            remedy = f"Choose one of: {', '.join(get_args(Pattern))}"
            raise SkinError("there is no such pattern", place="pattern", value=self.pattern, remedy=remedy)
        self._check_number()
        if isinstance(self.density, str) and self.density != "curvature":
            raise SkinError("there is no such density", place="density", value=self.density, remedy=_DENSITIES)
        if self.density is not None and self.pattern != "even":
            raise SkinError("only the even pattern follows a density", place="density", value=self.pattern)
        if self.density is not None and not isinstance(self.density, str):
            set_fields(self, density=_positive(self.density))

    def restricted_to(self, vertices: IntArray, *, taxels: int | None = None) -> PlacementSpec:
        """The same for a part of the surface that has only ``vertices`` (k,) of it, in that order.

        Args:
            vertices: Numbers of the whole surface's vertices.
            taxels: The part's share, if a number was asked for.
        """
        density = self.density[vertices] if isinstance(self.density, np.ndarray) else self.density
        zones = (
            PaintedZone(zone.vertices[vertices]) if isinstance(zone, PaintedZone) else zone for zone in self.keep_out
        )
        return replace(self, taxels=taxels, density=density, keep_out=tuple(zones))

    def _check_number(self) -> None:
        if self.pattern == "modules":
            if self.taxels is not None:
                raise SkinError(
                    "as many modules are placed as fit", place="taxels", value=self.taxels, remedy="State a pitch"
                )
        elif (self.pitch is None) == (self.taxels is None):
            raise SkinError("state the pitch or the number of taxels", place="pitch", value=(self.pitch, self.taxels))
        if self.taxels is not None and not 1 <= self.taxels <= MAX_PLACED_TAXELS:
            remedy = f"Choose 1 to {MAX_PLACED_TAXELS:,}"
            raise SkinError("the number of taxels is out of range", place="taxels", value=self.taxels, remedy=remedy)
        if self.pitch is not None and not _PITCH_RANGE[0] <= self.pitch <= _PITCH_RANGE[1]:
            remedy = f"Choose {_PITCH_RANGE[0]} to {_PITCH_RANGE[1]} m"
            raise SkinError("the pitch is out of range", place="pitch", value=f"{self.pitch} m", remedy=remedy)


_DENSITIES = "Choose curvature, or one value above zero for each vertex"


def _vector(values: FloatArray, where: str) -> FloatArray:
    own = readonly(values)
    if own.shape != (3,) or not np.isfinite(own).all():
        raise SkinError("three finite numbers are needed", place=where, value=own.tolist())
    return own


def _positive(values: FloatArray) -> FloatArray:
    own = readonly(values)
    if own.ndim != 1 or not (np.isfinite(own) & (own > 0)).all():
        raise SkinError("a density must be above zero everywhere", place="density", value=own, remedy=_DENSITIES)
    return own


EDGES_PER_PITCH = 2.5
"""Faces are divided until a taxel is this many edges across, so that its cell has about a dozen."""
MOST_FACES = 50
"""Of a taxel on average, however thin the surface's needles are; four times as many as its cell has elsewhere."""
HEXAGON_AREA = np.sqrt(3) / 2
"""Area of a taxel with six neighbours, in pitches squared."""


def place_taxels(surface: Mesh, spec: PlacementSpec) -> Taxels:
    """Place taxels on a surface that is fine enough for them.

    Args:
        surface: Connected, manifold, no face without area [m].
        spec: What is wanted; a painted density or zone has one value for each of the surface's vertices.

    Raises:
        SkinError: An edge is longer than the pitch (see ``refine_for_spec``), the zones leave nothing, more taxels
            are asked for than there are faces, or not one module fits.

    Cost: 1000 taxels on 26,000 faces take 0.6 s evenly or as a lattice; 100 modules 1 s.
    """
    allowed = allowed_faces(surface, spec.keep_out)
    room = float(surface.face_areas[allowed].sum())
    pitch = _pitch(spec, room)
    count = spec.taxels or max(1, round(room / (HEXAGON_AREA * pitch**2)))
    many = spec.pattern == "even" and int(allowed.sum()) > 0.5 * MOST_FACES * count  # needles, cut into long rungs
    if spec.taxels != 1 and not many:
        _refuse_coarse(surface, pitch)
    if spec.pattern == "modules":
        return place_modules(surface, pitch, allowed=allowed, seed=spec.seed)
    if spec.pattern == "hexagonal":
        return place_lattice(surface, count, pitch, allowed=allowed, seed=spec.seed)
    if spec.pattern == "even":
        density = None if spec.density is None else face_density(surface, spec, pitch=pitch)
        return place_evenly(surface, count, seed=spec.seed, density=density, allowed=allowed)
    assert_never(spec.pattern)


def refine_for_spec(surface: Mesh, spec: PlacementSpec) -> tuple[SubdividedMesh, PlacementSpec]:
    """The surface made fine enough for ``spec``, with the same shape, and ``spec`` with what is painted carried over.

    Raises:
        SkinError: As ``place_taxels``.
        MeshError: It would take more than two million faces.
    """
    room = float(surface.face_areas[allowed_faces(surface, spec.keep_out)].sum())
    pitch = _pitch(spec, room)
    if spec.density is not None:
        wanted = face_density(surface, spec, pitch=pitch)
        pitch /= np.sqrt(wanted.max() / np.average(wanted, weights=surface.face_areas))
    fine = subdivide(surface, longest=_longest_edge(surface, spec, room, pitch / EDGES_PER_PITCH))
    corners, weights = _coarse_barycentric(surface, fine)
    density = spec.density
    if density is not None and not isinstance(density, str):
        density = (density[corners] * weights).sum(axis=1)
    zones = [
        # A new vertex is marked where any corner is that it lies between, so that the painted zone does not shrink.
        PaintedZone(np.any(zone.vertices[corners] & (weights > 0), axis=1)) if isinstance(zone, PaintedZone) else zone
        for zone in spec.keep_out
    ]
    return fine, replace(spec, density=density, keep_out=tuple(zones))


def _longest_edge(surface: Mesh, spec: PlacementSpec, room: float, wanted: float) -> float:
    """``wanted`` [m], or what leaves a taxel ``MOST_FACES`` where the surface is mostly needles.

    On a needle far thinner than the pitch a taxel's cell is long, and would hold the more rungs the thinner it is.
    The lattices are drawn over faces and need short edges on needles as well.
    """
    if spec.pattern != "even":
        return wanted
    taxels = surface.area / (HEXAGON_AREA * _pitch(spec, room) ** 2)
    most = MOST_FACES * taxels + 4 * len(surface.faces)
    longest = wanted
    while subdivided_count(surface, longest=longest) > most:
        longest *= 1.1
    return longest


def _pitch(spec: PlacementSpec, room: float) -> float:
    """The pitch [m] on average over ``room`` [m²]."""
    if spec.pitch is not None:
        return spec.pitch
    return MODULE_PITCH if spec.taxels is None else float(np.sqrt(room / (HEXAGON_AREA * spec.taxels)))


def _refuse_coarse(surface: Mesh, pitch: float) -> None:
    ends = surface.vertices[surface.edges]
    longest = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
    if longest > pitch:
        raise SkinError(
            "the surface is too coarse for so fine a pitch",
            place="pitch",
            value=f"edges up to {1e3 * longest:.3g} mm, a pitch of {1e3 * pitch:.3g} mm",
            remedy="Divide the surface first, or ask for a larger pitch",
        )


def _coarse_barycentric(coarse: Mesh, fine: SubdividedMesh) -> tuple[IntArray, FloatArray]:
    """(n, 3) coarse corners that each fine vertex lies between, and its barycentric weights there."""
    face = np.zeros(len(fine.mesh.vertices), dtype=np.int64)
    face[fine.mesh.faces.ravel()] = np.repeat(fine.parent, 3)
    corners = coarse.faces[face]
    weights = barycentric(coarse.vertices[corners], fine.mesh.vertices)
    return corners, np.where(weights < 1e-9, 0.0, weights)


def allowed_faces(surface: Mesh, zones: Sequence[KeepOutZone]) -> BoolArray:
    """(m,) faces that lie outside all ``zones``.

    Raises:
        SkinError: None is left, or a painted zone has not one mark for each vertex.
    """
    allowed = np.ones(len(surface.faces), dtype=bool)
    for zone in zones:
        allowed &= ~_faces_in_zone(surface, zone)
    if not allowed.any():
        raise SkinError("nothing of the surface is left for taxels", place="keep out", remedy="Make the zones smaller")
    return allowed


def _faces_in_zone(surface: Mesh, zone: KeepOutZone) -> BoolArray:
    """(m,) faces that may reach into the zone."""
    corners = surface.vertices[surface.faces]
    if isinstance(zone, SphereZone):
        return np.asarray(_triangle_distances(corners, zone.centre) <= zone.radius)
    if isinstance(zone, BoxZone):
        return np.asarray(((corners.max(axis=1) >= zone.low) & (corners.min(axis=1) <= zone.high)).all(axis=1))
    if isinstance(zone, BoundaryZone):
        return np.asarray((_boundary_distances(surface)[surface.faces] < zone.width).any(axis=1))
    if isinstance(zone, PaintedZone):
        if len(zone.vertices) != len(surface.vertices):
            value = f"{len(zone.vertices)} for {len(surface.vertices)} vertices"
            raise SkinError("a painted zone needs one mark for each vertex", place="keep out", value=value)
        return np.asarray(zone.vertices[surface.faces].any(axis=1))
    assert_never(zone)


def _triangle_distances(corners: FloatArray, point: FloatArray) -> FloatArray:
    """(m,) exact distance of ``point`` (3,) from each triangle (m, 3, 3) [m]."""
    a, b, c = (corners[:, k] - point for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    above = np.all([(np.cross(q - p, -p) * normal).sum(axis=1) >= 0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
    plane = np.abs((a * normal).sum(axis=1)) / np.where(length > 0, length, 1.0)
    sides = np.min([_segment_distances(p, q) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.where(above & (length > 0), plane, sides)


def _segment_distances(start: FloatArray, end: FloatArray) -> FloatArray:
    """(m,) distance of the origin from each segment."""
    side = end - start
    squared = (side * side).sum(axis=1)
    along = np.clip(-(start * side).sum(axis=1) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    return np.linalg.norm(start + along[:, None] * side, axis=1)


def _boundary_distances(surface: Mesh) -> FloatArray:
    """(n,) distance of each vertex from the border along edges [m]; infinite on a closed surface."""
    border = np.unique(surface.connectivity.boundary_edges)
    if not len(border):
        return np.full(len(surface.vertices), np.inf)
    return distances_from(edge_graph(surface.edges, surface.edge_lengths, len(surface.vertices)), border)


MAX_DENSITY_RATIO = 4.0
"""At most this many times as many taxels per area where the surface bends, so at half the pitch."""


def face_density(surface: Mesh, spec: PlacementSpec, *, pitch: float) -> FloatArray:
    """(m,) the density that ``spec`` asks for on each face; ones where it asks for none.

    Args:
        surface: To place on.
        spec: What is wanted.
        pitch: Curvature is averaged over about this distance [m]; finer bends are between the taxels.

    Raises:
        SkinError: The density has not one value for each vertex.
    """
    if spec.density is None:
        return np.ones(len(surface.faces))
    wanted = curvature_density(surface, over=pitch) if isinstance(spec.density, str) else spec.density
    if len(wanted) != len(surface.vertices):
        value = f"{len(wanted)} for {len(surface.vertices)} vertices"
        raise SkinError("a density needs one value for each vertex", place="density", value=value)
    return np.asarray(wanted[surface.faces].mean(axis=1))


def curvature_density(surface: Mesh, *, over: float) -> FloatArray:
    """(n,) from 1 where the surface is flat towards ``MAX_DENSITY_RATIO`` where it bends far more than on average.

    With k the curvature and r its root mean square over the surface, 1 + 3 k² / (k² + r²): bounded, and the same for
    the same shape at another size.
    """
    squared = curvature(surface) ** 2
    average = averaging_matrix(surface.edges, len(surface.vertices))
    side = float(np.sqrt(surface.area / max(len(surface.faces), 1)))
    for _ in range(int(np.clip((over / side) ** 2, 1, 50))):  # steps of a random walk reach as far as their root
        squared = (squared + average @ squared) / 2
    share = np.bincount(surface.faces.ravel(), np.repeat(surface.face_areas, 3), len(surface.vertices))
    usual = float((squared * share).sum() / share.sum())
    flat = usual * surface.area < 1e-12  # bends by less than a millionth over its own size
    return np.ones(len(squared)) if flat else 1.0 + (MAX_DENSITY_RATIO - 1.0) * squared / (squared + usual)


def curvature(surface: Mesh) -> FloatArray:
    """(n,) root of the sum of the squared principal curvatures at each vertex [1/m]: 1/r on a cylinder, √2/r on a ball.

    It is the size of the normals' gradient over each face (Rusinkiewicz 2004), averaged by area.
    """
    corners = surface.vertices[surface.faces]
    normals = surface.vertex_normals[surface.faces]
    twice = 2 * surface.face_areas
    # The gradient of a corner's weight is the side opposite to it, turned by a right angle in the face's plane.
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    slopes = np.cross(surface.face_normals[:, None], opposite) / np.where(twice > 0, twice, np.inf)[:, None, None]
    gradient = np.linalg.norm(np.einsum("mci,mcj->mij", normals, slopes), axis=(1, 2))
    total = np.bincount(surface.faces.ravel(), np.repeat(gradient * twice, 3), len(surface.vertices))
    weight = np.bincount(surface.faces.ravel(), np.repeat(twice, 3), len(surface.vertices))
    return total / np.where(weight > 0, weight, 1.0)
