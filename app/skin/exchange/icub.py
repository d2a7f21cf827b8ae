"""iCub skin positions files: read with every known defect counted, and worn by a link of a robot.

The format is that of iCubSkinGui (robotology/icub-main, app/skinGui/conf/positions): a few named values, then one row
``x y z [nx ny nz]`` a taxel, metres, link frame. Twelve rows make a triangular module; ``taxel2Repr`` says for each
taxel which one represents its module, -1 where nothing is fitted and -2 where the pad measures temperature. An older
form has rows only. All rows are read here; the original reader loses the last one, so a row of zeros is written after.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.errors import Finding, SkinError
from app.robots.robot import Robot
from app.skin.exchange.foreign_file import naming, note, write_lines
from app.skin.exchange.taxel_set import TaxelSet, unit_normals
from app.skin.exchange.text_rows import MAX_ROWS, Rows, read_rows
from app.skin.skin import Skin
from app.skin.wear import wear

MODULE = 12
THERMAL_PADS = (6, 10)
THERMAL, UNFITTED, FITTED, UNKNOWN = -2, -1, 0, 1
"""What is known of a row; the first two as the list writes them."""
REPRESENTATIVE = 3
"""The pad in the middle of its module."""
SAME_PLACE = 1e-5
"""Taxels closer than this [m] are one: the files state tenths of a millimetre."""
_FLAT = 1e-3
"""Taxels with one normal for all may be this far [m] from one plane; farther, and the normal is a dummy."""


def read_icub_positions(path: str | Path) -> TaxelSet:
    """The usable taxels in the positions file at ``path``; a taxel's number is its row.

    Raises:
        SkinError: It cannot be read, or a line is not what the format allows; names the line and the value.
    """
    path = Path(path)
    rows = read_rows(path)
    findings: list[Finding] = []
    usable = _fitted(rows, path, findings)
    number = np.flatnonzero(usable)
    number = number[_distinct(rows.values[number, :3], path, findings)]
    if not len(number):
        raise SkinError(
            "the file has no usable taxel",
            file=path,
            value=f"{len(rows.values)} rows",
            remedy="Choose a positions file with rows that are not all zero",
        )
    positions = rows.values[number, :3]
    normals = _normals(positions, rows.values[number, 3:], path, findings)
    with naming(path):
        return TaxelSet(
            path.stem, rows.name, number, positions, normals, modules=number // MODULE, findings=tuple(findings)
        )


def write_icub_positions(taxels: TaxelSet, path: str | Path) -> None:
    """Write ``taxels`` as a positions file: the row is the number, and what lies between is zero and not fitted.

    Raises:
        SkinError: A number beyond what the format can hold, a taxel that its rows cannot tell from an unused one, or
            the file cannot be written.
    """
    path = Path(path)
    if taxels.numbers.max() >= MAX_ROWS:
        raise SkinError(
            "a taxel's number is its row in this format",
            file=path,
            value=int(taxels.numbers.max()),
            remedy="Renumber the taxels, or write .csv",
        )
    count = MODULE * (int(taxels.numbers.max()) // MODULE + 1)
    rows = np.zeros((count, 6))
    rows[taxels.numbers, :3] = taxels.positions
    if taxels.normals is not None:
        rows[taxels.numbers, 3:] = taxels.normals
    if not rows[taxels.numbers].any(axis=1).all():
        raise SkinError("a taxel at the origin without a normal would read as unused", file=path)
    lines = [f"name {' '.join((taxels.link or '').split())}".rstrip(), "spatial_sampling taxel"]
    lines += [f"taxel2Repr ( {' '.join(map(str, _representatives(taxels.numbers, count).tolist()))} )", "[calibration]"]
    lines += [" ".join(map(repr, row)) for row in rows.tolist()]
    lines += [" ".join(["0.0"] * 6)] * MODULE
    write_lines(path, lines)


def _representatives(numbers: IntArray, count: int) -> IntArray:
    """(count + MODULE,) what ``taxel2Repr`` says: the middle pad of the module, or its first where that is missing."""
    listed = np.full(count + MODULE, UNFITTED)
    listed[np.flatnonzero(np.isin(np.arange(count) % MODULE, THERMAL_PADS))] = THERMAL
    numbers = np.sort(numbers)
    modules, first = np.unique(numbers // MODULE, return_index=True)
    middle = modules * MODULE + REPRESENTATIVE
    chosen = np.where(np.isin(middle, numbers), middle, numbers[first])
    listed[numbers] = chosen[np.searchsorted(modules, numbers // MODULE)]
    return listed


def _fitted(rows: Rows, path: Path, findings: list[Finding]) -> BoolArray:
    """(n,) rows that hold a taxel that feels touch: fitted by the list, not thermal, not all zero."""
    where, count = path.name, len(rows.values)
    placed, state = (rows.values != 0).any(axis=1), _states(rows)
    listed = 0 if rows.representatives is None else len(rows.representatives)
    if listed:
        action = f"taxel2Repr has {listed} entries for {count} rows; rows beyond it are fitted where they are not zero"
        note(findings, "list-length", where, action, abs(listed - count))
    left_out = {
        "unused-row": ("the row is all zero", ~placed),
        "thermal-pad": ("it measures temperature", placed & (state == THERMAL)),
        "unfitted-taxel": ("it has a position, but taxel2Repr says not fitted", placed & (state == UNFITTED)),
        "missing-position": ("taxel2Repr says fitted, but its row is all zero", ~placed & (state == FITTED)),
    }
    for kind, (reason, which) in left_out.items():
        note(findings, kind, where, f"left out: {reason}", int(which.sum()))
    return np.asarray(placed & ((state == FITTED) | (state == UNKNOWN)))


def _states(rows: Rows) -> IntArray:
    """(n,) FITTED, UNFITTED, THERMAL, or UNKNOWN beyond the end of the list."""
    count = len(rows.values)
    state = np.full(count, UNKNOWN)
    if rows.representatives is not None:
        listed = rows.representatives[:count]
        state[: len(listed)] = np.where(listed >= 0, FITTED, listed)
    if count % MODULE == 0:
        # Older files mark thermal pads -1; where nothing is listed only the pad's place in its module tells.
        pad = np.isin(np.arange(count) % MODULE, THERMAL_PADS)
        state[pad & (state != FITTED)] = THERMAL
    return state


def _distinct(positions: FloatArray, path: Path, findings: list[Finding]) -> IntArray:
    """Indices of the first taxel at each place."""
    _, first = np.unique(np.rint(positions / SAME_PLACE), axis=0, return_index=True)
    note(findings, "duplicate-taxel", path.name, "merged: two taxels at one place", len(positions) - len(first))
    return np.sort(first)


def _normals(positions: FloatArray, normals: FloatArray, path: Path, findings: list[Finding]) -> FloatArray | None:
    """Unit normals, or None where they are absent or the same dummy throughout."""
    if not normals.shape[1]:
        return None
    same = bool((normals == normals[0]).all())
    if same and normals[0].any() and np.ptp(positions @ (normals[0] / np.linalg.norm(normals[0]))) > _FLAT:
        note(
            findings,
            "dummy-normals",
            path.name,
            "not used: one normal for taxels that are not in one plane",
            len(normals),
        )
        return None
    return unit_normals(normals, path.name, findings)


def import_icub(robot: Robot, path: str | Path, *, link: str | None = None, thickness: float = 0.003) -> Skin:
    """The skin of the positions file at ``path``, worn by the link it names.

    Args:
        robot: Usually iCub; any robot with a link that fits.
        path: The positions file.
        link: Which link wears it; None for the one the file names.
        thickness: Of the cover over the link's mesh [m].

    Raises:
        SkinError: The file cannot be used, the robot has no link of its name, or the taxels lie far from the link.
        RobotError: The robot has no link called ``link``.
    """
    taxels = read_icub_positions(path)
    name = link or _find_link(robot, taxels.link, Path(path))
    skin = wear(robot, name, taxels.positions, thickness=thickness, file=path)
    return Skin(skin.patches, taxels.findings + skin.findings)


def _find_link(robot: Robot, named: str | None, path: Path) -> str:
    """The robot's link for the file's name; ``upper_arm`` in the file ``left_arm`` is ``l_upper_arm`` on the robot."""
    if named is None:
        raise SkinError("the file does not name its link", file=path, remedy="Choose the link that wears these taxels")
    side = {"left": "l_", "right": "r_"}.get(path.name.partition("_")[0], "")
    for name in (named, side + named):
        if name in robot.link_index:
            return name
    raise SkinError(
        "the robot has no link of the file's name",
        file=path,
        value=named,
        remedy=f"Choose one of: {', '.join(robot.link_index)}",
    )
