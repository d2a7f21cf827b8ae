"""Scenes as TOML: reading, writing, and loading by name or file.

A written scene reads as an equal scene, so that recordings contain theirs. There are shipped scenes, files of the user,
and a default scene for any robot.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import SceneError, did_you_mean
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import read_bounded_file
from tactile_maps.core.toml import TomlReader, as_float, toml_lines
from tactile_maps.scene.motion import Waypoint
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene, Setting
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.skin.formats.identify import is_robot_with_taxels, kind_of
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.stimuli.stimulus_file import read_stimulus, stimulus_to_table
from tactile_maps.stimuli.stimulus_kinds import Stroke
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

_POINTS = ("path",)
"""Settings of the controller that are lists of points."""
_WORDS = ("name", "title", "description", "suggestion")
_TAXELS = "taxel_file"
"""Key of one file of taxels, or of a list of them."""
_PLAIN = (*_WORDS, "robot", "task", "outputs", "package_roots", _TAXELS, "repeat_stimuli", "tick", "seed")
_TABLES = (
    "home",
    "cover",
    "layer",
    "grids",
    "more_covers",
    "objects",
    "effects",
    "control",
    "contacts",
    "behaviours",
    "motion",
    "stimuli",
)


def scene_from_toml(text: str, *, name: str, file: str | None = None) -> Scene:
    """Read a scene.

    Args:
        text: TOML text.
        name: Name of the scene if the text does not state one.
        file: Source of the text, for messages.

    Raises:
        SceneError: The text is invalid; the message names line, key, value, possible values and the nearest spelling.
    """
    reader = TomlReader(text, file=file or name, top=_PLAIN)
    reader.check_keys(reader.raw, (*_PLAIN, *_TABLES), ())
    known = {key: value for key, value in reader.raw.items() if key not in (*_TABLES, _TAXELS)}
    values = reader.fields(Scene, {"name": name, **known}, ())
    values |= {
        "taxel_files": _taxel_files(reader),
        "home": reader.value(reader.table("home"), Mapping[str, float], ("home",)),
        "cover": reader.build(CoverSpec, reader.table("cover"), ("cover",)),
        "layer": reader.build(ElasticLayer, reader.table("layer"), ("layer",)),
        "grids": tuple(reader.build(GridSpec, *place) for place in reader.tables("grids")),
        "more_covers": tuple(reader.build(CoverSpec, *place) for place in reader.tables("more_covers")),
        "objects": tuple(reader.build(ObjectSpec, *place) for place in reader.tables("objects")),
        "overrides": reader.table("effects"),
        "control": _control(reader),
        "reading": _contacts(reader),
        "behaviours": tuple(table for table, _ in reader.tables("behaviours")),
        "motion": tuple(reader.build(Waypoint, *place) for place in reader.tables("motion")),
        "stimuli": tuple(read_stimulus(reader, *place) for place in reader.tables("stimuli")),
    }
    with reader.locating_errors(reader.raw, ()):
        return Scene(**values)


def _stated(spec: CoverSpec | GridSpec | ObjectSpec) -> dict[str, Any]:
    """Return the values of a table other than None, which TOML cannot state."""
    return {key: value for key, value in asdict(spec).items() if value is not None}


def scene_to_toml(scene: Scene) -> str:
    """Return the scene as text, which reads as an equal scene."""
    files = scene.taxel_files if len(scene.taxel_files) > 1 else "".join(scene.taxel_files)
    parts = [toml_lines({key: files if key == _TAXELS else getattr(scene, key) for key in _PLAIN})]
    tables: dict[str, Mapping[str, Any]] = {"home": scene.home} if scene.home else {}
    tables |= {"cover": _stated(scene.cover), "layer": asdict(scene.layer), "effects": scene.overrides}
    for key, table in (tables | {"control": scene.control, "contacts": scene.reading}).items():
        parts += [f"[{key}]", toml_lines(table)]
    lists = {
        "grids": map(_stated, scene.grids),
        "more_covers": map(_stated, scene.more_covers),
        "objects": map(_stated, scene.objects),
        "behaviours": scene.behaviours,
        "motion": map(asdict, scene.motion),
        "stimuli": map(stimulus_to_table, scene.stimuli),
    }
    for key, items in lists.items():
        for item in items:
            parts += [f"[[{key}]]", toml_lines(item)]
    return "\n".join(parts) + "\n"


def cover_to_toml(cover: CoverSpec) -> str:
    """Return a cover as text, which ``cover_from_toml`` reads as an equal cover."""
    return toml_lines(_stated(cover))


def cover_from_toml(text: str) -> CoverSpec:
    """Read a cover.

    Raises:
        SceneError: The text is invalid.
    """
    toml = TomlReader(text, file="cover", top=())
    return toml.build(CoverSpec, toml.raw, ())


def scene_in_folder(scene: Scene, folder: Path) -> Scene:
    """Return a scene to be written in ``folder``: files in it are named relative to it, others with their whole path.

    The folder can then be moved or copied, and a file named relative to the working directory is found from anywhere.
    """
    base = Path(os.path.abspath(folder))

    def named(file: str) -> str:
        if not file or not os.path.exists(file):
            return file
        path = Path(os.path.abspath(file))
        return path.relative_to(base).as_posix() if path.is_relative_to(base) else str(path)

    return replace(
        scene,
        robot=named(scene.robot) if Path(scene.robot).suffix else scene.robot,
        package_roots=tuple(map(named, scene.package_roots)),
        taxel_files=tuple(map(named, scene.taxel_files)),
        objects=tuple(replace(spec, file=named(spec.file)) for spec in scene.objects),
    )


def _taxel_files(table: TomlReader) -> tuple[str, ...]:
    files = table.value(table.raw.get(_TAXELS, ""), str | tuple[str, ...], (_TAXELS,))
    return tuple(file for file in ([files] if isinstance(files, str) else files) if file)


def _control(reader: TomlReader) -> dict[str, Setting]:
    """Return words, numbers (also infinity) and points; the controller checks the names."""
    result: dict[str, Setting] = {}
    for key, value in reader.table("control").items():
        if key in _POINTS:
            result[key] = reader.value(value, tuple[tuple[float, float], ...], ("control", key))
            continue
        number = as_float(value) if type(value) in (int, float) else math.nan
        if math.isnan(number) and not isinstance(value, str):
            problem = "a controller setting must be a number or a word"
            raise reader.error_at(problem, ("control", key), value=value)
        result[key] = value if isinstance(value, str | int) else number
    return result


def _contacts(reader: TomlReader) -> dict[str, str | float]:
    """Return words and numbers; the contact detection checks the names."""
    table = reader.table("contacts")
    for key, value in table.items():
        if type(value) not in (int, float, str):
            raise reader.error_at("this must be a number or a word", ("contacts", key), value=value)
    return table


MOST_BYTES = 1_000_000
"""Largest size of a scene file [bytes]."""


def scene_names() -> tuple[str, ...]:
    """Return the names of the shipped scenes."""
    return tuple(sorted(path.stem for path in asset("scenes").glob("*.toml")))


def _check_files(scene: Scene) -> None:
    """Raise an error if a file of taxels or of a mesh does not exist."""
    files = [(_TAXELS, file) for file in scene.taxel_files]
    files += [(f"objects.{number}.file", spec.file) for number, spec in enumerate(scene.objects)]
    for place, file in files:
        if file and not os.path.exists(file):
            remedy = "Name a file relative to the scene's folder"
            raise SceneError("there is no such file", place=place, value=file, remedy=remedy)


_OPTIONS = {
    FileKind.ROBOT: "with --robot",
    FileKind.ROBOT_WITH_TAXELS: "with --robot",
    FileKind.MESH: "with --robot",
    FileKind.TAXELS: "with --skin",
    FileKind.SKIN: "with --skin",
    FileKind.MAP: "with --skin",
    FileKind.RECORDING: "to the command replay",
    FileKind.READINGS: "to the command listen",
}
"""How a file that is mistaken for a scene is passed instead."""


def load_scene(name: str, *, check: Callable[[Scene], None] | None = None) -> Scene:
    """Load the scene of that name or file. In a file, robot, taxels and meshes may be named relative to its folder.

    Args:
        name: Name of a shipped scene, or a path.
        check: Further check, which raises errors whose place is a key; their line is added.

    Raises:
        SceneError: The scene does not exist or is invalid; the message names the line and the key.

    Example:
        >>> scene = tm.load_scene("slide")
        >>> scene.robot, scene.task
        ('arm', 'slide')
    """
    path = asset("scenes", f"{name}.toml") if name in scene_names() else Path(name)
    if not os.path.exists(path):
        remedy = f"{did_you_mean(name, scene_names())}, or give the path of a file"
        raise SceneError("unknown scene", value=name, remedy=remedy)
    kind = kind_of(path)
    if kind in _OPTIONS:
        problem = f"this is a {kind.value}, not a scene"
        raise SceneError(problem, file=path, remedy=f"Give a scene file (.toml), or this file {_OPTIONS[kind]}")
    try:
        text = read_bounded_file(path, error=SceneError, most=MOST_BYTES).decode("utf8")
    except UnicodeDecodeError as error:
        raise SceneError("the scene cannot be read", file=path, value=error, remedy="Save it as UTF-8") from error
    scene = scene_from_toml(text, name=path.stem, file=str(path))
    scene = replace(
        scene,
        robot=_in_folder(path, scene.robot),
        package_roots=tuple(str(path.parent / root) for root in scene.package_roots),
        taxel_files=tuple(_in_folder(path, file, folders=True) for file in scene.taxel_files),
        objects=tuple(replace(spec, file=_in_folder(path, spec.file)) for spec in scene.objects),
    )
    reader = TomlReader(text, file=str(path))
    with reader.locating_errors(reader.raw, ()):
        _check_files(scene)
        if check is not None:
            check(scene)
    return scene


def scene_for(robot: str) -> Scene:
    """Return the scene for a robot's name or file: the shipped one of that name, or one with a cover and a stroke.

    A URDF file that states taxels has these instead of a cover; one with taxels but without shapes is a taxel file. The
    touch sensors of an MJCF model are often only a few, so they are used only on request (``scene_for_taxels``).
    """
    if robot in scene_names():
        return load_scene(robot)
    path = Path(robot)
    kind = kind_of(path) if path.suffix.lower() in FileKind.ROBOT.suffixes else None
    if kind is FileKind.TAXELS:
        return scene_for_taxels(robot)
    own = (robot,) if kind is FileKind.ROBOT_WITH_TAXELS else ()
    return Scene(name=path.stem or robot, robot=robot, title=path.name, taxel_files=own, stimuli=(Stroke(),))


def scene_for_taxels(*paths: str) -> Scene:
    """Return the scene for files of taxels: on their own robot, on iCub for iCub positions, or without robot.

    Raises:
        SkinError: The files are of different robots.
    """
    robot = next((path for path in paths if is_robot_with_taxels(path, kind_of(path))), None)
    if robot is None:
        return with_taxels(scene_for(TaxelFiles(paths).usual_carrier()), paths)
    scene = scene_for(robot)
    return scene if scene.taxel_files == paths else with_taxels(scene, paths)


def file_names(paths: Sequence[str]) -> str:
    """Return the names of files as words: ``a.csv and b.csv``, or ``a.csv and 3 more``."""
    first, *others = [Path(path).name for path in paths]
    if not others:
        return first
    return f"{first} and {others[0] if len(others) == 1 else f'{len(others)} more'}"


def _on_first_patch(scene: Scene) -> tuple[Stimulus, ...]:
    """Return the first stimulus, if there is one, on the first patch of any skin."""
    return tuple(replace(stimulus, patch="") for stimulus in scene.stimuli[:1])


def with_taxels(scene: Scene, paths: Sequence[str], *, links: tuple[str, ...] = ()) -> Scene:
    """Return the scene with the taxels of files; the scripted finger touches the first patch.

    Args:
        scene: The scene.
        paths: The files.
        links: The links of the files that do not name theirs.
    """
    paths = tuple(paths)
    stimuli = _on_first_patch(scene)
    alone = scene.robot == NO_ROBOT
    title = scene.title
    if alone:
        title = file_names(paths)
    elif paths == (scene.robot,):
        title = f"{file_names(paths)} with its own taxels"
    elif paths != scene.taxel_files:
        before = f" with {file_names(scene.taxel_files)}" if scene.taxel_files else ""
        title = f"{title.removesuffix(before)} with {file_names(paths)}"
    name = Path(paths[0]).stem if alone else scene.name
    cover = replace(scene.cover, links=links)
    return replace(scene, name=name, title=title, taxel_files=paths, cover=cover, stimuli=stimuli)


def with_grid(scene: Scene, grid: GridSpec, covered: Sequence[str]) -> Scene:
    """Return the scene with an additional grid, which replaces the cover of its link; other links keep their skin.

    Args:
        scene: The scene.
        grid: The grid.
        covered: The links that have skin.
    """
    if not scene.taxel_files:
        scene = without_cover(scene, grid.link, covered)
    stimuli = _on_first_patch(scene)
    return replace(scene, grids=(*scene.grids, grid), stimuli=stimuli)


def with_link(scene: Scene, cover: CoverSpec) -> Scene:
    """Return the scene with one more link covered; all other links keep their skin.

    A link whose cover was removed gets it again.

    Args:
        scene: The scene.
        cover: Cover of the link, which has no skin yet.
    """
    (link,) = cover.links
    covers = (scene.cover, *scene.more_covers)
    if any(link in one.bare for one in covers):
        first, *more = (replace(one, bare=tuple(name for name in one.bare if name != link)) for one in covers)
        return replace(scene, cover=first, more_covers=tuple(more))
    return replace(scene, more_covers=(*scene.more_covers, cover))


def without_link(scene: Scene, link: str, covered: Sequence[str]) -> Scene:
    """Return the scene without skin on a link; all other links keep theirs. Stimuli on the link are removed.

    Args:
        scene: The scene.
        link: The link.
        covered: The links that have skin.
    """
    left = without_cover(scene, link, covered)
    grids = tuple(grid for grid in scene.grids if grid.link != link)
    stimuli = [one for one in scene.stimuli if one.patch != link and not one.patch.startswith(f"{link} ")]
    return replace(left, grids=grids, stimuli=_or_first(scene, stimuli))


def without_cover(scene: Scene, link: str, covered: Sequence[str]) -> Scene:
    """Return the scene without a cover on a link, but with its grids; arguments as for ``without_link``."""
    covers = [_explicit_cover(scene, covered), *scene.more_covers]
    left = [_with_bare(cover, link) for cover in covers]
    kept = [cover for cover in left if not cover.links or set(cover.links) > set(cover.bare)]
    first, *more = kept or [replace(scene.cover, links=(), bare=())]
    return replace(scene, cover=first, more_covers=tuple(more))


def _explicit_cover(scene: Scene, covered: Sequence[str]) -> CoverSpec:
    """Return the first cover of a scene with its links named."""
    if scene.cover.links or scene.grids:
        return scene.cover
    others = {link for cover in scene.more_covers for link in cover.links}
    links = (*(link for link in dict.fromkeys(covered) if link not in others), *scene.cover.bare)
    return replace(scene.cover, links=links)


def _with_bare(cover: CoverSpec, link: str) -> CoverSpec:
    bare = link in cover.links and link not in cover.bare
    return replace(cover, bare=(*cover.bare, link)) if bare else cover


def _or_first(scene: Scene, stimuli: Sequence[Stimulus]) -> tuple[Stimulus, ...]:
    """Return the stimuli; without any, the first one of the scene, on the first patch."""
    return tuple(stimuli) or tuple(replace(one, patch="") for one in scene.stimuli[:1])


def with_cover(scene: Scene, cover: CoverSpec) -> Scene:
    """Return the scene with skin on the links of a cover and on no others; the cover replaces taxel files.

    Grids on these links stay, and the cover is on the other ones, instead of all covers. Stimuli on links that still
    have skin stay; without any, the first stimulus touches the first patch.

    Args:
        scene: The scene.
        cover: Cover with at least one named link.
    """
    grids = tuple(grid for grid in scene.grids if grid.link in cover.links)
    covered = tuple(link for link in cover.links if all(grid.link != link for grid in grids))
    return replace(
        scene,
        taxel_files=(),
        cover=replace(cover, links=covered),
        grids=grids,
        more_covers=(),
        stimuli=_or_first(scene, [one for one in scene.stimuli if not one.patch or one.patch in covered]),
    )


def _in_folder(scene: Path, value: str, *, folders: bool = False) -> str:
    """Return the path of a file in the scene's folder; any other value unchanged."""
    path = scene.parent / value
    return str(path) if value and (os.path.isfile(path) or (folders and os.path.isdir(path))) else value
