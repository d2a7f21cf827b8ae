"""Skin on a robot link from measured taxel positions, or from a grid between two corners.

The mesh of the link is wrapped as for a cover, and each taxel moves to the closest point of the wrap. Links without a
joint between them are one body: a taxel that is clearly closer to another of them moves onto that one. Only the surface
that can be touched counts: no taxel moves onto a core inside its pad. Positions may be stated in the frame of the link
or of a link fixed to it; the frame in which they are closer to the meshes is used. Taxels far from the body belong to
another link or frame, and are rejected. Where a mesh of the body is missing, taxels that are far from the other shapes,
or closer to the placeholder of the missing mesh, stay at their stated positions and are joined to each other: no taxel
moves onto a placeholder.

A grid is an e-skin of rows and columns. Two opposite corners on the link define its position and direction; its rows
and columns follow the cover straight from there (``surface_grid``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, MeshError, SkinError, add_finding
from tactile_maps.geometry.geodesics import distances_from
from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.geometry.surface_grid import SurfaceGrid, surface_grid
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import CLOSING_FACTOR, placeholder_notes
from tactile_maps.skin.model.skin import (
    LOW_COVERAGE,
    Patch,
    Skin,
    TaxelIdentity,
    Taxels,
    low_coverage,
    merge_skins,
    number_ranges,
    patch_name,
)
from tactile_maps.skin.model.taxel_axes import check_number_of_axes, tangents_on
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.model.touchable_surface import touchable_surfaces
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels
from tactile_maps.skin.taxel_placement.sampling import (
    distinct_faces,
    face_graph,
    geodesic_voronoi,
    straighten_cells,
    taxels_at_points,
)
from tactile_maps.skin.taxel_placement.usable_surface import usable_components, vertices_clear_of

MAX_MEDIAN_DISTANCE = 0.020
"""Median distance of taxels from their link [m], above which they belong to another link or frame."""
PATCH_MARGIN = 1.5
"""Width of a patch beyond its taxels, in pitches."""
CELL_RADIUS = 1.0
"""Largest radius of the cell of a taxel, in pitches."""
SAME_SURFACE = 1e-3
"""A taxel moves to another link fixed to its own if that one is closer by more than this [m] and by more than half. It
moves to any closer one where its own link is hidden inside others."""
_ABOVE_HIDDEN = 1e-4
"""A place is above a hidden face if the touchable surface is farther away than the mesh by more than this [m]."""
_ON_MESH = 5e-5
"""Distance [m] below which a stated taxel is on the mesh."""
_LARGEST_HOLE = 8.0  # in pitches²
_DH_FRAME_SUFFIX = "_dh_frame"
_MIN_PITCH = 5e-4
"""Smallest pitch of a grid [m]; it sets the resolution of the cover."""
_FLAT = float(np.cos(np.radians(45)))
_AROUND = float(np.cos(np.radians(80)))
"""Cosines of the angles between the normals of a grid and that at its middle: all below 45 degrees if it is flat, some
above 80 if it goes around an edge of the link."""
_CORNER_OFF = 1e-3
"""Distance of a corner of a grid from the cover [m] above which it is reported as moved."""
_GRID_NAME = " grid"
_UNEVEN = 0.2
"""Relative deviation of a spacing from the pitch above which it is reported."""


def place_taxels(
    robot: Robot,
    link: str,
    taxels: TaxelSet,
    *,
    thickness: float = 0.003,
    file: str | Path,
    frames: Mapping[str, Pose] | None = None,
) -> Skin:
    """Return the skin of ``taxels`` on the covers of ``link`` and of links fixed to it, closest to their positions.

    Where a mesh of the link, or of a link fixed to it, is missing, taxels stay at their stated positions if they are
    more than 20 mm from the other shapes or closer to the placeholder of the missing mesh. The findings of the set come
    first.

    Args:
        robot: The robot.
        link: Name of the link that the taxels are stated for.
        taxels: Taxels with positions in the frame of the link, or of a link ``<link>_dh_frame`` fixed to it, whichever
            is closer to the meshes.
        thickness: Thickness of the cover over the meshes [m].
        file: Source of the taxels, for errors.
        frames: Other frames fixed to the link in which the positions may be stated, by name: ``T_link_frame``.

    Raises:
        RobotError: The robot does not have the link.
        SkinError: Neither the link nor any link fixed to it has geometry, or half of the taxels are more than 20 mm
            from them.

    Cost: about 0.5 s for 400 taxels; up to 1 s more where links fixed to this one reach into it.
    """
    parts, placeholders = _rigid_parts(robot, link)
    match = _stated_match(robot, link, parts, placeholders, taxels.positions, frames or {})
    local = match.pose.points(taxels.positions)
    stays = np.zeros(len(taxels), dtype=bool)
    if placeholders:
        closest = _distances(placeholders, local).min(axis=0)
        stays = (match.away > MAX_MEDIAN_DISTANCE) | (match.away > closest)
    skins = [Skin((), taxels.findings)]
    stated = _Stated(taxels.identity, taxels.axes, taxels.tangents).rotated(match.pose)
    if not stays.all():
        on = match.select(~stays)
        own = stated.select(np.flatnonzero(~stays))
        skins.append(_skin_on_covers(link, parts, on, local[~stays], own, thickness, file))
    if stays.any():
        normals = None if taxels.normals is None else match.pose.directions(taxels.normals)
        here = replace(taxels, name=link, link=link, positions=local, normals=normals, tangents=stated.tangents)
        here = here.select(stays)
        action = (
            "kept at their stated places, joined to each other: a mesh of the link or of one fixed to it is missing"
        )
        note = Finding("stated-places", link, action, int(stays.sum()))
        skins += [skin_from_taxels(replace(here, findings=())), Skin((), (note,))]
    return merge_skins(skins)


@dataclass(frozen=True, eq=False)
class _Stated(ArrayFields):
    """Stated properties of taxels that their positions on a cover do not replace.

    Attributes:
        identity: Identity of the taxels.
        axes: (n,) number of axes, or None.
        tangents: (n, 3) first tangents in the frame of the link, or None.
    """

    identity: TaxelIdentity
    axes: IntArray | None = None
    tangents: FloatArray | None = None

    def rotated(self, pose: Pose) -> _Stated:
        return self if self.tangents is None else replace(self, tangents=pose.directions(self.tangents))

    def select(self, rows: IntArray) -> _Stated:
        axes = None if self.axes is None else self.axes[rows]
        tangents = None if self.tangents is None else self.tangents[rows]
        return _Stated(self.identity.select(rows), axes, tangents)

    def on(self, taxels: Taxels) -> Taxels:
        """Return ``taxels`` of a cover with these properties; tangents are projected onto the cover."""
        tangents = tangents_on(self.tangents, taxels.normals)
        return replace(taxels, identity=self.identity, axes=self.axes, tangents=tangents)


def _stated_match(
    robot: Robot,
    link: str,
    parts: Sequence[_Part],
    placeholders: Sequence[_Part],
    positions: FloatArray,
    frames: Mapping[str, Pose],
) -> FrameMatch:
    """Return the frame of stated taxels: the link's own if a mesh is missing and no frame is close to the others."""
    own = {link: Pose.identity()}
    if not parts and not placeholders:
        raise _no_geometry(robot, link)
    if not parts:
        return FrameMatch(link, own[link], np.zeros(len(positions), dtype=np.int64), np.full(len(positions), np.inf))
    match = _closest_frame(link, parts, positions, {**_candidate_frames(robot, link), **frames})
    far = match.median > MAX_MEDIAN_DISTANCE
    return _closest_frame(link, parts, positions, own) if placeholders and far else match


