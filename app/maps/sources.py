"""One door for whatever a user has: a robot, a bare mesh, taxels alone, taxels for a robot, a skin or a map of ours.

Which it is follows from the file's ending and, where two kinds share one, from its content.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from app.errors import Finding, SkinError, TactileMapsError
from app.maps.map_file import load_map
from app.robots.library import find_robot
from app.robots.mesh_file import MESH_SUFFIXES, in_metres, read_mesh
from app.robots.robot import Robot
from app.skin.bare import skin_of_mesh
from app.skin.cover import cover
from app.skin.cover_spec import CoverSpec
from app.skin.exchange.icub import import_icub
from app.skin.exchange.read import read_taxel_sets
from app.skin.exchange.taxel_set import TaxelSet
from app.skin.from_taxels import skin_from_taxels
from app.skin.pieces import piece_name
from app.skin.placement_spec import PlacementSpec
from app.skin.skin import Patch, Skin
from app.skin.skin_file import load_skin
from app.skin.wear import wear

Surface = Literal["outer", "all", "cover"]
Progress = Callable[[str, float], None]
NOBODY = "none"
"""Named as the robot, it means that nobody wears the taxels: they are joined to each other instead."""
_TAXEL_ENDINGS = (".txt", ".csv", ".tsv", ".json")
_DEFAULT_TAXELS = 1000


def _silent(_text: str, _fraction: float) -> None:
    """No progress wanted."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """What a person says about a skin besides where it comes from.

    Attributes:
        placement: Of the taxels on a mesh; by default 1000, evenly.
        links: Which links to cover, or the one that wears the file's taxels; empty to choose.
        robot: Who wears the taxels of a file: None for iCub with iCub positions and nobody otherwise.
        surface: Of a bare mesh: its ``outer`` surface, ``all`` of it, or a ``cover`` over it, as robots get.
        thickness: Of a cover [m].
    """

    placement: PlacementSpec = field(default_factory=lambda: PlacementSpec(taxels=_DEFAULT_TAXELS))
    links: tuple[str, ...] = ()
    robot: str | None = None
    surface: Surface = "outer"
    thickness: float = 0.003

    def __post_init__(self) -> None:
        if self.surface not in get_args(Surface):
            remedy = f"Choose one of: {', '.join(get_args(Surface))}"
            raise SkinError("there is no such surface", place="surface", value=self.surface, remedy=remedy)


def open_skin(source: str | Path, wanted: Wanted | None = None, *, progress: Progress = _silent) -> Skin:
    """The skin that ``source`` holds or can wear; what was repaired on the way is among its findings.

    Args:
        source: A file, or a robot's name.
        wanted: How taxels are placed where the source has none, and who wears them.
        progress: Told what is being done and how far it is, 0 to 1; may raise to cancel.

    Raises:
        TactileMapsError: The source cannot be read, or cannot wear what is wanted.
    """
    spec, path = wanted or Wanted(), Path(source)
    ending = path.suffix.lower()
    if ending == ".npz":
        return _arrays(path, spec)
    if ending in _TAXEL_ENDINGS or _has_sensors(path):
        return _taxels(path, spec)
    if ending in MESH_SUFFIXES and spec.surface != "cover":
        mesh, findings = in_metres(read_mesh(path), where=path.name)
        skin = skin_of_mesh(mesh, spec.placement, name=path.stem, surface=spec.surface, progress=progress)
        return Skin(skin.patches, (*findings, *skin.findings))
    robot = find_robot(str(source))
    skin = cover(robot, _cover_spec(spec), progress=progress)
    return Skin(skin.patches, (*robot.findings, *skin.findings))


def _cover_spec(wanted: Wanted) -> CoverSpec:
    placement = wanted.placement
    if placement.taxels is None or placement.pattern != "even" or placement.density is not None:
        raise SkinError(
            "a cover has evenly spread taxels, stated by their number",
            place="placement",
            value=placement.pattern,
            remedy="Choose a bare mesh's own surface for a pitch, a pattern or a density",
        )
    return CoverSpec(wanted.links, placement.taxels, wanted.thickness, placement.seed)


def _arrays(path: Path, wanted: Wanted) -> Skin:
    """A skin or map of ours, or else a table of taxels: all are npz."""
    for load in (lambda: load_skin(path), lambda: load_map(path).skin):
        try:
            return load()
        except TactileMapsError as error:
            if not error.problem.startswith("this is not"):
                raise
    return _taxels(path, wanted)


def _has_sensors(path: Path) -> bool:
    """Whether a URDF states taxels as sensors."""
    if path.suffix.lower() != ".urdf":
        return False
    try:
        return b"<tactile" in path.read_bytes()
    except OSError:
        return False  # the loader says why it cannot be read


def _taxels(path: Path, wanted: Wanted) -> Skin:
    """A foreign file's taxels, on the robot that wears them or joined to each other."""
    wearer = wanted.robot or ("icub" if path.suffix.lower() == ".txt" else NOBODY)
    link = wanted.links[0] if wanted.links else None
    if wearer != NOBODY and path.suffix.lower() == ".txt":
        robot = find_robot(wearer)
        skin = import_icub(robot, path, link=link, thickness=wanted.thickness)
        return Skin(skin.patches, (*robot.findings, *skin.findings))
    sets = [one for one in read_taxel_sets(path) if link is None or one.link == link]
    if not sets:
        raise SkinError("the file has no taxels of that link", file=path, value=link)
    if wearer == NOBODY:
        return _joined([skin_from_taxels(one) for one in sets])
    robot = find_robot(wearer)
    return _joined([_worn(robot, one, link, wanted.thickness, path) for one in sets])


def _worn(robot: Robot, taxels: TaxelSet, link: str | None, thickness: float, path: Path) -> Skin:
    name = link or taxels.link
    if name is None:
        links = ", ".join(robot.link_index)
        raise SkinError("the file does not name its link", file=path, remedy=f"Choose one of: {links}")
    skin = wear(robot, name, taxels.positions, thickness=thickness, file=path)
    return Skin(skin.patches, (*taxels.findings, *skin.findings))


def _joined(skins: list[Skin]) -> Skin:
    """All patches in one skin, each with a name of its own."""
    patches: list[Patch] = []
    findings: list[Finding] = []
    for skin in skins:
        findings += skin.findings
        for patch in skin.patches:
            before = sum(other.link == patch.link for other in patches)
            patches.append(Patch(piece_name(patch.link, before), patch.link, patch.surface, patch.taxels))
    return Skin(tuple(patches), tuple(findings))
