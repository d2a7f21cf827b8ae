"""Opens whatever a user has as a skin: a robot, a bare mesh, taxels alone, taxels for a robot, a skin or a map of ours.

Which it is follows from the file's ending and, where two kinds share one, from its content.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from app.core.errors import Finding, SkinError
from app.core.files import MAX_UNPACKED_BYTES, array_format, read_bounded_file
from app.core.progress import Progress, no_progress
from app.robots.library import load_robot
from app.robots.mesh_files import MESH_SUFFIXES, read_mesh, to_metres
from app.robots.robot import Robot
from app.skin.cover import CoverSpec, cover_robot
from app.skin.fit import fit_taxels_to_link
from app.skin.formats.icub_positions import import_icub_skin
from app.skin.formats.taxel_files import read_taxel_sets
from app.skin.formats.taxel_set import TaxelSet
from app.skin.mesh_skin import skin_of_mesh
from app.skin.placement import PlacementSpec
from app.skin.reconstruct import skin_from_taxels
from app.skin.skin import Patch, Skin
from app.skin.skin_file import FORMAT, MAP_FORMAT, load_skin
from app.skin.usable_surface import patch_name

MeshSurface = Literal["outer", "all", "cover"]
NO_ROBOT = "none"
"""Named as the robot, it means that no robot carries the taxels: they are joined to each other instead."""
_TAXEL_ENDINGS = (".txt", ".csv", ".tsv", ".json")
_DEFAULT_TAXELS = 1000


@dataclass(frozen=True, eq=False)
class SkinOptions:
    """What a person says about a skin besides where it comes from.

    Attributes:
        placement: Of the taxels on a mesh; by default 1000, evenly.
        links: Which links to cover, or the one that carries the file's taxels; empty to choose.
        robot: What carries the taxels of a file: None for iCub with iCub positions, otherwise nothing.
        surface: Of a bare mesh: its ``outer`` surface, ``all`` of it, or a ``cover`` over it, as robots get.
        thickness: Of a cover [m].

    Example:
        >>> options = tm.SkinOptions(links=("hand",), thickness=0.002)
        >>> options.surface
        'outer'
    """

    placement: PlacementSpec = field(default_factory=lambda: PlacementSpec(taxels=_DEFAULT_TAXELS))
    links: tuple[str, ...] = ()
    robot: str | None = None
    surface: MeshSurface = "outer"
    thickness: float = 0.003

    def __post_init__(self) -> None:
        if self.surface not in get_args(MeshSurface):
            remedy = f"Choose one of: {', '.join(get_args(MeshSurface))}"
            raise SkinError("there is no such surface", place="surface", value=self.surface, remedy=remedy)


def open_skin(source: str | Path, options: SkinOptions | None = None, *, progress: Progress = no_progress) -> Skin:
    """The skin that ``source`` holds or can be covered by; what was repaired on the way is among its findings.

    Args:
        source: A file, or a robot's name.
        options: How taxels are placed where the source has none, and what carries them.
        progress: Told what is being done and how far it is, 0 to 1; may raise to cancel.

    Raises:
        TactileMapsError: The source cannot be read, or cannot be covered as wanted.

    Example:
        >>> tm.save_map(tactile_map, "hand.npz")
        >>> [patch.name for patch in tm.open_skin("hand.npz").patches]
        ['hand']
    """
    spec, path = options or SkinOptions(), Path(source)
    ending = path.suffix.lower()
    if ending == ".npz":
        return _read_own_npz(path, spec)
    if ending in _TAXEL_ENDINGS or _has_sensors(path):
        return _read_foreign_taxels(path, spec)
    if ending in MESH_SUFFIXES and spec.surface != "cover":
        mesh, findings = to_metres(read_mesh(path), where=path.name)
        skin = skin_of_mesh(mesh, spec.placement, name=path.stem, surface=spec.surface, progress=progress)
        return Skin(skin.patches, (*findings, *skin.findings))
    robot = load_robot(str(source))
    skin = cover_robot(robot, _cover_spec(spec), progress=progress)
    return Skin(skin.patches, (*robot.findings, *skin.findings))


def _cover_spec(wanted: SkinOptions) -> CoverSpec:
    placement = wanted.placement
    if placement.taxels is None or placement.pattern != "even" or placement.density is not None:
        raise SkinError(
            "a cover has evenly spread taxels, stated by their number",
            place="placement",
            value=placement.pattern,
            remedy="Choose a bare mesh's own surface for a pitch, a pattern or a density",
        )
    return CoverSpec(wanted.links, placement.taxels, wanted.thickness, placement.seed)


def _read_own_npz(path: Path, wanted: SkinOptions) -> Skin:
    """A skin or map of ours, or else a table of taxels: all are npz."""
    ours = array_format(read_bounded_file(path, error=SkinError, most=MAX_UNPACKED_BYTES))
    return load_skin(path) if ours in (FORMAT, MAP_FORMAT) else _read_foreign_taxels(path, wanted)


def _has_sensors(path: Path) -> bool:
    """Whether a URDF states taxels as sensors."""
    if path.suffix.lower() != ".urdf":
        return False
    try:
        return b"<tactile" in read_bounded_file(path, error=SkinError)
    except SkinError:
        return False  # the loader says why it cannot be read


def _read_foreign_taxels(path: Path, wanted: SkinOptions) -> Skin:
    """A foreign file's taxels, on the robot that carries them or joined to each other."""
    wearer = wanted.robot or ("icub" if path.suffix.lower() == ".txt" else NO_ROBOT)
    link = wanted.links[0] if wanted.links else None
    if wearer != NO_ROBOT and path.suffix.lower() == ".txt":
        robot = load_robot(wearer)
        skin = import_icub_skin(robot, path, link=link, thickness=wanted.thickness)
        return Skin(skin.patches, (*robot.findings, *skin.findings))
    sets = [one for one in read_taxel_sets(path) if link is None or one.link == link]
    if not sets:
        raise SkinError("the file has no taxels of that link", file=path, value=link)
    if wearer == NO_ROBOT:
        return _merge_skins([skin_from_taxels(one) for one in sets])
    robot = load_robot(wearer)
    return _merge_skins([_fit_to_robot(robot, one, link, wanted.thickness, path) for one in sets])


def _fit_to_robot(robot: Robot, taxels: TaxelSet, link: str | None, thickness: float, path: Path) -> Skin:
    name = link or taxels.link
    if name is None:
        links = ", ".join(robot.link_index)
        raise SkinError("the file does not name its link", file=path, remedy=f"Choose one of: {links}")
    skin = fit_taxels_to_link(robot, name, taxels.positions, thickness=thickness, file=path, identity=taxels.identity)
    return Skin(skin.patches, (*taxels.findings, *skin.findings))


def _merge_skins(skins: list[Skin]) -> Skin:
    """All patches in one skin, each with a name of its own."""
    patches: list[Patch] = []
    findings: list[Finding] = []
    for skin in skins:
        findings += skin.findings
        for patch in skin.patches:
            before = sum(other.link == patch.link for other in patches)
            patches.append(Patch(patch_name(patch.link, before), patch.link, patch.surface, patch.taxels))
    return Skin(tuple(patches), tuple(findings))
