"""Skin built from one or several files of taxels.

Scenes, the window, every command and the library open the files of a skin through ``TaxelFiles``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import itemgetter
from pathlib import Path

from tactile_maps.core.errors import Finding, SkinError, counted
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.frame_match import carrying_link
from tactile_maps.skin.formats.import_skin import NO_ROBOT, TaxelFile
from tactile_maps.skin.model.skin import Skin, merge_skins

_WHOLE = "icub_whole"


class TaxelFiles:
    """Files with taxels whose skins are merged, in their order.

    Args:
        paths: At least one file, or folder of iCub positions.
        package_roots: Further folders that may contain files that an MJCF model names.

    Attributes:
        files: The files.
    """

    def __init__(self, paths: Sequence[str | Path], *, package_roots: Sequence[str] = ()) -> None:
        self.files = tuple(TaxelFile(path, package_roots=package_roots) for path in paths)

    def usual_carrier(self, links: Sequence[str] = ()) -> str:
        """Return the robot that carries the taxels unless the user names one, see ``TaxelFile.usual_carrier``.

        Raises:
            SkinError: The files are of different robots.
        """
        found = [file.usual_carrier(links) for file in self.files]
        robots = [robot for robot in dict.fromkeys(found) if robot != NO_ROBOT]
        if set(robots) == {"icub", _WHOLE}:
            return _WHOLE
        if len(robots) > 1:
            value = f"{robots[0]}, {robots[1]}"
            raise SkinError("the files are for different robots", value=value, remedy="Name the robot")
        return robots[0] if robots else NO_ROBOT

    def without_link(self, robot: Robot) -> tuple[TaxelFile, ...]:
        """Return the files with one set of taxels whose link is unknown to the robot.

        Raises:
            SkinError: A file cannot be read.
        """
        return tuple(file for file in self.files if _needs_link(file, robot))

    def check_links(self, robot: Robot | None, links: Sequence[str] = ()) -> None:
        """Raise the errors of ``skin`` that concern links and ids, without fitting anything.

        Raises:
            SkinError: See ``skin``.
            RobotError: See ``skin``.
        """
        for file, own in self._with_links(robot, links):
            file.check_links(robot, own)
        if len(self.files) > 1:
            self._check_ids(robot, links)

    def skin(self, robot: Robot | None = None, *, links: Sequence[str] = (), thickness: float = 0.003) -> Skin:
        """Return the merged skin; its findings list what was repaired, left out or guessed.

        Args:
            robot: Robot that carries the taxels, see ``TaxelFile.skin``.
            links: Of a single file as for ``TaxelFile.skin``. Of several files, the links of those that name none of
                the robot's: one for all of them, or one for each in their order.
            thickness: Thickness of the cover over a link's mesh [m].

        Raises:
            SkinError: A file is not usable or lacks a link, links are too many or too few, or two files state the same
                id for one link.
            RobotError: The robot has no link of a name in ``links``.

        Cost: that of ``TaxelFile.skin`` for each file.
        """
        if len(self.files) > 1:
            self.check_links(robot, links)
        made = [file.skin(robot, links=own, thickness=thickness) for file, own in self._with_links(robot, links)]
        return made[0] if len(made) == 1 else _with_repeated_ids(merge_skins(made))

    def _with_links(self, robot: Robot | None, links: Sequence[str]) -> Iterator[tuple[TaxelFile, tuple[str, ...]]]:
        """Yield each file with its links of ``links``."""
        if len(self.files) == 1:
            yield self.files[0], tuple(links)
            return
        lacking = [file for file in self.files if _needs_link(file, robot)]
        if links and not (lacking and len(links) in (1, len(lacking))):
            value = f"{counted(len(links), 'link')} for {counted(len(lacking), 'file')} without one"
            raise SkinError("links and files differ in number", value=value, remedy="Name one, or one for each file")
        given = dict(zip(lacking, [*links] * len(lacking), strict=False))
        for file in self.files:
            yield file, (given[file],) if file in given else ()

    def _check_ids(self, robot: Robot | None, links: Sequence[str]) -> None:
        """Reject the same id of one link in two files."""
        found: dict[tuple[str | None, int], TaxelFile] = {}
        for file, own in self._with_links(robot, links):
            for link, number in sorted(file.stated_ids(robot, own), key=itemgetter(1)):
                other = found.setdefault((link, number), file)
                if other is not file:
                    raise SkinError(
                        f"two files state the same id for one link, {other.path.name} and {file.path.name}",
                        file=file.path,
                        value=number if link is None else f"{link}:{number}",
                        remedy="Renumber the taxels of one of them, name another link for it, or import only one",
                    )


def _with_repeated_ids(skin: Skin) -> Skin:
    """Return the skin with a finding if several links have the same id, which is then addressed as ``link:id``."""
    links: dict[int, dict[str, None]] = {}
    for patch in skin.patches:
        ids = patch.taxels.identity.ids
        for number in [] if ids is None else ids.tolist():
            links.setdefault(number, {})[patch.link] = None
    repeated = {number: names for number, names in links.items() if len(names) > 1}
    if not repeated:
        return skin
    first = min(repeated)
    labels = " or ".join(f"{link}:{first}" for link in repeated[first])
    where = ", ".join(dict.fromkeys(link for names in repeated.values() for link in names))
    finding = Finding("repeated-id", where, f"several links have the same ids: address them as {labels}", len(repeated))
    return replace(skin, findings=(*skin.findings, finding))


def _needs_link(file: TaxelFile, robot: Robot | None) -> bool:
    """Whether the file has one set of taxels, with no link or none of the robot."""
    if len(file.links) != 1 or file.is_folder:
        return False
    if robot is None:
        return file.links[0] is None
    try:
        carrying_link(robot, file.links[0], file.path)
    except SkinError:
        return True
    return False
