"""Taxel grids: e-skins of rows and columns.

Two opposite corners on the link define the position and direction of a grid; its rows and columns follow the cover
straight from there (``surface_grid``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, MeshError, SkinError, check_range
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface_grid import SurfaceGrid, surface_grid
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import CLOSING_FACTOR
from tactile_maps.skin.fitting.cover_patches import StatedProperties, patches_at
from tactile_maps.skin.fitting.frame_match import MAX_MEDIAN_DISTANCE
from tactile_maps.skin.fitting.rigid_body import link_mesh
from tactile_maps.skin.model.skin import (
    LOW_COVERAGE,
    Patch,
    Skin,
    TaxelIdentity,
    low_coverage,
    number_ranges,
    patch_name,
)
from tactile_maps.skin.model.taxel_axes import check_number_of_axes

MAX_GRID_SIDE = 256
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
            check_range(f"the number of {name}", number, 1, MAX_GRID_SIDE, error=SkinError, place=name)
        if self.rows * self.columns < 2:
            raise SkinError("a grid has at least two taxels", place="rows", value=1, remedy="Choose more rows")
        check_range("the aspect", self.aspect, 0.1, 10, error=SkinError, place="aspect")
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
    mesh, findings = link_mesh(robot, spec.link)
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
    patches, missing = patches_at(
        surface,
        points,
        StatedProperties(TaxelIdentity(ids=ids), np.full(len(ids), spec.axes)),
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


def _overlaps(patch: Patch, made: Skin, within: float) -> bool:
    """Return whether taxels of the skin are above or below the patch."""
    _, weights, away = ClosestPoint(patch.surface).query(made.positions)
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