def _no_geometry(robot: Robot, link: str) -> SkinError:
    return SkinError("the link has no geometry for a skin", file=robot.source, value=link)


def _skin_on_covers(
    link: str,
    parts: Sequence[_Part],
    match: FrameMatch,
    local: FloatArray,
    stated: _Stated,
    thickness: float,
    file: str | Path,
) -> Skin:
    """Return the skin of the places ``local`` (n, 3) [m], in the frame of ``link``, on covers of the parts."""
    notes = _match_notes(match, link, len(local), file)
    pitch = _pitch(local, parts[0].mesh)
    patches = list[Patch]()
    for number, part in enumerate(parts):
        own = np.flatnonzero(match.part == number)
        if not len(own):
            continue
        if part.link != link:
            notes.append(Finding("rigid-link", link, f"on {part.link}, a link fixed to it", len(own)))
        cover = wrap_mesh(
            part.mesh, thickness=thickness, voxel=pitch / 2, closing=CLOSING_FACTOR * thickness, where=part.link
        )
        places = part.pose.inverse.points(local[own])
        here = stated.select(own).rotated(part.pose.inverse)
        touchable = _touchable_vertices(cover.surface, part, parts)
        found, missing = _patches_at(cover.surface, places, here, pitch, part.link, touchable)
        patches += found
        notes += (*part.findings, *missing, *cover.findings)
    if not patches:
        raise SkinError("no patch could be made around the taxels", file=file, place=link)
    return Skin(tuple(patches), tuple(notes))


