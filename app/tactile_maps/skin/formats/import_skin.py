"""The skin in a file of taxels, on the robot that carries them or alone: one answer for every door of the program.

Whatever opens such a file (a scene, the window, each command, the library) asks ``import_skin``, so that a format is
known everywhere or nowhere. The link that carries the taxels is the one that the file names, or the one that a person
names where the file does not, or where the robot calls it otherwise.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from tactile_maps.core.errors import Finding, SkinError, errors_in_file
from tactile_maps.core.files import MAX_UNPACKED_BYTES, array_format, read_bounded_file
from tactile_maps.robots.formats.touch_sensors import read_touch_sensors, states_touch_sensors
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.fit import carrying_link, match_frame, place_taxels
from tactile_maps.skin.formats.icub_frames import icub_frames
from tactile_maps.skin.formats.icub_positions import read_icub_positions
from tactile_maps.skin.formats.mujoco_touch import skin_of_touch_sensors
from tactile_maps.skin.formats.npz import FORMAT as TAXEL_FORMAT
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, taxel_format_for
from tactile_maps.skin.model.skin import Skin, merge_skins
from tactile_maps.skin.model.skin_file import FORMAT, MAP_FORMAT, load_skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels

NO_ROBOT = "none"
"""Named as the robot, it means that no robot carries the taxels: they are joined to each other instead."""
TAXEL_ENDINGS = (".txt", ".csv", ".tsv", ".json")
"""Of files that hold taxels and nothing else; robot descriptions and npz may."""
_MJCF = (".xml", ".mjcf")
_ONLY_WHOLE = re.compile(r"r_|(l_)?(hip|upper_leg|lower_leg|ankle|foot)|neck|head")


def holds_taxels(path: str | Path) -> bool:
    """Whether ``path`` is a file of taxels: by its ending; for robots and npz by what is in it. A map of ours is not.

    A folder is where it has files ``*.txt``.

    Cost: that of reading a robot description or npz file; none for the others.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if os.path.isdir(path):
        return bool(_position_files(path))
    if ending in _MJCF:
        return states_touch_sensors(path)
    if ending not in (".urdf", ".npz"):
        return ending in TAXEL_ENDINGS or taxel_format_for(path) is not None
    try:
        data = read_bounded_file(path, error=SkinError, most=MAX_UNPACKED_BYTES)
    except SkinError:
        return False  # whoever opens it says why it cannot be read
    if ending == ".urdf":
        return b"<tactile" in data
    found = array_format(data)
    # A table that another program wrote has no format; what is no npz at all is left to who reads maps.
    return found == FORMAT or (data.startswith(b"PK") and found in (None, TAXEL_FORMAT))


def is_robot_with_taxels(path: str | Path) -> bool:
    """Whether ``path`` is a robot that states taxels: a URDF with shapes too, or an MJCF model with touch sensors."""
    path = Path(path)
    if path.suffix.lower() in _MJCF:
        return holds_taxels(path)
    if path.suffix.lower() != ".urdf" or not holds_taxels(path):
        return False
    data = read_bounded_file(path, error=SkinError, most=MAX_UNPACKED_BYTES)
    return b"<visual" in data or b"<collision" in data


def import_skin(
    path: str | Path,
    robot: Robot | None = None,
    *,
    links: Sequence[str] = (),
    thickness: float = 0.003,
    package_roots: Sequence[str] = (),
) -> Skin:
    """The skin that the file at ``path`` holds; its findings tell what was repaired, left out or guessed.

    Args:
        path: iCub positions, a table, npz, Genoa's JSON, URDF with tactile sensors, MJCF with touch sensors, or a skin
            or map of ours. Or a folder of iCub positions: each link wears the file that lies closest to it, findings
            tell the others.
        robot: Carries the taxels: each link's move onto a cover of it. None joins them to each other instead.
        links: Of a file with several links, those that are wanted; of a file with one, the link that carries it.
        thickness: Of the cover over a link's mesh [m].
        package_roots: Further folders in which the files that an MJCF model names may lie.

    Raises:
        SkinError: The file cannot be used, names no link where one is needed, or one that is not there.
        RobotError: The robot has no link of a name in ``links``.

    Cost: 0.2 s for 1000 taxels alone, 0.5 to 2 s for 400 on a robot; about 20 s for all 4,077 of an iCub.
    """
    path = Path(path)
    if os.path.isdir(path):
        return _import_folder(path, robot, links, thickness)
    if is_own_skin(path):
        return _own_skin(path, robot)
    if path.suffix.lower() in _MJCF:
        roots = [Path(root) for root in package_roots]
        carrier = _touched_robot(path, robot)
        return skin_of_touch_sensors(carrier, path, links=links, thickness=thickness, package_roots=roots)
    sets = _chosen(read_taxel_sets(path), links, robot, path)
    with errors_in_file(path):
        made = [skin_from_taxels(one) if robot is None else _fitted(robot, one, thickness, path) for one in sets]
    return merge_skins([_with_area_note(skin, one) for skin, one in zip(made, sets, strict=True)])


