"""Placement of taxels on a surface by number or pitch, pattern, density and keep-out zones.

``PlacementSpec`` specifies the taxels, ``place_taxels`` places them on a surface that is fine enough
(``refine_for_spec`` divides one that is not). The even pattern is in ``sampling``, the hexagonal lattice and the
triangular modules are in ``patterns``.

Keep-out zones: a face is excluded if any part of it may be in a zone, so that all taxels are outside. Excluded faces,
for example at a connector, a screw or a joint, have no quadrature points.

Density: relative number of taxels per area, painted or by curvature (Rusinkiewicz 2004).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, assert_never, get_args

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly, set_fields
from tactile_maps.core.errors import SkinError, check_range
from tactile_maps.geometry.geodesics import distances_from, edge_graph
from tactile_maps.geometry.remesh.refine import SubdividedMesh, subdivide, subdivided_count
from tactile_maps.geometry.surface.closest_point import barycentric
from tactile_maps.geometry.surface.connectivity import averaging_matrix
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Taxels, taxels_with_axes
from tactile_maps.skin.model.taxel_axes import check_number_of_axes
from tactile_maps.skin.taxel_placement.patterns import place_lattice, place_modules
from tactile_maps.skin.taxel_placement.sampling import place_evenly

Pattern = Literal["even", "hexagonal", "modules"]
MODULE_PITCH = 0.0065
"""Distance of taxels on the triangular modules of iCub and CySkin [m]."""
MAX_PLACED_TAXELS = 100_000
_PITCH_RANGE = 1e-5, 1.0


@dataclass(frozen=True, eq=False)
class SphereZone:
    """Ball without taxels: ``centre`` (3,) [m] in the frame of the surface, ``radius`` [m]."""

    centre: FloatArray
    radius: float

    def __post_init__(self) -> None:
        set_fields(self, centre=_vector(self.centre, "ball"))
        if not 0 < self.radius < np.inf:
            raise SkinError("an excluded ball needs a radius above zero", place="keep out", value=self.radius)


@dataclass(frozen=True, eq=False)
class BoxZone:
    """Box without taxels along the axes of the surface's frame: corners ``low`` and ``high`` (3,) [m]."""

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
    """Strip without taxels along the border of the surface, ``width`` [m] measured along mesh edges."""

    width: float

    def __post_init__(self) -> None:
        if not 0 <= self.width < np.inf:
            raise SkinError("an excluded strip needs a width", place="keep out", value=self.width)


@dataclass(frozen=True, eq=False)
class PaintedZone(ArrayFields):
    """Faces without taxels: those with a marked corner, ``vertices`` (n,) true where marked."""

    vertices: BoolArray


KeepOutZone: TypeAlias = SphereZone | BoxZone | BoundaryZone | PaintedZone


