"""Skins from any source: a robot, a bare mesh, taxels alone, taxels for a robot, or a skin or map of this program.

The kind of the source follows from the suffix of the file, and from its content where kinds share a suffix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from tactile_maps.core.errors import SkinError, check_names
from tactile_maps.core.file_kinds import SOURCES, FileKind
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.robots.files.mesh_files import read_mesh_in_metres
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.home_posture import check_home
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.skin.fitting.grid import GridSpec, add_grids
from tactile_maps.skin.formats.identify import holds_taxels, identify, kind_of
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_maps.skin.mesh_skin import skin_of_mesh
from tactile_maps.skin.model.skin import Skin
from tactile_maps.skin.taxel_placement.placement import PlacementSpec

MeshSurface = Literal["outer", "all", "cover"]
_DEFAULT_TAXELS = 1000


@dataclass(frozen=True, eq=False)
class SkinOptions:
    """Options for opening a skin.

    Attributes:
        placement: Placement of taxels on a mesh; by default 1000 evenly spaced ones.
        links: Links to cover, or links of a file whose taxels are used; empty to choose.
        robot: Robot that carries the taxels of a file. By default iCub carries iCub positions, and no robot others.
        surface: For a robot that states its taxels, ``cover`` replaces them. For a bare mesh, taxels are on its
            ``outer`` surface, on ``all`` of it, or on a ``cover`` over it as on robots.
        thickness: Thickness of a cover [m].
        package_roots: Further folders with packages and meshes that a robot's file names.
        grid: Grid of taxels on the cover of one link, instead of the options above.
        home: Joint positions of the home posture of the robot by joint name [rad, m], instead of those in its file.

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
    package_roots: tuple[str, ...] = ()
    grid: GridSpec | None = None
    home: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_names(self.links, "links", error=SkinError)
        check_names(self.package_roots, "package_roots", error=SkinError)
        if self.surface not in get_args(MeshSurface):
            remedy = f"Choose one of: {', '.join(get_args(MeshSurface))}"
            raise SkinError("unknown surface", place="surface", value=self.surface, remedy=remedy)


def open_skin(
    source: str | Path | Sequence[str | Path],
    options: SkinOptions | None = None,
    *,
    progress: Progress = no_progress,
) -> Skin:
    """Return the skin in ``source``, or a skin that covers it; findings report repairs.

    Args:
        source: A file, a folder of iCub positions files, or the name of a robot; several files of taxels are merged.
        options: Placement of taxels for a source without taxels, and the robot that carries them.
        progress: Receives a text and the fraction done, 0 to 1; may raise to cancel.

    Raises:
        TactileMapsError: The source cannot be read, or cannot be covered as specified.

    Example:
        >>> tm.save_map(tactile_map, "hand.npz", overwrite=True)
        >>> [patch.name for patch in tm.open_skin("hand.npz").patches]
        ['hand']
    """
    spec = options or SkinOptions()
    if not isinstance(source, str | Path):
        if len(source) > 1:
            return _merged_taxels(source, spec)
        source = source[0]
    path = Path(source)
    if spec.grid is not None:
        robot = load_robot(str(source), package_roots=spec.package_roots, home=spec.home)
        skin = add_grids(robot, None, [spec.grid], thickness=spec.thickness)
        return replace(skin, findings=(*robot.findings, *skin.findings))
    kind = kind_of(path)
    if kind in SOURCES:
        identify(path, expected=set(FileKind) - SOURCES)
    if holds_taxels(path, kind, robots=spec.surface != "cover"):
        return _read_taxels((path,), spec)
    if kind is FileKind.MESH and spec.surface != "cover":
        check_home(spec.home, (), source=str(path))
        mesh, findings = read_mesh_in_metres(path, where=path.name)
        skin = skin_of_mesh(mesh, spec.placement, name=path.stem, surface=spec.surface, progress=progress)
        return replace(skin, findings=(*findings, *skin.findings))
    robot = load_robot(str(source), package_roots=spec.package_roots, home=spec.home)
    skin = cover_robot(robot, _cover_spec(spec), progress=progress)
    return replace(skin, findings=(*robot.findings, *skin.findings))


def _cover_spec(options: SkinOptions) -> CoverSpec:
    placement = options.placement
    if placement.keep_out or isinstance(placement.density, np.ndarray):
        raise SkinError(
            "a cover has no keep-out zones and no painted density",
            place="placement",
            remedy="Choose the surface of a bare mesh, or a margin of the cover",
        )
    return CoverSpec(
        options.links,
        placement.taxels or _DEFAULT_TAXELS,
        options.thickness,
        placement.seed,
        pitch=placement.pitch,
        pattern=placement.pattern,
        density=placement.density or "uniform",
        axes=placement.axes,
    )


def _merged_taxels(paths: Sequence[str | Path], options: SkinOptions) -> Skin:
    for path in paths:
        if not holds_taxels(path, kind_of(path)):
            raise SkinError("several files must all be of taxels", file=path, remedy="Open a robot or mesh alone")
    return _read_taxels(paths, options)


def _read_taxels(paths: Sequence[str | Path], options: SkinOptions) -> Skin:
    """Return the taxels of files, on the robot that carries them or joined to each other."""
    files = TaxelFiles(paths, package_roots=options.package_roots)
    name = options.robot or files.usual_carrier(options.links)
    if name == NO_ROBOT:
        check_home(options.home, (), source=str(paths[0]))
        return files.skin(links=options.links, thickness=options.thickness)
    robot = load_robot(name, package_roots=options.package_roots, home=options.home)
    skin = files.skin(robot, links=options.links, thickness=options.thickness)
    return replace(skin, findings=(*robot.findings, *skin.findings))