def usual_carrier(path: str | Path, links: Sequence[str] = ()) -> str:
    """The robot that carries the taxels where nobody names one: iCub for its positions files, an MJCF model itself,
    ``none`` for others.

    Its torso and left arm are enough for a file of these; one of the right side, the legs or the head, or a folder,
    needs all of it. No robot is loaded for the answer.
    """
    path = Path(path)
    if os.path.isdir(path):
        return "icub_whole"
    if path.suffix.lower() in _MJCF:
        return str(path)
    if path.suffix.lower() != ".txt":
        return NO_ROBOT
    try:
        named = links or [link for link in named_links(path) if link]
    except SkinError:
        return "icub"  # whoever opens the file says what is wrong with it
    right = path.name.partition("_")[0] == "right"
    return "icub_whole" if right or any(_ONLY_WHOLE.match(link) for link in named) else "icub"


def named_links(path: str | Path) -> tuple[str | None, ...]:
    """The links that the file at ``path`` names, one for each of its sets of taxels; None for a set without.

    Raises:
        SkinError: The file cannot be read.
    """
    path = Path(path)
    if os.path.isdir(path):
        return tuple(read_icub_positions(file).link for file in _position_files(path))
    if is_own_skin(path):
        return tuple(dict.fromkeys(patch.link for patch in load_skin(path).patches))
    if path.suffix.lower() in _MJCF:
        return tuple(dict.fromkeys(sensor.link for sensor in read_touch_sensors(path)[0]))
    return tuple(taxels.link for taxels in read_taxel_sets(path))


def check_links(path: str | Path, robot: Robot | None, links: Sequence[str] = ()) -> None:
    """Refuse what ``import_skin`` would refuse about the links, without fitting anything.

    Raises:
        SkinError: As ``import_skin``.
        RobotError: As ``import_skin``.
    """
    path = Path(path)
    if os.path.isdir(path):
        _folder_sets(path, robot, links)
        return
    if is_own_skin(path):
        _own_skin(path, robot)
        return
    if path.suffix.lower() in _MJCF:
        _touched_robot(path, robot)
        return
    for taxels in _chosen(read_taxel_sets(path), links, robot, path):
        if robot is not None:
            carrying_link(robot, taxels.link, path)


def is_own_skin(path: str | Path) -> bool:
    """Whether the file is a skin of ours, or a map of ours, which keeps its skin."""
    path = Path(path)
    if path.suffix.lower() != ".npz":
        return False
    return array_format(read_bounded_file(path, error=SkinError, most=MAX_UNPACKED_BYTES)) in (FORMAT, MAP_FORMAT)


def _touched_robot(path: Path, robot: Robot | None) -> Robot:
    """The robot, if one of the bodies with touch sensors is a link of it."""
    remedy = "Open the file as the robot that carries them"
    if robot is None:
        raise SkinError("touch sensors need their robot", file=path, remedy=remedy)
    named = named_links(path)
    if not any(link in robot.link_index for link in named):
        raise SkinError("the robot has none of the bodies with touch sensors", file=path, value=", ".join(
            str(link) for link in named), remedy=remedy)  # fmt: skip
    return robot


def _own_skin(path: Path, robot: Robot | None) -> Skin:
    """The skin as it was saved; a robot must have its links."""
    skin = load_skin(path)
    missing = [patch.link for patch in skin.patches if robot is not None and patch.link not in robot.link_index]
    if missing and robot is not None:
        remedy = f"Open it with the robot that it was made for; this one has: {', '.join(robot.link_index)}"
        raise SkinError("the robot has no link of the skin's", file=path, value=missing[0], remedy=remedy)
    return skin