@dataclass(frozen=True, eq=False)
class PlacementSpec:
    """Specification of taxels on a surface.

    Attributes:
        pitch: Distance between neighbours [m]; where the density varies, its average over the surface.
        taxels: Number of taxels. State it or the pitch, not both; modules need neither and have a default pitch.
        pattern: ``even``; ``hexagonal``, a lattice that follows the surface; ``modules``, as many triangles of ten
            taxels as fit.
        density: Relative number of taxels per area, for the pattern ``even``: None for a constant one, ``curvature``
            for more taxels where the surface bends, or a value above zero for each vertex.
        keep_out: Zones without taxels and quadrature points.
        seed: Seed of the random choices.
        axes: Number of axes of each taxel: 1 (pressure) or 3 (pressure and shear).
    """

    pitch: float | None = None
    taxels: int | None = None
    pattern: Pattern = "even"
    density: Literal["curvature"] | FloatArray | None = None
    keep_out: tuple[KeepOutZone, ...] = ()
    seed: int = 0
    axes: int = 1

    def __post_init__(self) -> None:
        check_number_of_axes(self.axes)
        if self.pattern not in get_args(Pattern):
            remedy = f"Choose one of: {', '.join(get_args(Pattern))}"
            raise SkinError("unknown pattern", place="pattern", value=self.pattern, remedy=remedy)
        self._check_number()
        if isinstance(self.density, str) and self.density != "curvature":
            raise SkinError("unknown density", place="density", value=self.density, remedy=_DENSITIES)
        if self.density is not None and self.pattern != "even":
            raise SkinError("only the even pattern follows a density", place="density", value=self.pattern)
        if self.density is not None and not isinstance(self.density, str):
            set_fields(self, density=_positive(self.density))

    def restricted_to(self, vertices: IntArray, *, taxels: int | None = None) -> PlacementSpec:
        """Return the specification for a part of the surface.

        Args:
            vertices: (k,) vertices of the part, as indices into those of the whole surface.
            taxels: Number of taxels of the part, if it was specified by number.
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
        if self.taxels is not None:
            check_range("the number of taxels", self.taxels, 1, MAX_PLACED_TAXELS, error=SkinError, place="taxels")
        if self.pitch is not None:
            check_range("the pitch", self.pitch, *_PITCH_RANGE, error=SkinError, place="pitch", unit="m")


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
"""Number of edges along a pitch after the division of faces; a cell then has about a dozen faces."""
MOST_FACES = 50
"""Largest mean number of faces per taxel on a surface with thin needles, four times that of other surfaces."""
HEXAGON_AREA = np.sqrt(3) / 2
"""Area of a taxel with six neighbours [pitch²]."""


def place_taxels(surface: Mesh, spec: PlacementSpec) -> Taxels:
    """Place taxels on a surface that is fine enough for them.

    Args:
        surface: Connected manifold surface without faces of zero area [m].
        spec: The specification; a painted density or zone has one value for each vertex of the surface.

    Raises:
        SkinError: An edge is longer than the pitch (see ``refine_for_spec``), the zones cover the whole surface, there
            are more taxels than faces, or no module fits.

    Cost: 1000 taxels on 26,000 faces take 0.6 s evenly or as a lattice; 100 modules 1 s.
    """
    return taxels_with_axes(_placed(surface, spec), spec.axes)


def _placed(surface: Mesh, spec: PlacementSpec) -> Taxels:
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
    """Return the surface divided finely enough for ``spec``, and ``spec`` with its painted values on new vertices.

    Raises:
        SkinError: See ``place_taxels``.
        MeshError: The surface would have more than two million faces.
    """
    room = float(surface.face_areas[allowed_faces(surface, spec.keep_out)].sum())
    pitch = _pitch(spec, room)
    if spec.density is not None:
        density = face_density(surface, spec, pitch=pitch)
        pitch /= np.sqrt(density.max() / np.average(density, weights=surface.face_areas))
    fine = subdivide(surface, longest=_longest_edge(surface, spec, room, pitch / EDGES_PER_PITCH))
    corners, weights = _coarse_barycentric(surface, fine)
    painted = spec.density
    if isinstance(painted, np.ndarray):
        painted = (painted[corners] * weights).sum(axis=1)
    zones = [
        # A new vertex between corners is marked if any of them is, so that the painted zone does not shrink.
        PaintedZone(np.any(zone.vertices[corners] & (weights > 0), axis=1)) if isinstance(zone, PaintedZone) else zone
        for zone in spec.keep_out
    ]
    return fine, replace(spec, density=painted, keep_out=tuple(zones))


def _longest_edge(surface: Mesh, spec: PlacementSpec, room: float, longest: float) -> float:
    """Return ``longest`` [m], or on a surface of thin needles the length at which a taxel has ``MOST_FACES`` faces.

    On a needle far thinner than the pitch the cell of a taxel is long: the thinner the needle, the more faces it would
    have. Lattices need short edges on needles as well.
    """
    if spec.pattern == "even":
        taxels = surface.area / (HEXAGON_AREA * _pitch(spec, room) ** 2)
        while subdivided_count(surface, longest=longest) > MOST_FACES * taxels + 4 * len(surface.faces):
            longest *= 1.1
    return longest


def _pitch(spec: PlacementSpec, room: float) -> float:
    """Return the average pitch [m] over an area ``room`` [m²]."""
    if spec.pitch is not None:
        return spec.pitch
    return MODULE_PITCH if spec.taxels is None else float(np.sqrt(room / (HEXAGON_AREA * spec.taxels)))


def _refuse_coarse(surface: Mesh, pitch: float) -> None:
    longest = float(surface.edge_lengths.max())
    if longest > pitch:
        raise SkinError(
            "the surface is too coarse for so fine a pitch",
            place="pitch",
            value=f"edges up to {1e3 * longest:.3g} mm, a pitch of {1e3 * pitch:.3g} mm",
            remedy="Divide the surface first, or choose a larger pitch",
        )


def _coarse_barycentric(coarse: Mesh, fine: SubdividedMesh) -> tuple[IntArray, FloatArray]:
    """Return for each fine vertex the corners (n, 3) of its coarse face, and its barycentric weights (n, 3) there."""
    face = np.zeros(len(fine.mesh.vertices), dtype=np.int64)
    face[fine.mesh.faces.ravel()] = np.repeat(fine.parent, 3)
    corners = coarse.faces[face]
    weights = barycentric(coarse.vertices[corners], fine.mesh.vertices)
    return corners, np.where(weights < 1e-9, 0.0, weights)


def allowed_faces(surface: Mesh, zones: Sequence[KeepOutZone]) -> BoolArray:
    """Return (m,) whether each face is outside all ``zones``.

    Raises:
        SkinError: No face is outside, or a painted zone does not have one mark for each vertex.
    """
    allowed = np.ones(len(surface.faces), dtype=bool)
    for zone in zones:
        allowed &= ~_faces_in_zone(surface, zone)
    if not allowed.any():
        raise SkinError("nothing of the surface is left for taxels", place="keep out", remedy="Make the zones smaller")
    return allowed


def _faces_in_zone(surface: Mesh, zone: KeepOutZone) -> BoolArray:
    """Return (m,) whether each face may reach into the zone."""
    corners = surface.corners
    if isinstance(zone, SphereZone):
        import trimesh  # 0.1 s, not needed for maps from files

        closest = trimesh.triangles.closest_point(corners, np.broadcast_to(zone.centre, corners[:, 0].shape))
        return np.asarray(np.linalg.norm(closest - zone.centre, axis=1) <= zone.radius)
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


def _boundary_distances(surface: Mesh) -> FloatArray:
    """Return (n,) distance of each vertex from the border along edges [m]; infinite on a closed surface."""
    border = np.unique(surface.connectivity.boundary_edges)
    if not len(border):
        return np.full(len(surface.vertices), np.inf)
    return distances_from(edge_graph(surface.edges, surface.edge_lengths, len(surface.vertices)), border)


MAX_DENSITY_RATIO = 4.0
"""Largest ratio of the density on curved parts to that on flat ones; the pitch there is half as large."""


def face_density(surface: Mesh, spec: PlacementSpec, *, pitch: float) -> FloatArray:
    """Return (m,) the density of ``spec`` on each face; ones without a density.

    Args:
        surface: Surface for the taxels.
        spec: The specification.
        pitch: Distance over which curvature is averaged [m]; details between taxels do not count.

    Raises:
        SkinError: The density does not have one value for each vertex.
    """
    if spec.density is None:
        return np.ones(len(surface.faces))
    density = curvature_density(surface, over=pitch) if isinstance(spec.density, str) else spec.density
    if len(density) != len(surface.vertices):
        value = f"{len(density)} for {len(surface.vertices)} vertices"
        raise SkinError("a density needs one value for each vertex", place="density", value=value)
    return np.asarray(density[surface.faces].mean(axis=1))


def curvature_density(surface: Mesh, *, over: float) -> FloatArray:
    """Return (n,) density of each vertex, from 1 on flat parts to ``MAX_DENSITY_RATIO`` on strongly curved ones.

    It is 1 + 3 k² / (k² + r²) for the curvature k and its root mean square r over the surface: bounded, and independent
    of the scale.
    """
    squared = curvature(surface) ** 2
    average = averaging_matrix(surface.edges, len(surface.vertices))
    side = float(np.sqrt(surface.area / max(len(surface.faces), 1)))
    for _ in range(int(np.clip((over / side) ** 2, 1, 50))):  # a random walk of n steps reaches sqrt(n) edges
        squared = (squared + average @ squared) / 2
    share = np.bincount(surface.faces.ravel(), np.repeat(surface.face_areas, 3), len(surface.vertices))
    usual = float((squared * share).sum() / share.sum())
    flat = usual * surface.area < 1e-12  # bends by less than a millionth over its own size
    return np.ones(len(squared)) if flat else 1.0 + (MAX_DENSITY_RATIO - 1.0) * squared / (squared + usual)


def curvature(surface: Mesh) -> FloatArray:
    """Return (n,) root of the sum of squared principal curvatures [1/m]: 1/r on a cylinder, √2/r on a sphere.

    It is the norm of the gradient of the normals over each face (Rusinkiewicz 2004), averaged by area.
    """
    corners = surface.corners
    normals = surface.vertex_normals[surface.faces]
    twice = 2 * surface.face_areas
    # The gradient of the weight of a corner is the opposite side, rotated by a right angle in the plane of the face.
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    slopes = np.cross(surface.face_normals[:, None], opposite) / np.where(twice > 0, twice, np.inf)[:, None, None]
    gradient = np.linalg.norm(np.einsum("mci,mcj->mij", normals, slopes), axis=(1, 2))
    total = np.bincount(surface.faces.ravel(), np.repeat(gradient * twice, 3), len(surface.vertices))
    weight = np.bincount(surface.faces.ravel(), np.repeat(twice, 3), len(surface.vertices))
    return total / np.where(weight > 0, weight, 1.0)