@dataclass(frozen=True, eq=False)
class _Part:
    """A link with geometry in the rigid body that carries taxels.

    Attributes:
        link: Name of the link.
        mesh: Cleaned mesh [m], in the frame of the link.
        pose: Pose of its frame in the frame of the link to which the taxels belong.
        findings: Repairs of the mesh.
        touchable: The part of the mesh that can be touched: the mesh itself where nothing is hidden by other parts,
            None where everything is.
    """

    link: str
    mesh: Mesh
    pose: Pose
    findings: tuple[Finding, ...]
    touchable: Mesh | None

    @cached_property
    def closest(self) -> ClosestPoint | None:
        """Index for distances to the surface that can be touched."""
        return None if self.touchable is None else ClosestPoint(self.touchable)


def _rigid_parts(robot: Robot, link: str) -> tuple[list[_Part], list[_Part]]:
    """Return the links with geometry of their own that no joint separates from ``link``, itself first, and the
    placeholders of meshes that are missing on such links.
    """
    configuration = Configuration(robot)
    parts = list[_Part]()
    placeholders = list[_Part]()
    here = configuration.pose(link).inverse
    for name in configuration.rigid_links(link):
        other = robot.link(name)
        pose = Pose.identity() if name == link else here @ configuration.pose(name)
        placeholders += [_Part(name, box, pose, (), box) for box in other.left_out]
        if other.mesh is not None and len(other.mesh.faces):
            if other.missing:
                placeholders.append(_Part(name, other.mesh, pose, (), other.mesh))
            else:
                cleaned, findings = clean_mesh(other.mesh, where=name)
                parts.append(_Part(name, cleaned, pose, findings, cleaned))
    meshes = [Mesh(part.pose.points(part.mesh.vertices), part.mesh.faces) for part in parts]
    surfaces = touchable_surfaces(meshes)
    for number, (part, mesh, surface) in enumerate(zip(parts, meshes, surfaces, strict=True)):
        if surface is not mesh:
            own = surface and Mesh(part.pose.inverse.points(surface.vertices), surface.faces)
            parts[number] = replace(part, touchable=own)
    return parts, placeholders


def _touchable_vertices(surface: Mesh, part: _Part, parts: Sequence[_Part]) -> BoolArray:
    """Return (n,) for each vertex of the cover ``surface`` of a part whether it is above what can be touched of it."""
    if part.touchable is part.mesh:
        return np.ones(len(surface.vertices), dtype=bool)
    others = [(part.pose.inverse @ other.pose, other.mesh) for other in parts if other is not part]
    return ~_above_hidden(part, surface.vertices) & vertices_clear_of(surface, others, distance=0.0)


def _above_hidden(part: _Part, places: FloatArray) -> BoolArray:
    """Return (n,) for each place (n, 3) [m], in the part's frame, whether the closest face of the part is hidden."""
    if part.touchable is part.mesh:
        return np.zeros(len(places), dtype=bool)
    if part.closest is None:
        return np.ones(len(places), dtype=bool)
    return np.asarray(part.closest.query(places)[2] - ClosestPoint(part.mesh).query(places)[2] > _ABOVE_HIDDEN)


