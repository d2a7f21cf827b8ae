"""Automatic skin on a robot: links are chosen and wrapped, and taxels are placed clear of the joints.

``CoverSpec`` is the specification. The mesh of each link, in any state, is wrapped. Parts that are too close to other
links or not visible from outside stay bare (``usable_surface``); the rest gets taxels in proportion to its area.
Without named links, at least three moving links with a large exposed area are covered (``choose_links``);
``cover_candidates`` lists all links for a choice by the user.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.caches import content_cache, weak_cache
from tactile_maps.core.errors import Finding, SkinError, check_names, check_range
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.remesh.wrap import coarsest_voxel, wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration, limb_joints, link_parents
from tactile_maps.robots.model.proportions import OVERSIZED
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.skin.fitting.sheets import two_sided_findings
from tactile_maps.skin.model.skin import (
    LOW_COVERAGE,
    PLACEHOLDER_COVERED,
    Patch,
    Skin,
    Taxels,
    low_coverage,
    patch_name,
    taxels_with_axes,
)
from tactile_maps.skin.model.taxel_axes import check_number_of_axes
from tactile_maps.skin.taxel_placement.placement import (
    HEXAGON_AREA,
    MODULE_PITCH,
    Pattern,
    PlacementSpec,
    place_taxels,
    refine_for_spec,
)
from tactile_maps.skin.taxel_placement.sampling import place_evenly, share_by_area
from tactile_maps.skin.taxel_placement.usable_surface import (
    sample_surface,
    usable_components,
    vertices_clear_of,
    visible_from_outside,
)

MIN_COVER_TAXELS = 4
MAX_COVER_TAXELS = 20_000
COVER_LENGTHS = {"thickness": (1e-4, 0.1), "margin": (0.0, 0.1), "pitch": (5e-4, 0.2)}
"""Smallest and largest value of each length of a cover [m]."""
CLOSING_FACTOR = 3.0
"""Radius of the ball, in thicknesses of the cover, that cannot enter the hollows that a cover spans."""


NO_ROOM = "no-room"
"""Kind of the findings about links, or pieces of them, that get no taxels."""
JOINT_CLEARANCE = 0.010
"""Default distance of skin from other links [m], so that joints can move."""


@dataclass(frozen=True)
class CoverSpec:
    """Specification of a cover.

    Attributes:
        links: Names of the links to cover; empty to choose the largest ones.
        taxels: Total number of taxels, distributed by area. Ignored with a pitch, and for modules.
        thickness: Thickness of the cover over the mesh of a link [m].
        seed: Seed for the choice of the first taxel of each patch.
        pitch: Distance between neighbouring taxels [m], instead of their number; None for ``taxels``, or for the pitch
            of modules as built for iCub and CySkin.
        pattern: ``even``; ``hexagonal``, a lattice that follows the surface; ``modules``, as many triangles of ten
            taxels as fit.
        density: ``uniform``, or ``curvature`` for more taxels where the surface bends, for the pattern ``even``.
        margin: Distance of the skin from other links [m].
        axes: Number of axes of each taxel: 1 (pressure) or 3 (pressure and shear; t1 follows the map).
        bare: Links whose share of the taxels is left out: the other links are covered as if these were covered, too.

    Example:
        >>> tm.CoverSpec(links=("upper_arm", "forearm"), taxels=400).thickness
        0.003
    """

    links: tuple[str, ...] = ()
    taxels: int = 1000
    thickness: float = 0.003
    seed: int = 0
    pitch: float | None = None
    pattern: Pattern = "even"
    density: Literal["uniform", "curvature"] = "uniform"
    margin: float = JOINT_CLEARANCE
    axes: int = 1
    bare: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_names(self.links, "links", error=SkinError)
        check_names(self.bare, "bare", error=SkinError)
        check_number_of_axes(self.axes)
        if self.links and (unknown := sorted({*self.bare} - {*self.links})):
            remedy = f"Choose among the links of the cover: {', '.join(self.links)}"
            raise SkinError("a bare link is not a link of the cover", place="bare", value=unknown[0], remedy=remedy)
        limits = (MIN_COVER_TAXELS, MAX_COVER_TAXELS)
        check_range("the number of taxels", self.taxels, *limits, error=SkinError, place="taxels")
        for place, lengths in COVER_LENGTHS.items():
            if (length := getattr(self, place)) is not None:
                name = "cover thickness" if place == "thickness" else place
                check_range(f"the {name}", length, *lengths, error=SkinError, place=place, unit="m")
        if self.density not in ("uniform", "curvature"):
            raise SkinError(
                "unknown density", place="density", value=self.density, remedy="Choose uniform or curvature"
            )
        self.placement(self.taxels)  # checks the pattern

    @property
    def taxel_area(self) -> float | None:
        """Area of a taxel that follows from the pitch [m²]; None if their number is specified."""
        pitch = MODULE_PITCH if self.pitch is None and self.pattern == "modules" else self.pitch
        return None if pitch is None else float(HEXAGON_AREA * pitch**2)

    def placement(self, taxels: int) -> PlacementSpec:
        """Return the specification for one patch of the cover with ``taxels`` taxels."""
        number = None if self.pattern == "modules" else taxels
        pitch = self.pitch if number is None else None
        return PlacementSpec(
            pitch,
            number,
            self.pattern,
            None if self.density == "uniform" else self.density,
            seed=self.seed,
            axes=self.axes,
        )


FACES_PER_TAXEL = 12
_MIN_TAXELS = 12
_MIN_SHARE = 0.15
_MAX_HOLE_TAXELS = 4


def cover_robot(robot: Robot, spec: CoverSpec | None = None, *, progress: Progress = no_progress) -> Skin:
    """Return a skin that covers links of a robot.

    Args:
        robot: Robot whose meshes may be in any state; see ``geometry.remesh.wrap``.
        spec: Specification; by default 1000 taxels on the links of ``choose_links``. If these have no room for skin,
            the next ones are covered instead, with a finding.
        progress: Receives a text and the fraction done, 0 to 1; may raise to cancel.

    Raises:
        SkinError: No link can be covered, a named link has no geometry, or a mesh is too large for the robot.
        RobotError: A named link does not exist.

    Example:
        >>> skin = tm.cover_robot(robot, tm.CoverSpec(links=("hand",), taxels=60))
        >>> len(skin), [patch.link for patch in skin.patches]
        (60, ['hand'])

    Cost: about 1 s for 1000 taxels on three links.
    """
    spec = spec or CoverSpec()
    _check_sizes(robot)
    choices = [spec.links] if spec.links else _link_choices(robot)
    meshes, findings = _cleaned_links(robot)
    _check_links(robot, choices[0], meshes)
    findings += placeholder_notes(robot, spec.links)
    configuration = Configuration(robot)
    for links in choices:
        pieces, usable_area, notes = _pieces_of_links(configuration, meshes, links, spec, progress)
        findings += notes
        if pieces:
            break
    if not pieces:
        raise SkinError(
            "no surface is left for skin outside the clearance of the joints",
            file=robot.source,
            place=", ".join(choices[0]),
            remedy="Choose other links or a thinner cover" if spec.links else "Choose a thinner cover",
        )
    if links is not choices[0]:
        action = f"covered, because there is no room on {', '.join(choices[0])}"
        covered = dict.fromkeys(link for link, _ in pieces)
        findings.append(Finding("other-links", ", ".join(covered), action, len(covered)))
    progress("Placing taxels", 0.7)
    patches, notes = _patches(pieces, spec)
    findings += notes
    skin = Skin(patches, bare_area=max(usable_area - sum(patch.surface.area for patch in patches), 0.0))
    if skin.coverage < LOW_COVERAGE:
        reasons = f"pieces below {100 * _MIN_SHARE:.0f} % of their link's cover or {_MIN_TAXELS} taxels are left out"
        remedy = "place more taxels, or name other links"
        findings.append(low_coverage(", ".join(links), skin.coverage, reasons, remedy, 1))
    return replace(skin, findings=(*findings, *two_sided_findings(skin, meshes)))


def with_covers(skin: Skin, covers: Sequence[Skin]) -> Skin:
    """Return the skin with the patches of further covers after its own, each patch with its own name."""
    patches = list(skin.patches)
    for patch in (patch for cover in covers for patch in cover.patches):
        before = sum(other.link == patch.link for other in patches)
        patches.append(replace(patch, name=patch_name(patch.link, before)))
    findings = (finding for one in (skin, *covers) for finding in one.findings)
    return Skin(tuple(patches), tuple(findings), sum(one.bare_area for one in (skin, *covers)))


def _check_sizes(robot: Robot) -> None:
    """Raise SkinError for a robot with an oversized mesh: its shape is resolved to millimetres, which takes hours."""
    for note in robot.findings:
        if note.kind == OVERSIZED:
            problem = "the mesh of a link is too large for the robot, which therefore cannot be covered"
            remedy = note.action[0].upper() + note.action[1:]
            raise SkinError(problem, file=robot.source, place=f"link {note.where}", remedy=remedy)


def _check_links(robot: Robot, links: tuple[str, ...], meshes: dict[str, Mesh]) -> None:
    bare = [name for name in links if robot.link(name).name not in meshes]
    if bare:
        raise SkinError(
            "the link has no geometry for a skin",
            file=robot.source,
            value=bare[0],
            remedy=f"Choose among: {', '.join(meshes)}",
        )


def placeholder_notes(robot: Robot, links: Sequence[str]) -> list[Finding]:
    """Return a finding for each link whose mesh is missing, because its cover follows the placeholder."""
    action = "its mesh is missing: the small box in its place is covered, as the link is named"
    return [Finding(PLACEHOLDER_COVERED, link, action) for link in links if robot.link(link).missing]


def _cleaned_links(robot: Robot) -> tuple[dict[str, Mesh], list[Finding]]:
    meshes: dict[str, Mesh] = {}
    findings: list[Finding] = []
    for link in robot.links:
        if link.mesh is not None and len(link.mesh.faces):
            meshes[link.name], notes = clean_mesh(link.mesh, where=link.name)
            findings += notes
    return meshes, findings


def _voxel(meshes: dict[str, Mesh], spec: CoverSpec) -> float:
    """Return the edge length for about ``FACES_PER_TAXEL`` faces per taxel; an area of voxel² has about three.

    Raises:
        SkinError: The pitch places more than ``MAX_COVER_TAXELS`` taxels.
    """
    area = sum(hull_area(mesh) for mesh in meshes.values())
    taxel_area = spec.taxel_area or area / spec.taxels
    if area > MAX_COVER_TAXELS * taxel_area:
        finest = 1e3 * np.sqrt(area / (HEXAGON_AREA * MAX_COVER_TAXELS))
        raise SkinError(
            f"the pitch places more than {MAX_COVER_TAXELS:,} taxels",
            place="pitch",
            value=f"{1e3 * np.sqrt(taxel_area / HEXAGON_AREA):.3g} mm on {1e4 * area:.0f} cm²",
            remedy=f"Choose at least {finest:.3g} mm, or fewer links",
        )
    return float(np.sqrt(3.0 * taxel_area / FACES_PER_TAXEL))


def _content(
    configuration: Configuration, meshes: dict[str, Mesh], links: Sequence[str], spec: CoverSpec, _progress: Progress, /
) -> Iterator[ArrayLike]:
    yield from (list(meshes), links, spec.bare)
    yield from (spec.thickness, spec.margin, spec.taxel_area or 0.0, spec.taxels)
    for name, mesh in meshes.items():
        pose = configuration.pose(name)
        yield from (mesh.vertices, mesh.faces, pose.rotation, pose.translation)


@content_cache(_content, most=4)
def _pieces_of_links(
    configuration: Configuration, meshes: dict[str, Mesh], links: Sequence[str], spec: CoverSpec, progress: Progress
) -> tuple[list[tuple[str, Mesh]], float, list[Finding]]:
    """Return the usable pieces of ``links``, each with its link; and of those that are not bare, area and findings."""
    voxel = _voxel({name: meshes[name] for name in links}, spec)
    spacing = min(voxel, coarsest_voxel(spec.thickness))
    clouds = {name: sample_surface(mesh, spacing) for name, mesh in meshes.items()}
    pieces = list[tuple[str, Mesh]]()
    usable_area = 0.0
    findings = list[Finding]()
    for i, name in enumerate(links):
        progress(f"Covering {name}", 0.7 * i / len(links))
        found, area, notes = _usable_pieces(configuration, meshes, clouds, name, spec, voxel)
        pieces += [(name, surface) for surface in found]
        if name not in spec.bare:
            usable_area += area
            findings += notes
    return pieces, usable_area, findings


def _usable_pieces(
    configuration: Configuration,
    meshes: dict[str, Mesh],
    clouds: dict[str, FloatArray],
    name: str,
    spec: CoverSpec,
    voxel: float,
) -> tuple[list[Mesh], float, list[Finding]]:
    """Return the usable pieces of a link, its area that is visible and clear of other links [m²], and findings.

    ``clouds`` are points of the meshes of all links, in their own frames.
    """
    closing = CLOSING_FACTOR * spec.thickness
    wrapped = wrap_mesh(meshes[name], thickness=spec.thickness, voxel=voxel, closing=closing, where=name)
    here = configuration.pose(name).inverse
    poses = {other: here @ configuration.pose(other) for other in meshes if other != name}
    others = [(pose, meshes[other]) for other, pose in poses.items()]
    blockers = [pose.points(clouds[other]) for other, pose in poses.items()]
    clear = vertices_clear_of(wrapped.surface, others, distance=spec.margin)
    usable = clear & visible_from_outside(wrapped.surface, blockers, voxel=wrapped.voxel)
    taxel_area = FACES_PER_TAXEL * voxel**2 / 3
    smallest = max(_MIN_SHARE * wrapped.surface.area, _MIN_TAXELS * taxel_area)
    found = usable_components(wrapped.surface, usable, smallest=smallest, largest_hole=_MAX_HOLE_TAXELS * taxel_area)
    notes = list(wrapped.findings)
    faces = wrapped.surface.faces
    usable_area = float(wrapped.surface.face_areas[usable[faces].all(axis=1)].sum())
    if not found:
        if not clear[faces].all(axis=1).any():
            reason = f"other links are closer than the margin of {1e3 * spec.margin:.3g} mm everywhere"
        elif usable_area == 0:
            reason = "the parts that are clear of other links are hidden from outside"
        else:
            few = _MIN_TAXELS * taxel_area >= smallest
            least = (
                f"{_MIN_TAXELS} taxels need" if few else f"a piece is at least {100 * _MIN_SHARE:.0f} % of its surface,"
            )
            free = f"only {_area_text(usable_area)} are clear of other links and visible"
            reason = f"{free}, {least} {_area_text(smallest)}"
        notes.append(Finding(NO_ROOM, name, f"not covered: {reason}"))
    return found, usable_area, notes


def _area_text(area: float) -> str:
    return f"{1e4 * area:.2g} cm²" if area < 1e-3 else f"{1e4 * area:,.0f} cm²"


def _patches(pieces: Sequence[tuple[str, Mesh]], spec: CoverSpec) -> tuple[tuple[Patch, ...], list[Finding]]:
    """Return the patches, and findings about pieces on which nothing of the pattern fits.

    Raises:
        SkinError: Nothing fits on any piece, or all are on bare links.
    """
    areas = np.array([surface.area for _, surface in pieces])
    taxel_area = spec.taxel_area
    counts = share_by_area(areas, spec.taxels) if taxel_area is None else np.round(areas / taxel_area).astype(int)
    patches = list[Patch]()
    findings = list[Finding]()
    reason = SkinError("all links of the cover are bare", place="bare", remedy="Leave out the cover")
    for (link, piece), count in zip(pieces, np.maximum(counts, 1).tolist(), strict=True):
        if link in spec.bare:
            continue
        try:
            surface, taxels = _placed(piece, spec, count)
        except SkinError as error:
            if spec.pattern != "modules":
                raise
            findings.append(Finding(NO_ROOM, link, "not covered: no module fits on a piece of it"))
            reason = error
            continue
        before = sum(patch.link == link for patch in patches)
        patches.append(Patch(patch_name(link, before), link, surface, taxels))
    if not patches:
        raise reason
    return tuple(patches), findings


def _placed(piece: Mesh, spec: CoverSpec, count: int) -> tuple[Mesh, Taxels]:
    """Return a piece of the cover, divided further where its pattern needs that, and its taxels."""
    if spec.pattern == "even" and spec.density == "uniform":
        return piece, taxels_with_axes(place_evenly(piece, count, seed=spec.seed), spec.axes)
    fine, placement = refine_for_spec(piece, spec.placement(count))
    return fine.mesh, place_taxels(fine.mesh, placement)


@dataclass(frozen=True)
class CoverCandidate:
    """A link, for choosing the links to cover.

    Attributes:
        link: Name of the link.
        area: Area of its convex hull outside the hulls of the other links in the home posture [m²]; 0 without a shape.
        moves: Whether joints move it.
        reason: Why it cannot be covered; empty if it can, as far as is known before its surface is made.
        parent: Name of the link that carries it; empty for a link on the base.
    """

    link: str
    area: float
    moves: bool
    reason: str = ""
    parent: str = ""


def cover_candidates(robot: Robot, *, measured: bool = True) -> tuple[CoverCandidate, ...]:
    """Return all links of a robot in its order, with the area that a cover may have.

    Args:
        robot: The robot.
        measured: Whether to compute the areas; otherwise they are 0.

    Cost: 1 to 20 ms a link, by the size of its mesh; 0.1 ms without areas.
    """
    configuration = Configuration(robot)
    areas = {link: area.exposed for link, area in _link_areas(robot).items()} if measured else {}
    with_shape = {link.name for link in robot.links if _has_shape(link)}
    moved = _moved_links(robot, configuration)
    reasons = {link.name: "its mesh file is missing" if link.missing else "it has no shape" for link in robot.links}
    parents = link_parents(robot)
    return tuple(
        CoverCandidate(
            link.name,
            areas.get(link.name, 0.0),
            link.name in moved,
            "" if link.name in with_shape else reasons[link.name],
            parents[link.name],
        )
        for link in robot.links
    )


AUTOMATIC_LINKS = 3
"""Smallest number of links that are chosen, if the robot has so many."""
_EQUAL = 0.02
"""Relative difference of the hulls of links that are regarded as equal, such as left and right."""
_NO_SKIN = {"head", "neck", "eye", "camera", "box", "wheel", "caster"}
"""Words in the names of links that are covered last."""
_SAMPLES = 400
"""Number of points from which the exposed share of a link is found."""
_ROBERTS = (0.7548776662466927, 0.5698402909980532)
"""Steps of the two-dimensional additive sequence: the inverse powers of the root of x^3 = x + 1."""
_Hull: TypeAlias = tuple[FloatArray, ConvexHull | None]


def choose_links(robot: Robot) -> tuple[str, ...]:
    """Return the links that are covered if none are named, in robot order.

    These are at least three moving links (any, on a robot without joints) with large exposed hulls, those of arms and
    legs before others. Of links with equal shapes, such as the thighs of all legs, all are chosen or none.

    Raises:
        SkinError: No link has geometry of its own.
    """
    return _link_choices(robot)[0]


def _link_choices(robot: Robot) -> list[tuple[str, ...]]:
    """Return choices of links, each in robot order: moving links first, then others.

    The exposed area of a hull is outside the hulls of all other links in the home posture: a thick hub inside its
    neighbours is not suitable for skin. Placeholders of missing meshes are never chosen.

    Raises:
        SkinError: No link has geometry of its own.
    """
    configuration = Configuration(robot)
    areas = _link_areas(robot)
    moved = _moved_links(robot, configuration)
    missing = [link.name for link in robot.links if link.missing]
    if not areas and missing:
        first = [f"{note.where}: {note.action}" for note in robot.findings if note.kind == "missing-mesh"][:1]
        raise SkinError(
            "the meshes of all links with a shape are missing",
            file=robot.source,
            value="; ".join([", ".join(missing), *first]),
            remedy="Put the mesh files in place, or name the links to cover the small boxes in their place",
        )
    if not areas:
        raise SkinError("no link of the robot has geometry", file=robot.source, remedy="Open a robot with meshes")
    groups = _equal_links(configuration, areas)
    limbs = limb_joints(robot)
    longest = max((limbs[name] for name in areas), default=0)

    def rank(group: list[str]) -> tuple[bool, bool, float]:
        """Return the order of a group: suitable links first, then those of long limbs, then large ones."""
        words = set(re.split(r"[^a-z]+", " ".join(group).lower()))
        return bool(words & _NO_SKIN), 2 * limbs[group[0]] < longest, -max(areas[name].exposed for name in group)

    chosen = list[tuple[str, ...]]()
    for moving in (True, False):
        links = list[str]()
        ranked = sorted((group for group in groups if (group[0] in moved) is moving), key=rank)
        for group in ranked:
            links += group
            if len(links) >= AUTOMATIC_LINKS or group is ranked[-1]:
                chosen.append(tuple(name for name in areas if name in links))
                links = []
    return chosen


def _equal_links(configuration: Configuration, areas: dict[str, _LinkArea]) -> list[list[str]]:
    """Return the links in groups of equal area behind the same number of joints, in robot order."""
    groups = list[list[str]]()
    joints = {name: len(configuration.joints_before(name)) for name in areas}
    for name, area in areas.items():
        for group in groups:
            other = areas[group[0]]
            if joints[group[0]] == joints[name] and abs(area.hull - other.hull) <= _EQUAL * other.hull:
                group.append(name)
                break
        else:
            groups.append([name])
    return groups


@dataclass(frozen=True)
class _LinkArea:
    """Area of the convex hull of a link, and of the part of it outside the hulls of the other links [m²]."""

    hull: float
    exposed: float


@weak_cache
def _has_shape(link: Link) -> bool:
    """Return whether a link has a mesh of its own that is not a placeholder for a missing one."""
    return link.mesh is not None and len(link.mesh.faces) > 0 and not link.missing


def _shapes(robot: Robot) -> Iterator[ArrayLike]:
    configuration = Configuration(robot)
    for link in robot.links:
        if link.mesh is not None and _has_shape(link):
            pose = configuration.pose(link.name)
            yield from (link.name, link.mesh.vertices, link.mesh.faces, pose.rotation, pose.translation)


@content_cache(_shapes, most=4)
def _link_areas(robot: Robot) -> dict[str, _LinkArea]:
    """Return the areas of each link that has a shape of its own, in robot order, in the home posture."""
    configuration = Configuration(robot)
    hulls = {link.name: _convex_hull(link.mesh) for link in robot.links if link.mesh is not None and _has_shape(link)}
    poses = {name: configuration.pose(name) for name in hulls}
    return {name: _LinkArea(_area_of_hull(*hulls[name]), _exposed_area(name, hulls, poses)) for name in hulls}


def _exposed_area(name: str, hulls: dict[str, _Hull], poses: dict[str, Pose]) -> float:
    """Return the area of a link's hull outside the hulls of the others [m²], from points that share it equally."""
    vertices, hull = hulls[name]
    points = poses[name].points(_spread_points(vertices if hull is None else hull.points[hull.simplices]))
    buried = np.zeros(len(points), dtype=bool)
    for other, (_, around) in hulls.items():
        if other != name and around is not None:
            local = poses[other].inverse.points(points)
            near = ((local >= around.min_bound) & (local <= around.max_bound)).all(axis=1) & ~buried
            sides = local[near] @ around.equations[:, :3].T + around.equations[:, 3]
            buried[near] = (sides < 0).all(axis=1)
    return _area_of_hull(vertices, hull) * float(np.mean(~buried))


