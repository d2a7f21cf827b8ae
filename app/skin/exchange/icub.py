"""iCub skin positions files: read with every known defect counted, and worn by a link of a robot.

The format is that of iCubSkinGui (robotology/icub-main, app/skinGui/conf/positions): a few named values, then one row
``x y z [nx ny nz]`` a taxel, metres, link frame. Twelve rows make a triangular module; ``taxel2Repr`` says for each
taxel which one represents its module, -1 where nothing is fitted and -2 where the pad measures temperature. An older
form has rows only. All rows are read here; the original reader loses the last one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray, readonly
from app.errors import Finding, SkinError
from app.robots.robot import Robot
from app.skin.exchange.text_rows import Rows, read_rows
from app.skin.skin import Skin
from app.skin.wear import wear

MODULE = 12
THERMAL_PADS = (6, 10)
THERMAL, UNFITTED, FITTED, UNKNOWN = -2, -1, 0, 1
"""What is known of a row; the first two as the list writes them."""
SAME_PLACE = 1e-5
"""Taxels closer than this [m] are one: the files state tenths of a millimetre."""


@dataclass(frozen=True, eq=False)
class IcubTaxels:
    """The usable taxels of a positions file.

    Attributes:
        link: The link that the file names; None in a file without a header.
        numbers: (n,) each taxel's row in the file, which is its number on the robot.
        positions: (n, 3) [m], link frame.
        normals: (n, 3) unit normals, or None where the file has none that mean anything.
        findings: The file's defects, counted.
    """

    link: str | None
    numbers: IntArray
    positions: FloatArray
    normals: FloatArray | None
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", readonly(self.numbers, np.int64))
        object.__setattr__(self, "positions", readonly(self.positions))
        if self.normals is not None:
            object.__setattr__(self, "normals", readonly(self.normals))


def read_icub_positions(path: str | Path) -> IcubTaxels:
    """The usable taxels in the positions file at ``path``.

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
    normals = _normals(rows.values[number, 3:], path, findings)
    return IcubTaxels(rows.name, number, rows.values[number, :3], normals, tuple(findings))


def _fitted(rows: Rows, path: Path, findings: list[Finding]) -> BoolArray:
    """(n,) rows that hold a taxel that feels touch: fitted by the list, not thermal, not all zero."""
    where, count = path.name, len(rows.values)
    placed, state = (rows.values != 0).any(axis=1), _states(rows)
    listed = 0 if rows.representatives is None else len(rows.representatives)
    if listed:
        action = f"taxel2Repr has {listed} entries for {count} rows; rows beyond it are fitted where they are not zero"
        _note(findings, "list-length", where, action, abs(listed - count))
    left_out = {
        "unused-row": ("the row is all zero", ~placed),
        "thermal-pad": ("it measures temperature", placed & (state == THERMAL)),
        "unfitted-taxel": ("it has a position, but taxel2Repr says not fitted", placed & (state == UNFITTED)),
        "missing-position": ("taxel2Repr says fitted, but its row is all zero", ~placed & (state == FITTED)),
    }
    for kind, (reason, which) in left_out.items():
        _note(findings, kind, where, f"left out: {reason}", int(which.sum()))
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
    _note(findings, "duplicate-taxel", path.name, "merged: two taxels at one place", len(positions) - len(first))
    return np.sort(first)


def _normals(normals: FloatArray, path: Path, findings: list[Finding]) -> FloatArray | None:
    """Unit normals, or None where they are absent or the same dummy throughout."""
    if not normals.shape[1]:
        return None
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if (length == 0).any() or len(np.unique(normals, axis=0)) == 1:
        _note(findings, "dummy-normals", path.name, "the normals are taken from the link's surface", len(normals))
        return None
    off = int((np.abs(length - 1) > 1e-2).sum())
    _note(findings, "normals-not-unit", path.name, "scaled to length one", off)
    return normals / length


def _note(findings: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    if count:
        findings.append(Finding(kind, where, action, count))


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