def _distances(parts: Sequence[_Part], places: FloatArray) -> FloatArray:
    """Return (parts, n) the distances [m] of places (n, 3) in the frame of the link to each of the parts; infinite to a
    part that cannot be touched.
    """
    distances = np.full((len(parts), len(places)), np.inf)
    for number, part in enumerate(parts):
        if part.closest is not None:
            distances[number] = part.closest.query(part.pose.inverse.points(places))[2]
    return distances


def _patches_at(
    surface: Mesh,
    positions: FloatArray,
    stated: _Stated,
    pitch: float,
    link: str,
    touchable: BoolArray | None = None,
) -> tuple[tuple[Patch, ...], list[Finding]]:
    """Return patches of a cover around its places closest to ``positions`` (n, 3), and findings of taxels without one.

    ``touchable`` (vertices,) limits them to a part of the cover.
    """
    patches = tuple[Patch, ...]()
    allowed = np.ones(len(surface.vertices), dtype=bool) if touchable is None else touchable
    open_faces = np.flatnonzero(allowed[surface.faces].all(axis=1))
    if len(open_faces):
        closest = ClosestPoint(Mesh(surface.vertices, surface.faces[open_faces]))
        faces, weights, _ = closest.query(positions)
        points = surface.points(open_faces[faces], weights)
        usable = allowed & _vertices_within(surface, open_faces[faces], PATCH_MARGIN * pitch)
        pieces = usable_components(surface, usable, smallest=0.0, largest_hole=_LARGEST_HOLE * pitch**2)
        patches = _patches(pieces, points, stated, pitch, link)
    missing = len(positions) - sum(len(patch.taxels) for patch in patches)
    notes = list[Finding]()
    add_finding(notes, "taxel-off-patch", link, "left out: no patch could be made around it", missing)
    return patches, notes


MAX_GRID_SIDE = 256
Corner = tuple[float, float, float]


@dataclass(frozen=True)
class GridSpec:
    """Specification of a grid of taxels on a link.

    Attributes:
        link: Name of the link.
        rows: Number of rows, 1 to 256.
        columns: Number of columns, 1 to 256; the grid has at least two taxels.
        first: Position of the taxel in row 0, column 0 [m], link frame; it moves to the closest point of the cover.
        last: Position of the taxel in the last row and column [m], link frame.
        aspect: Distance between columns over the distance between rows.
        mirrored: Two grids have these corners. False: seen from outside, columns go to the right of the first corner
            and rows upward, in a frame in which the last corner is at its position. True: rows go downward. None: the
            first, unless it goes around an edge of the link and the second is flat.
        axes: Number of axes of each taxel: 1 (pressure) or 3 (pressure and shear).

    Raises:
        SkinError: A number is out of range.
    """

    link: str
    rows: int
    columns: int
    first: Corner
    last: Corner
    aspect: float = 1.0
    mirrored: bool | None = None
    axes: int = 1

    def __post_init__(self) -> None:
        check_number_of_axes(self.axes)
        for name, number in (("rows", self.rows), ("columns", self.columns)):
            if not 1 <= number <= MAX_GRID_SIDE:
                remedy = f"Choose 1 to {MAX_GRID_SIDE}"
                raise SkinError(f"the number of {name} is out of range", place=name, value=number, remedy=remedy)
        if self.rows * self.columns < 2:
            raise SkinError("a grid has at least two taxels", place="rows", value=1, remedy="Choose more rows")
        if not 0.1 <= self.aspect <= 10:
            raise SkinError("the aspect is out of range", place="aspect", value=self.aspect, remedy="Choose 0.1 to 10")
        for place, corner in (("first", self.first), ("last", self.last)):
            if len(corner) != 3 or not np.isfinite(corner).all():
                raise SkinError("a corner is three finite numbers", place=place, value=corner)


