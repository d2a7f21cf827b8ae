"""``place``: spatial calibration of taxels, by the mesh of their link or by touches at known places."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.cli.shared.residual_picture import residual_picture
from tactile_maps.cli.shared.robot_options import home_of, package_roots
from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import SkinError, UsageError, counted
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.live.calibration.touch_log import TouchLog, read_touch_log
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.alignment import Alignment, align_to_mesh, align_to_touches, touch_centres
from tactile_maps.skin.fitting.frame_match import carrying_link, match_frame
from tactile_maps.skin.fitting.rigid_body import touchable_mesh
from tactile_maps.skin.formats.icub.frames import icub_frames
from tactile_maps.skin.formats.import_skin import NO_ROBOT, TaxelFile
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet

ICUB_BOARD = 12
"""Channels of a board of iCub: rows of its positions files."""
_SHOWN = 40
"""Largest number of bars in a diagram."""


@dataclass(frozen=True, eq=False)
class _Placed:
    """A group of taxels with its displacement.

    Attributes:
        name: Name of the group.
        alignment: The displacement.
        moved: Largest displacement of a taxel [m].
        taxels: Number of taxels.
    """

    name: str
    alignment: Alignment
    moved: float
    taxels: int


def execute(arguments: argparse.Namespace) -> int:
    """Place the taxels of a file, print residuals, and write the file with the new positions."""
    file = TaxelFile(arguments.input)
    if file.kind is not FileKind.TAXELS or file.is_folder:
        remedy = "Give one taxel file: positions (.txt), a table, .npz, JSON or URDF"
        raise UsageError("this file has no stated positions of taxels", value=arguments.input, remedy=remedy)
    touched = arguments.touches is not None
    robot = None if touched and arguments.robot is None else _robot(arguments, file)
    progress = progress_line()
    sets = list(file.sets.values())
    placed: list[_Placed] = []
    result: list[TaxelSet] = []
    pictures: dict[str, bytes] = {}
    elsewhere: dict[str, None] = {}
    for number, stated in enumerate(sets):
        progress("Placing taxels", number / len(sets))
        taxels = stated if robot is None else _in_link_frame(robot, stated, arguments.link, Path(arguments.input))
        groups = _groups(taxels, arguments)
        if touched:
            log = _touch_log(arguments, taxels, robot)
            elsewhere |= dict.fromkeys(log.elsewhere)
            found = _by_touches(arguments, taxels, log)
        else:
            found = _by_mesh(robot, taxels, groups, arguments.seed)
        poses = [(rows, alignment.pose) for rows, alignment in zip(groups.values(), found, strict=True)]
        moved = _displaced(taxels, poses)
        away = np.linalg.norm(moved.positions - taxels.positions, axis=1)
        placed += [
            _Placed(name, alignment, float(away[rows].max()), len(rows))
            for (name, rows), alignment in zip(groups.items(), found, strict=True)
        ]
        result.append(moved)
        if robot is not None and arguments.report:
            name = f"Residuals on {moved.link}"
            pictures[name] = residual_picture(_mesh(robot, moved), taxels.positions, moved.positions)
    progress("", 1.0)
    if others := [link for link in elsewhere if link not in {taxels.link for taxels in result}]:
        print_warning(f"{arguments.touches}: rows on {', '.join(others)} are left out: no taxels in {arguments.input}")
    if arguments.output:
        write_taxels(result, arguments.output)
    _report(arguments, placed, pictures)
    return 0


def _robot(arguments: argparse.Namespace, file: TaxelFile) -> Robot:
    name = getattr(arguments, "robot", None) or file.usual_carrier((arguments.link,) if arguments.link else ())
    if name == NO_ROBOT:
        remedy = "Add --robot, whose mesh the taxels are placed on, or --touches"
        raise UsageError("no robot carries the taxels", value=arguments.input, remedy=remedy)
    return load_robot(name, package_roots=package_roots(arguments), home=home_of(arguments))


def _in_link_frame(robot: Robot, taxels: TaxelSet, named: str | None, path: Path) -> TaxelSet:
    """Return the taxels in the frame of the link that carries them, from the closest of the frames of the link."""
    link = carrying_link(robot, taxels.link or named, path)
    frame = match_frame(robot, link, taxels.positions, frames=icub_frames(robot, link)).pose
    return _displaced(replace(taxels, link=link), [(np.arange(len(taxels)), frame)])


def _groups(taxels: TaxelSet, arguments: argparse.Namespace) -> Mapping[str, IntArray]:
    """Return the rows of each rigid group by name.

    Raises:
        SkinError: Modules are requested that the file does not state.
    """
    name = taxels.link or taxels.name
    if arguments.by == "patch":
        return {name: np.arange(len(taxels))}
    modules = taxels.modules
    if modules is None and Path(arguments.input).suffix.lower() == ".txt":
        modules = taxels.stated_ids // ICUB_BOARD
    if modules is None:
        raise SkinError("the file states no modules", file=arguments.input, remedy="Use --by patch")
    return {f"{name}, module {module}": np.flatnonzero(modules == module) for module in np.unique(modules).tolist()}


def _mesh(robot: Robot, taxels: TaxelSet) -> Mesh:
    """Return the mesh of the link that carries the taxels."""
    assert taxels.link is not None
    return touchable_mesh(robot, taxels.link)


def _by_mesh(robot: Robot | None, taxels: TaxelSet, groups: Mapping[str, IntArray], seed: int) -> list[Alignment]:
    assert robot is not None
    mesh = _mesh(robot, taxels)
    return [
        align_to_mesh(mesh, taxels.positions[rows], None if taxels.normals is None else taxels.normals[rows], seed=seed)
        for rows in groups.values()
    ]


def _touch_log(arguments: argparse.Namespace, taxels: TaxelSet, robot: Robot | None) -> TouchLog:
    return read_touch_log(
        arguments.touches, taxels, robot=robot, readings=arguments.readings, changes=arguments.changes
    )


def _by_touches(arguments: argparse.Namespace, taxels: TaxelSet, log: TouchLog) -> list[Alignment]:
    found = []
    for name, rows in _groups(taxels, arguments).items():
        centres, there = touch_centres(taxels.positions[rows], log.changes[:, rows], noise=log.noise[rows])
        strongest = np.nan_to_num(log.changes).argmax(axis=1)
        there &= np.isin(strongest, rows)
        try:
            found.append(align_to_touches(centres[there], log.places[there], taxels.positions[rows]))
        except SkinError as error:
            raise error.at(file=arguments.touches, place=name) from error
    return found


def _displaced(taxels: TaxelSet, poses: list[tuple[IntArray, Pose]]) -> TaxelSet:
    """Return the taxels with each group of rows displaced by its pose."""
    positions = taxels.positions.copy()
    normals, tangents = (None if one is None else one.copy() for one in (taxels.normals, taxels.tangents))
    for rows, pose in poses:
        positions[rows] = pose.points(positions[rows])
        for directions in (normals, tangents):
            if directions is not None:
                directions[rows] = pose.directions(directions[rows])
    return replace(taxels, positions=positions, normals=normals, tangents=tangents, findings=())


def _report(arguments: argparse.Namespace, placed: list[_Placed], pictures: Mapping[str, bytes]) -> None:
    before = np.concatenate([one.alignment.before for one in placed])
    after = np.concatenate([one.alignment.after for one in placed])
    what = "touch" if arguments.touches else "taxel"
    for warning in _warnings(placed):
        print_warning(warning)
    target = "the places" if arguments.touches else "the mesh"
    facts = {
        "Groups": f"{len(placed)} by {arguments.by}, {counted(sum(one.taxels for one in placed), 'taxel')}",
        "Data": counted(len(after), what),
        "Stated": f"{1e3 * before.mean():.2f} mm from {target} (mean), {1e3 * before.max():.1f} mm (largest)",
        "Placed": f"{1e3 * after.mean():.2f} mm from {target} (mean), {1e3 * after.max():.1f} mm (largest)",
        "Displacement": ", ".join(_limits(placed)),
    }
    uncertain = max(one.alignment.uncertainty for one in placed)
    if np.isfinite(uncertain):
        facts["Uncertainty"] = f"{1e3 * uncertain:.2f} mm (largest standard error of a taxel)"
    rows = [_row(one) for one in placed]
    if arguments.report:
        from tactile_maps.cli.shared.pages import write_fact_page
        from tactile_maps.studies.base.figures import BarChart

        worst = sorted(placed, key=lambda one: -one.alignment.after.mean())[:_SHOWN]
        charts = [
            BarChart(f"Distance from {target}, {title}", "mean distance [mm]", amounts)
            for title, amounts in (
                ("placed", {one.name: 1e3 * float(one.alignment.after.mean()) for one in worst}),
                ("as stated", {one.name: 1e3 * float(one.alignment.before.mean()) for one in worst}),
            )
        ]
        title = f"Places of the taxels of {arguments.input}"
        write_fact_page(arguments.report, title, facts, tables={"Groups": rows}, charts=charts, pictures=pictures)
    figures = {"before_mm": 1e3 * float(before.mean()), "after_mm": 1e3 * float(after.mean())}
    result = {**figures, "groups": rows, "file": arguments.output}
    print_result(result, {**facts, "Written to": arguments.output}, as_json=arguments.json)


def _limits(placed: list[_Placed]) -> Iterator[str]:
    yield f"up to {1e3 * max(one.moved for one in placed):.1f} mm"
    yield f"up to {np.degrees(max(one.alignment.angle for one in placed)):.1f} degrees"


def _row(one: _Placed) -> dict[str, Any]:
    alignment = one.alignment
    turn = alignment.pose.rotation
    return {
        "group": one.name,
        "taxels": one.taxels,
        "stated_mm": 1e3 * float(alignment.before.mean()),
        "placed_mm": 1e3 * float(alignment.after.mean()),
        "largest_mm": 1e3 * float(alignment.after.max()),
        "moved_mm": 1e3 * one.moved,
        "turned_deg": float(np.degrees(alignment.angle)),
        "undetermined": alignment.free,
        "uncertainty_mm": 1e3 * alignment.uncertainty,
        "matrix": " ".join(f"{value:.6g}" for value in np.column_stack([turn, alignment.pose.translation]).ravel()),
    }


def _warnings(placed: list[_Placed]) -> Iterator[str]:
    free = [one for one in placed if one.alignment.free]
    if free:
        most = max(one.alignment.free for one in free)
        yield (
            f"{len(free)} of {len(placed)} groups: the mesh does not determine up to {most} of 6 directions, such as "
            "sliding; they remain as stated. Touches at known places determine them (--touches)"
        )
