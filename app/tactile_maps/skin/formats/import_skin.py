"""Skin from a file of taxels, on the robot that carries them or alone.

Every format is read through ``TaxelFile``, so that it is supported everywhere or nowhere. The link that carries the
taxels is the one that the file names, or the one that the user names where the file names none or the robot uses
another name.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import Finding, SkinError, errors_in_file
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.robots.formats.touch_sensors import read_touch_sensors
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.frame_match import carrying_link, match_frame
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.formats.icub.frames import icub_frames
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.identify import MJCF_SUFFIXES, kind_of
from tactile_maps.skin.formats.mujoco_touch import skin_of_touch_sensors
from tactile_maps.skin.formats.taxel_files import read_taxel_sets
from tactile_maps.skin.model.skin import Skin, merge_skins
from tactile_maps.skin.model.skin_file import load_skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels

NO_ROBOT = "none"
"""Robot name for taxels that no robot carries: they are joined to each other instead."""
_ONLY_WHOLE = re.compile(r"r_|(l_)?(hip|upper_leg|lower_leg|ankle|foot)|neck|head")


class TaxelFile:
    """A file or folder with taxels. Its content is parsed once, when it is first needed.

    Args:
        path: iCub positions, a table, npz, Genoa's JSON, URDF with tactile sensors, MJCF with touch sensors, a skin or
            map saved by this program, or a folder of iCub positions.
        package_roots: Further folders that may contain files that an MJCF model names.

    Attributes:
        path: The file or folder.
        kind: Its kind; robots with touch sensors are robots.
        is_folder: Whether it is a folder of iCub positions.
    """

    def __init__(self, path: str | Path, *, package_roots: Sequence[str] = ()) -> None:
        self.path = Path(path)
        self.kind = kind_of(path)
        self._roots = [Path(root) for root in package_roots]
        self.is_folder = os.path.isdir(path)
        self._own = self.kind in (FileKind.SKIN, FileKind.MAP)
        self._touched = self.kind is FileKind.ROBOT and self.path.suffix.lower() in MJCF_SUFFIXES

    @cached_property
    def links(self) -> tuple[str | None, ...]:
        """Links that the file names, one for each set of taxels; None for a set without a link.

        Raises:
            SkinError: The file cannot be read.
        """
        if self._own:
            return self._own_skin.links
        if self._touched:
            return tuple(dict.fromkeys(sensor.link for sensor in read_touch_sensors(self.path)[0]))
        return tuple(taxels.link for taxels in self.sets.values())

    def stated_ids(self, robot: Robot | None, links: Sequence[str] = ()) -> set[tuple[str | None, int]]:
        """Return the link and id of each taxel whose id the file states.

        Args:
            robot: Robot that carries the taxels, if any.
            links: Links to use of a file with several; the link that carries a single set.

        Raises:
            SkinError: The file cannot be read.
        """
        if self._touched:
            return set()
        parts: list[tuple[str | None, IntArray | None]]
        if self._own:
            parts = [(patch.link, patch.taxels.identity.ids) for patch in self._own_skin.patches]
        else:
            only = links[0] if len(self.links) == len(links) == 1 else None
            parts = [(only or _robot_link(robot, one.link, file), one.ids) for (file, _), one in self.sets.items()]
        return {
            (link, number)
            for link, ids in parts
            if ids is not None and (not links or link in links)
            for number in ids.tolist()
        }

    def usual_carrier(self, links: Sequence[str] = ()) -> str:
        """Return the robot that carries the taxels unless the user names one.

        It is iCub for its positions files, an MJCF model itself, and ``none`` for others. For links of the torso and
        left arm, part of iCub is enough; a file of the right side, the legs or the head, or a folder, needs the whole
        robot. No robot is loaded.

        Args:
            links: Links that the user names instead of those of the file.
        """
        if self.is_folder:
            return "icub_whole"
        if self._touched:
            return str(self.path)
        if self.path.suffix.lower() != ".txt":
            return NO_ROBOT
        try:
            named = links or [link for link in self.links if link]
        except SkinError:
            return "icub"  # reported when the skin is built
        right = self.path.name.partition("_")[0] == "right"
        return "icub_whole" if right or any(_ONLY_WHOLE.match(link) for link in named) else "icub"

    def check_links(self, robot: Robot | None, links: Sequence[str] = ()) -> None:
        """Raise the errors of ``skin`` that concern links, without fitting anything.

        Raises:
            SkinError: See ``skin``.
            RobotError: See ``skin``.
        """
        if self.is_folder:
            self._sets_by_link(robot, links)
        elif self._own:
            self._checked_own(robot)
        elif self._touched:
            self._carrier_of_sensors(robot)
        else:
            for taxels in self._chosen(links, robot):
                if robot is not None:
                    carrying_link(robot, taxels.link, self.path)

    def skin(self, robot: Robot | None = None, *, links: Sequence[str] = (), thickness: float = 0.003) -> Skin:
        """Return the skin in the file; its findings list what was repaired, left out or guessed.

        Of a folder, each link gets the file whose taxels are closest to it; findings list the others.

        Args:
            robot: Robot that carries the taxels, which are moved to a cover of their links. None joins the taxels to
                each other instead.
            links: Links to use of a file with several; for a file with one set, the link that carries it.
            thickness: Thickness of the cover over a link's mesh [m].

        Raises:
            SkinError: The file is not usable, names no link where one is needed, or names a missing link.
            RobotError: The robot has no link of a name in ``links``.

        Cost: 0.2 s for 1000 taxels alone, 0.5 to 2 s for 400 on a robot; about 20 s for all 4,077 of an iCub.
        """
        if self.is_folder:
            return self._skin_of_folder(robot, links, thickness)
        if self._own:
            return self._checked_own(robot)
        if self._touched:
            carrier = self._carrier_of_sensors(robot)
            return skin_of_touch_sensors(
                carrier, self.path, links=links, thickness=thickness, package_roots=self._roots
            )
        sets = self._chosen(links, robot)
        if robot is not None and self.kind is FileKind.LAYOUT:
            remedy = "Open it alone (robot none), or with the positions file of the same patch as the layout of its map"
            raise SkinError("a layout has no positions on the body", file=self.path, remedy=remedy)
        with errors_in_file(self.path):
            made = [
                skin_from_taxels(one) if robot is None else _fitted(robot, one, thickness, self.path) for one in sets
            ]
        return merge_skins([_with_area_note(skin, one) for skin, one in zip(made, sets, strict=True)])

    @cached_property
    def sets(self) -> Mapping[tuple[Path, int], TaxelSet]:
        """Sets of taxels by file and number in the file; not for skins and touch sensors.

        Raises:
            SkinError: The file cannot be read.
        """
        if self.is_folder:
            return {(file, 0): read_icub_positions(file) for file in sorted(self.path.glob("*.txt"))}
        return {(self.path, number): one for number, one in enumerate(read_taxel_sets(self.path))}

    @cached_property
    def _own_skin(self) -> Skin:
        return load_skin(self.path)

    def _carrier_of_sensors(self, robot: Robot | None) -> Robot:
        """Return the robot if one of the bodies with touch sensors is a link of it."""
        remedy = "Open the file as the robot that carries them"
        if robot is None:
            raise SkinError("touch sensors need their robot", file=self.path, remedy=remedy)
        if not any(link in robot.link_index for link in self.links):
            problem = "the robot has none of the bodies with touch sensors"
            raise SkinError(problem, file=self.path, value=", ".join(map(str, self.links)), remedy=remedy)
        return robot

    def _checked_own(self, robot: Robot | None) -> Skin:
        """Return the saved skin, if the robot has its links."""
        skin = self._own_skin
        missing = [link for link in self.links if robot is not None and link not in robot.link_index]
        if missing and robot is not None:
            remedy = f"Open it with the robot that it was made for; this one has: {', '.join(robot.link_index)}"
            raise SkinError("the robot has no link of the skin's", file=self.path, value=missing[0], remedy=remedy)
        return skin

    def _chosen(self, links: Sequence[str], robot: Robot | None) -> list[TaxelSet]:
        """Return the sets on ``links``, all sets if none are named; a single set is placed on the named link."""
        sets = list(self.sets.values())
        if not links:
            return sets
        chosen = [taxels for taxels in sets if taxels.link in links]
        if {taxels.link for taxels in chosen} == set(links):
            return chosen
        if len(sets) == len(links) == 1 and (robot is not None or sets[0].link is None):
            if robot is not None:
                robot.link(links[0])  # raises if the robot does not have it
            return [replace(sets[0], link=links[0])]
        here = [taxels.link or "no name" for taxels in sets]
        missing = next(link for link in links if link not in here)
        remedy = f"Choose one of: {', '.join(here)}"
        raise SkinError("the file has no taxels of that link", file=self.path, value=missing, remedy=remedy)

    def _sets_by_link(
        self, robot: Robot | None, links: Sequence[str]
    ) -> tuple[dict[str, dict[Path, TaxelSet]], list[Finding]]:
        """Return the files of a folder for each link of the robot; findings list the files for other links."""
        if robot is None:
            remedy = "Open it with the robot that carries them, or choose one file"
            raise SkinError("a folder of positions needs a robot", file=self.path, remedy=remedy)
        findings: list[Finding] = []
        of_link: dict[str, dict[Path, TaxelSet]] = {}
        for (file, _), taxels in self.sets.items():
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
            value = missing[0] if missing else len(findings)
            raise SkinError(problem, file=self.path, value=value, remedy=remedy)
        return of_link, findings

    def _skin_of_folder(self, robot: Robot | None, links: Sequence[str], thickness: float) -> Skin:
        of_link, findings = self._sets_by_link(robot, links)
        assert robot is not None
        skins = [Skin((), tuple(findings))]
        for link, files in of_link.items():
            best, left_out = _closest_file(robot, link, files)
            skin = _fitted(robot, replace(files[best], link=link), thickness, best)
            skins.append(replace(skin, findings=(*left_out, *skin.findings)))
        return merge_skins(skins)


def _robot_link(robot: Robot | None, named: str | None, file: Path) -> str | None:
    """Return the link of the robot that a file calls ``named``; ``named`` if there is none."""
    if robot is None:
        return named
    try:
        return carrying_link(robot, named, file)
    except SkinError:
        return named


def _with_area_note(skin: Skin, taxels: TaxelSet) -> Skin:
    """Add a finding where the file states areas, which are replaced by the cells of the surface around each taxel.

    Contacts press the whole surface, not only the pads, so the areas of the pads would give too small a force.
    """
    if taxels.areas is None:
        return skin
    share = float(taxels.areas.sum() / skin.areas.sum())
    action = f"not used: a taxel represents its cell of the surface; the stated areas are {100 * share:.0f} % of those"
    return replace(skin, findings=(*skin.findings, Finding("stated-area", taxels.name, action, len(taxels))))


def _fitted(robot: Robot, taxels: TaxelSet, thickness: float, path: Path) -> Skin:
    link = carrying_link(robot, taxels.link, path)
    return place_taxels(robot, link, taxels, thickness=thickness, file=path, frames=icub_frames(robot, link))


def _closest_file(robot: Robot, link: str, files: Mapping[Path, TaxelSet]) -> tuple[Path, list[Finding]]:
    """Return the file, of several for ``link`` (from different robot versions), that is closest to the link's mesh."""
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