def grid_skin(robot: Robot, spec: GridSpec, *, thickness: float = 0.003) -> Skin:
    """Return the skin with one grid on the cover of its link; ids of taxels count along the rows.

    Taxels beyond an edge of the link, seen from the middle of the grid, are left out. Findings report the pitch, the
    taxels that are left out, and spacings that differ from the pitch because the link is curved.

    Args:
        robot: The robot.
        spec: The specification.
        thickness: Thickness of the cover over the mesh of the link [m].

    Raises:
        RobotError: The robot does not have the link.
        SkinError: The link has no geometry, or no grid between the corners is found.

    Cost: about 0.5 s for 16 x 16 taxels.
    """
    mesh, findings = _link_mesh(robot, spec.link)
    sides = np.hypot((spec.columns - 1) * spec.aspect, spec.rows - 1)
    pitch = float(np.linalg.norm(np.subtract(spec.last, spec.first)) / sides)
    if pitch < _MIN_PITCH:
        remedy = f"Choose corners farther apart, or fewer rows and columns: the least pitch is {1e3 * _MIN_PITCH:g} mm"
        value = f"taxels {1e3 * pitch:.2g} mm apart"
        raise SkinError(
            "the corners are too close for so many taxels", place=f"grid on {spec.link}", value=value, remedy=remedy
        )
    moved = _corner_notes(robot, mesh, spec, float(sides), thickness)
    wrapped = wrap_mesh(mesh, thickness=thickness, voxel=pitch / 2, closing=CLOSING_FACTOR * thickness, where=spec.link)
    surface = wrapped.surface
    try:
        grid, chosen = _flatter_grid(surface, spec)
    except MeshError as error:
        raise error.at(kind=SkinError, file=robot.source, place=f"grid on {spec.link}") from error
    ids = np.arange(spec.rows * spec.columns)[grid.on.ravel()]
    points = grid.points.reshape(-1, 3)[ids]
    patches, missing = _patches_at(
        surface,
        points,
        _Stated(TaxelIdentity(ids=ids), np.full(len(ids), spec.axes)),
        float(grid.pitch.min()),
        spec.link,
    )
    if not patches:
        raise SkinError("no patch could be made around the grid", file=robot.source, place=spec.link)
    left_out = spec.rows * spec.columns - sum(len(patch.taxels) for patch in patches)
    skin = Skin(patches, bare_area=left_out * float(grid.pitch.prod()))
    if skin.coverage < LOW_COVERAGE:
        remedy = "choose corners closer together, or another place on the link"
        reasons = f"{left_out} of {spec.rows * spec.columns} taxels are beyond an edge of the link"
        missing.append(low_coverage(f"{spec.link} grid", skin.coverage, reasons, remedy, left_out))
    return replace(skin, findings=(*findings, *moved, *chosen, *_grid_notes(grid, spec), *missing, *wrapped.findings))


def _corner_notes(robot: Robot, mesh: Mesh, spec: GridSpec, sides: float, thickness: float) -> list[Finding]:
    """Report the corners that are not on the link.

    Raises:
        SkinError: A corner is more than 20 mm, and more than one pitch, from the link's mesh.
    """
    corners = np.array([spec.first, spec.last])
    closest = ClosestPoint(mesh)
    faces, weights, away = closest.query(corners)
    points = mesh.points(faces, weights)
    most = max(MAX_MEDIAN_DISTANCE, float(np.linalg.norm(points[1] - points[0])) / sides)
    for name, corner, distance in zip(("first", "last"), corners, away, strict=True):
        if distance > most:
            stated = ", ".join(f"{1e3 * number:g}" for number in corner)
            raise SkinError(
                f"the {name} corner of a grid is far from the link's surface",
                file=robot.source,
                place=f"grid on {spec.link}",
                value=f"{1e3 * distance:.0f} mm from it, at {stated} mm",
                remedy=f"State the corners in the frame of the link {spec.link}, at most {1e3 * most:.0f} mm from its "
                "surface; the command line takes mm, scenes and Python metres",
            )
    off = int((away > thickness + _CORNER_OFF).sum())
    action = f"moved onto the cover from up to {1e3 * away.max():.1f} mm off the link's surface"
    return [Finding("grid-corner", f"{spec.link} grid", action, off)] if off else []