def _chosen(sets: Sequence[TaxelSet], links: Sequence[str], robot: Robot | None, path: Path) -> list[TaxelSet]:
    """The sets on ``links``, all without; a lone set goes on the link that is named."""
    if not links:
        return list(sets)
    chosen = [taxels for taxels in sets if taxels.link in links]
    if {taxels.link for taxels in chosen} == set(links):
        return chosen
    if len(sets) == len(links) == 1 and (robot is not None or sets[0].link is None):
        if robot is not None:
            robot.link(links[0])  # says which there are
        return [replace(sets[0], link=links[0])]
    here = [taxels.link or "no name" for taxels in sets]
    missing = next(link for link in links if link not in here)
    remedy = f"Choose one of: {', '.join(here)}"
    raise SkinError("the file has no taxels of that link", file=path, value=missing, remedy=remedy)


def _with_area_note(skin: Skin, taxels: TaxelSet) -> Skin:
    """The skin, with a finding where the file states areas: a taxel answers for its cell of the surface instead.

    The surface presses everywhere, not on pads alone; with the pads' areas the skin would carry too little force.
    """
    if taxels.areas is None:
        return skin
    share = float(taxels.areas.sum() / skin.areas.sum())
    action = f"not used: a taxel answers for its cell of the surface; the stated areas are {100 * share:.0f} % of those"
    return replace(skin, findings=(*skin.findings, Finding("stated-area", taxels.name, action, len(taxels))))


def _fitted(robot: Robot, taxels: TaxelSet, thickness: float, path: Path) -> Skin:
    link = carrying_link(robot, taxels.link, path)
    return place_taxels(robot, link, taxels, thickness=thickness, file=path, frames=icub_frames(robot, link))


def _position_files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.txt"))


def _folder_sets(
    folder: Path, robot: Robot | None, links: Sequence[str]
) -> tuple[dict[str, dict[Path, TaxelSet]], list[Finding]]:
    """By link of the robot the files for it; findings tell the files for other links."""
    if robot is None:
        remedy = "Open it with the robot that carries them, or choose one file"
        raise SkinError("a folder of positions needs a robot", file=folder, remedy=remedy)
    findings: list[Finding] = []
    of_link: dict[str, dict[Path, TaxelSet]] = {}
    for file in _position_files(folder):
        taxels = read_icub_positions(file)
        try:
            link = carrying_link(robot, taxels.link, file)
        except SkinError as error:
            findings.append(Finding("link-missing", file.name, f"left out: {error.problem}", len(taxels)))
            continue
        if not links or link in links:
            of_link.setdefault(link, {})[file] = taxels
    missing = [link for link in links if link not in of_link]
    if missing or not of_link:
        problem = "no file in the folder is for that link" if missing else "no file in the folder is for this robot"
        remedy = f"Choose a folder with positions files for: {', '.join(robot.link_index)}"
        raise SkinError(problem, file=folder, value=missing[0] if missing else len(findings), remedy=remedy)
    return of_link, findings


def _import_folder(folder: Path, robot: Robot | None, links: Sequence[str], thickness: float) -> Skin:
    of_link, findings = _folder_sets(folder, robot, links)
    assert robot is not None
    skins = [Skin((), tuple(findings))]
    for link, files in of_link.items():
        best, left_out = _closest_file(robot, link, files)
        skin = _fitted(robot, replace(files[best], link=link), thickness, best)
        skins.append(replace(skin, findings=(*left_out, *skin.findings)))
    return merge_skins(skins)


def _closest_file(robot: Robot, link: str, files: Mapping[Path, TaxelSet]) -> tuple[Path, list[Finding]]:
    """Which of the files for ``link``, as from robots of different versions, lies closest to its mesh."""
    if len(files) == 1:
        return next(iter(files)), []
    frames = icub_frames(robot, link)
    away = {file: match_frame(robot, link, taxels.positions, frames=frames).median for file, taxels in files.items()}
    best = min(away, key=lambda file: away[file])

    def reason(file: Path) -> str:
        if away[best] == float("inf"):
            return f"the mesh of the link {link} is missing, and {best.name} is the first file for it"
        return f"{1e3 * away[file]:.1f} mm off the link {link}, {best.name} {1e3 * away[best]:.1f} mm"

    return best, [
        Finding("other-calibration", file.name, f"left out: {reason(file)}", len(taxels))
        for file, taxels in files.items()
        if file != best
    ]