def _spread_points(corners: FloatArray) -> FloatArray:
    """Return points (n, 3) on triangles (m, 3, 3), one for each n-th part of their area along their longest axis.

    The places within the triangles follow the additive sequence of Roberts (2018), folded into the triangle. Corners
    are ordered along the axis, so that the sequence is spread evenly along it on long triangles too.
    """
    along = corners[:, :, int(np.argmax(np.ptp(corners, axis=(0, 1))))]
    corners = np.take_along_axis(corners, np.argsort(along, axis=1)[:, :, None], axis=1)
    corners = corners[np.argsort(along.mean(axis=1))]
    shares = np.arange(_SAMPLES) + 0.5
    ends = np.cumsum(_triangle_areas(corners))
    chosen = corners[np.searchsorted(ends, shares * (ends[-1] / _SAMPLES))]
    inside = (shares[:, None] * _ROBERTS) % 1.0
    beyond = inside.sum(axis=1) > 1.0
    inside[beyond] = 1.0 - inside[beyond]
    weights = np.column_stack([1.0 - inside.sum(axis=1), inside])
    return np.asarray(np.einsum("nk,nkd->nd", weights, chosen))


def hull_area(mesh: Mesh) -> float:
    """Return the area of the convex hull [m²], an estimate of the outer area of a mesh in any state."""
    return _area_of_hull(*_convex_hull(mesh))


def _area_of_hull(corners: FloatArray, hull: ConvexHull | None) -> float:
    """Return the area of a hull [m²], or of the triangles (m, 3, 3) of a flat mesh."""
    return float(_triangle_areas(corners).sum()) if hull is None else float(hull.area)


def _triangle_areas(corners: FloatArray) -> FloatArray:
    """Return the areas of triangles (m, 3, 3) [m²]."""
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(doubled, axis=1))


def _convex_hull(mesh: Mesh) -> _Hull:
    """Return the triangles (m, 3, 3) of a mesh, and its hull; None for a flat mesh."""
    try:
        return mesh.corners, ConvexHull(mesh.vertices)
    except QhullError:
        return mesh.corners, None


def _moved_links(robot: Robot, configuration: Configuration) -> set[str]:
    """Return the names of links that the joints move; the configuration is at home again afterwards."""
    if not robot.joints:
        return set()
    at_home = configuration.poses()
    configuration.update(robot.home + 0.1)
    moved = np.abs(configuration.poses() - at_home).max(axis=(1, 2)) > 1e-9
    configuration.reset()
    return {link.name for link, does in zip(robot.links, moved, strict=True) if does}