def _flatter_grid(surface: Mesh, spec: GridSpec) -> tuple[SurfaceGrid, list[Finding]]:
    """Return the specified grid, or its mirror image if ``spec`` allows it, and a finding if only the other is flat.

    Raises:
        MeshError: Neither is found.
    """
    first = np.array(spec.first)
    last = np.array(spec.last)

    def grid(mirrored: bool) -> SurfaceGrid:
        return surface_grid(surface, first, last, spec.rows, spec.columns, aspect=spec.aspect, mirrored=mirrored)

    requested = bool(spec.mirrored)
    result = grid(requested)
    bent = ~result.on | (_slopes(surface, result) < _AROUND)
    if not bent.any():
        return result, []
    try:
        other = grid(not requested)
    except MeshError:
        return result, []
    if not other.on.all() or _slopes(surface, other).min() < _FLAT:
        return result, []
    where = f"{spec.link} grid"
    count = int(bent.sum())
    if spec.mirrored is None:
        action = "mirrored, which is flat; not mirrored, this number of taxels are around or beyond an edge of the link"
        return other, [Finding("grid-mirrored", where, action, count)]
    remedy = "not mirrored" if spec.mirrored else "mirrored"
    return result, [Finding("grid-around-edge", where, f"kept as stated; {remedy} it is flat", count)]


def _slopes(surface: Mesh, grid: SurfaceGrid) -> FloatArray:
    """Return (rows, columns) cosine of the angle between the normal at each taxel and that at the middle."""
    normals = surface.face_normals[grid.faces]
    rows, columns = grid.on.shape
    return np.asarray(normals @ normals[(rows - 1) // 2, (columns - 1) // 2])


def add_grids(robot: Robot, skin: Skin | None, specs: Sequence[GridSpec], *, thickness: float = 0.003) -> Skin:
    """Return ``skin`` with grids added; patches under a grid are left out, with a finding.

    Raises:
        RobotError: See ``grid_skin``.
        SkinError: See ``grid_skin``.
    """
    if skin is not None and not specs:
        return skin
    skin = skin or Skin(())
    patches = list(skin.patches)
    findings = list(skin.findings)
    bare_area = skin.bare_area
    for spec in specs:
        made = grid_skin(robot, spec, thickness=thickness)
        under = [patch for patch in patches if patch.link == spec.link and _overlaps(patch, made, 2 * thickness)]
        action = "left out: a grid is on it"
        findings += [Finding("patch-under-grid", patch.name, action, len(patch.taxels)) for patch in under]
        patches = [patch for patch in patches if patch not in under]
        findings += made.findings
        bare_area += made.bare_area
        for patch in made.patches:
            names = {other.name for other in patches}
            name = next(name for k in count() if (name := patch_name(spec.link + _GRID_NAME, k)) not in names)
            patches.append(replace(patch, name=name))
    return Skin(tuple(patches), tuple(findings), bare_area)


def is_grid_patch(patch: Patch) -> bool:
    """Return whether ``add_grids`` made the patch, from its name."""
    return patch.name.startswith(patch.link + _GRID_NAME)


def _overlaps(patch: Patch, made: Skin, within: float) -> bool:
    """Return whether taxels of the skin are above or below the patch."""
    positions = np.concatenate([own.taxels.positions for own in made.patches])
    _, weights, away = ClosestPoint(patch.surface).query(positions)
    inside = (weights > 1e-6).all(axis=1)  # next to the patch, the closest point is on its border
    return bool(((away < within) & inside).any())


def _grid_notes(grid: SurfaceGrid, spec: GridSpec) -> list[Finding]:
    """Return findings of the pitch, of taxels beyond an edge, and of spacings that differ from the pitch."""
    rows, columns = 1e3 * grid.pitch
    pitch = f"{rows:.2f} mm" if spec.aspect == 1 else f"rows {rows:.2f} mm, columns {columns:.2f} mm"
    where = f"{spec.link} grid"
    notes = [Finding("grid-pitch", where, f"{spec.rows} x {spec.columns} taxels, {pitch} apart", grid.on.size)]
    off = np.argwhere(~grid.on)
    if len(off):
        names = f"rows {number_ranges(off[:, 0])} of columns {number_ranges(off[:, 1])}"
        action = f"left out: beyond an edge of the link, in {names}"
        notes.append(Finding("taxel-off-surface", where, action, len(off)))
    gaps = [
        np.linalg.norm(np.diff(grid.points, axis=k), axis=2)[np.delete(grid.on, 0, k) & np.delete(grid.on, -1, k)]
        / grid.pitch[k]
        for k in range(2)
    ]
    ratio = np.concatenate(gaps)
    bent = int((np.abs(ratio - 1) > _UNEVEN).sum())
    if bent:
        action = (
            f"kept: the link is curved, spacings are {100 * ratio.min():.0f} to {100 * ratio.max():.0f} % of the pitch"
        )
        notes.append(Finding("uneven-spacing", where, action, bent))
    return notes


def carrying_link(robot: Robot, named: str | None, path: Path) -> str:
    """Return the link of the robot that a file calls ``named``.

    ``upper_arm`` in the file ``left_arm.txt`` is ``l_upper_arm`` on the robot.

    Raises:
        SkinError: The file does not name a link, or the robot does not have it.
    """
    links = ", ".join(robot.link_index)
    if named is None:
        remedy = f"Choose the link that carries these taxels, one of: {links}"
        raise SkinError("the file does not name its link", file=path, remedy=remedy)
    side = {"left": "l_", "right": "r_"}.get(path.name.partition("_")[0], "")
    for name in (named, side + named):
        if name in robot.link_index:
            return name
    raise SkinError(
        "the robot has no link of the file's name", file=path, value=named, remedy=f"Choose one of: {links}"
    )


def _link_mesh(robot: Robot, link: str) -> tuple[Mesh, tuple[Finding, ...]]:
    mesh = robot.link(link).mesh
    if mesh is None or not len(mesh.faces):
        raise _no_geometry(robot, link)
    cleaned, findings = clean_mesh(mesh, where=link)
    return cleaned, (*placeholder_notes(robot, (link,)), *findings)


def _candidate_frames(robot: Robot, link: str) -> dict[str, Pose]:
    """Return the frames of the robot in which positions may be stated, by name: ``T_link_frame``, fixed to the link."""
    configuration = Configuration(robot)
    other = link + _DH_FRAME_SUFFIX
    frames = {link: Pose.identity()}
    if other in configuration.rigid_links(link):
        frames[other] = configuration.pose(link).inverse @ configuration.pose(other)
    return frames


@dataclass(frozen=True, eq=False)
class FrameMatch(ArrayFields):
    """The frame in which taxels are closest to the meshes of their link and of links fixed to it.

    Attributes:
        name: Name of the frame.
        pose: ``T_link_frame``.
        part: (n,) number of the part that each taxel is closest to; the link itself has the number 0.
        away: (n,) distance of each taxel to that part [m].
    """

    name: str
    pose: Pose
    part: IntArray
    away: FloatArray

    @property
    def median(self) -> float:
        """Median distance [m]."""
        return float(np.median(self.away))

    def select(self, which: BoolArray) -> FrameMatch:
        """Return the match of the taxels where ``which`` (n,) is true."""
        return replace(self, part=self.part[which], away=self.away[which])


def match_frame(
    robot: Robot, link: str, positions: FloatArray, *, frames: Mapping[str, Pose] | None = None
) -> FrameMatch:
    """Return the frame in which ``positions`` (n, 3) [m] are closest to ``link`` and the links fixed to it.

    Arguments and errors are those of ``place_taxels``. Where all meshes are missing, the distances are infinite.

    Cost: 0.1 s for 400 taxels; up to 1 s more where links fixed to this one reach into it.
    """
    return _stated_match(robot, link, *_rigid_parts(robot, link), positions, frames or {})


def touchable_mesh(robot: Robot, link: str) -> Mesh:
    """Return the surface of a link, and of links fixed to it, that can be touched, in the frame of the link.

    Raises:
        RobotError: The robot does not have the link.
        SkinError: Neither the link nor any link fixed to it has geometry, or nothing of it can be touched.
    """
    parts, _ = _rigid_parts(robot, link)
    surfaces = [(part.pose, part.touchable) for part in parts if part.touchable is not None]
    if not surfaces:
        raise _no_geometry(robot, link)
    return join_meshes([Mesh(pose.points(mesh.vertices), mesh.faces) for pose, mesh in surfaces])


def _closest_frame(link: str, parts: Sequence[_Part], positions: FloatArray, frames: Mapping[str, Pose]) -> FrameMatch:
    matches = []
    for name, pose in frames.items():
        distances = _distances(parts, pose.points(positions))
        part = distances.argmin(axis=0)
        least = distances.min(axis=0)
        if parts[0].link == link:
            own = distances[0] <= np.maximum(least + SAME_SURFACE, 2 * least)
            part[own & ~_above_hidden(parts[0], pose.points(positions))] = 0
        away = distances[part, np.arange(len(positions))]
        matches.append(FrameMatch(name, pose, part, away))
    return min(matches, key=lambda match: match.median)


def _match_notes(match: FrameMatch, link: str, count: int, file: str | Path) -> list[Finding]:
    """Return findings of the distance of the taxels from the link, and of their frame.

    Raises:
        SkinError: The taxels are far from the link.
    """
    if match.median > MAX_MEDIAN_DISTANCE:
        raise SkinError(
            f"half of the taxels are more than {1e3 * MAX_MEDIAN_DISTANCE:.0f} mm from the link {link}",
            file=file,
            value=f"median {1e3 * match.median:.1f} mm",
            remedy="Choose another link, or state the positions in the link's frame",
        )
    most = float(match.away.max())
    stated = f"{1e3 * match.median:.1f} mm (median) and {1e3 * most:.1f} mm (largest) off the link's mesh"
    action = (
        f"moved onto the cover from {stated}" if most >= _ON_MESH else "stated on the link's mesh, kept on its cover"
    )
    notes = [Finding("taxel-distance", link, action, count)]
    if match.name != link:
        notes.append(Finding("taxel-frame", link, f"the positions are stated in the frame {match.name}"))
    return notes


def _pitch(positions: FloatArray, mesh: Mesh) -> float:
    """Return the median distance to the nearest other taxel [m]; for a single taxel, 1/20 of the size of the link."""
    distances = nearest_others(positions, 1)[0]
    return float(np.median(distances)) if distances.size else mesh.size / 20


def _vertices_within(surface: Mesh, seeds: IntArray, reach: float) -> BoolArray:
    """Return (vertices,) whether each is a corner of a face within ``reach`` [m] of a seed face along the surface."""
    near = np.isfinite(distances_from(face_graph(surface), np.unique(seeds), limit=reach))
    usable = np.zeros(len(surface.vertices), dtype=bool)
    usable[surface.faces[near]] = True
    return usable


def _patches(pieces: list[Mesh], points: FloatArray, stated: _Stated, pitch: float, link: str) -> tuple[Patch, ...]:
    """Return a patch for each piece with taxels; each taxel is on the nearest piece."""
    away = np.array([ClosestPoint(piece).query(points)[2] for piece in pieces]).reshape(len(pieces), len(points))
    patches: list[Patch] = []
    for i, piece in enumerate(pieces):
        own = np.flatnonzero((away.argmin(axis=0) == i) & (away[i] <= pitch))
        if len(own):
            taxels = stated.select(own).on(_taxels(piece, points[own], pitch))
            patches.append(Patch(patch_name(link, len(patches)), link, piece, taxels))
    return tuple(patches)


def _taxels(piece: Mesh, points: FloatArray, pitch: float) -> Taxels:
    seeds = distinct_faces(piece.face_centres, points)
    owner = geodesic_voronoi(face_graph(piece), seeds, reach=CELL_RADIUS * pitch)
    return taxels_at_points(piece, points, straighten_cells(piece, points, owner, seeds))
