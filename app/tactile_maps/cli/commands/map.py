"""``map``: make a tactile map from any input, write it, and report its quality.

With ``--learn`` the map is learned from touch: from random touches, or from the readings of a recording.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactile_maps.cli.shared.findings import model_notes_text, without_model_notes
from tactile_maps.cli.shared.map_quality import number_text, quality_fields
from tactile_maps.cli.shared.output import print_fields, print_json, print_line, progress_line
from tactile_maps.cli.shared.robot_options import home_of, package_roots
from tactile_maps.cli.shared.unused_options import PLACEMENT, refuse_with_input
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, MapError, RecordingError, UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.progress import Progress
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import TaxelLayout, compare_maps, drawn_layout
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_maps.maps.formats.export import SENSORS_ENDING, TITLES, unknown_format, write_map
from tactile_maps.maps.formats.map_file import load_map
from tactile_maps.maps.formats.obj import read_map_obj
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.load import MESH_LINK
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.skin.formats.icub.layout import apply_layout, read_icub_layout
from tactile_maps.skin.formats.icub.module_orientation import propose_orientations
from tactile_maps.skin.formats.identify import holds_taxels, is_robot_with_taxels, kind_of
from tactile_maps.skin.formats.mujoco_touch import mesh_folder, write_touch_sensors
from tactile_maps.skin.formats.taxel_files import read_taxels
from tactile_maps.skin.model.skin import Skin, identity_summary, identity_text
from tactile_maps.skin.model.taxel_axes import axes_summary, axes_text
from tactile_maps.skin.open import SkinOptions, open_skin
from tactile_maps.skin.taxel_placement.placement import BoundaryZone, PlacementSpec

if TYPE_CHECKING:
    from tactile_maps.recording.player import RecordingPlayer


def recorded_touch(path: str | Path) -> tuple[Skin, FloatArray]:
    """Return the skin of a recording and the readings of its taxels (frames, taxels) [Pa].

    Raises:
        RecordingError: It cannot be read, or it contains no contact.
    """
    player = _recording(path)
    readings = np.stack([player.frame(number).pressures for number in range(len(player))])
    if not readings.any():
        raise RecordingError("the recording contains no contact", file=path, remedy="Record strokes over the skin")
    return player.prepared.skin, readings


def _recording(path: str | Path) -> RecordingPlayer:
    from tactile_maps.recording.player import RecordingPlayer  # 0.2 s: it can simulate

    return RecordingPlayer(path)


def learned_map(arguments: argparse.Namespace, skin: Skin, readings: FloatArray | None, report: Progress) -> TactileMap:
    """Return the map of ``skin`` by the requested method, from ``readings`` or from random touches.

    Raises:
        UsageError: The method is unknown.
    """
    from tactile_maps.maps.learned.as_tactile_map import learned_tactile_map
    from tactile_maps.maps.learned.methods import LEARNING_METHODS
    from tactile_maps.tactile.babbling import BabbleSpec, babble  # 0.1 s, rarely needed

    if arguments.learn not in LEARNING_METHODS:
        remedy = f"Choose one of: {', '.join(LEARNING_METHODS)}"
        raise UsageError("unknown learning method", place="--learn", value=arguments.learn, remedy=remedy)
    if readings is None:
        report("Babbling", 0.0)
        strokes = arguments.learn in ("temporal-correlation", "human-touch")
        spec = BabbleSpec(
            arguments.babble,
            arguments.touches,
            samples=8 if strokes else 1,
            rest=2 if strokes else 0,
            seed=arguments.seed,
        )
        readings = babble(skin, spec)
    learned = LEARNING_METHODS[arguments.learn](readings, seed=arguments.seed, progress=report)
    return learned_tactile_map(skin, learned)


def print_quality(result: Mapping[str, Any], *, source: str) -> None:
    """Print the result of ``map``: main figures first, then findings and, with ``--compare``, the comparison.

    Args:
        result: The result.
        source: File or name of the robot, for the line about the notes on its model.
    """
    print_fields(
        {
            "Patches": result["patches"],
            "Taxels": result["taxels"],
            "Coverage": f"{100 * result['coverage']:.1f} % of the requested surface",
            "Identity": identity_text(result.get("identity", {})) or "none stated",
            "Axes": axes_text(result.get("axes", {}), result["taxels"]) or "1",
            **quality_fields(result),
            "Time": f"{result['seconds']:.2f} s",
            "Written to": result["file"] or "nothing",
        }
    )
    findings = [Finding(**finding) for finding in result["findings"]]
    for finding in without_model_notes(findings):
        print_fields({f"  {finding.kind} ({finding.count}) {finding.where}": finding.action})
    notes = model_notes_text(findings, source)
    if notes:
        print_line(f"  {notes}")
    if "comparison" in result:
        _print_comparison(result["comparison"])


def _print_comparison(comparison: Mapping[str, Any]) -> None:
    print_line("")
    print_line(f"{'':<34}{'this map':>12}{'the other':>12}")
    marks = {"first": "  this is better", "second": "  the other is better", "neither": ""}
    for row in comparison["measures"]:
        name = row["name"].replace("_", " ")
        print_line(f"{name:<34}{number_text(row['first']):>12}{number_text(row['second']):>12}{marks[row['better']]}")
    print_line(f"{'taxels apart at best fit, rms':<34}{number_text(comparison['procrustes_mm']):>12} mm")
    for finding in comparison["findings"]:
        print_line(f"  {finding['kind']} ({finding['count']}) {finding['where']}: {finding['action']}")


def execute(arguments: argparse.Namespace) -> int:
    """Make the map, write it on request, and report its quality."""
    target = _output_path(arguments)
    if arguments.method not in METHODS:
        raise UsageError(
            "unknown method", place="--method", value=arguments.method, remedy=METHODS.remedy(arguments.method)
        )
    _refuse_unused(arguments)
    report = progress_line()
    start = time.perf_counter()
    skin, map_ = _make_map(arguments, report)
    seconds = time.perf_counter() - start
    body = BodyDistances(skin, sources=arguments.exact_distances)
    result = measure(map_, distances=body).to_json() | {"identity": identity_summary(skin.identity)}
    result |= {
        "axes": axes_summary(skin.axes, skin.tangents, len(skin)),
        "seconds": seconds,
        "file": str(target) if target else None,
    }
    if arguments.compare:
        result["comparison"] = _comparison(arguments, map_, body)
    if target is not None:
        _write(map_, target, arguments)
    if arguments.json:
        print_json(result)
    else:
        print_quality(result, source=arguments.robot or arguments.input)
    return 0


def _refuse_unused(arguments: argparse.Namespace) -> None:
    """Refuse options that have no effect with the method, the compared file or the input; raises UsageError."""
    refuse = partial(refuse_with_input, arguments)
    if not METHODS[arguments.method].slides:
        sliding = ", ".join(name for name, method in METHODS.items() if method.slides)
        refuse(["--lengths"], "method", arguments.method, purpose=f"It is for {sliding}")
    if arguments.compare and Path(arguments.compare).suffix.lower() != ".ini":
        refuse(["--fix-modules"], "file", arguments.compare, purpose="It corrects the modules of a layout (.ini)")
    if not arguments.grid:
        _refuse_with_skin(arguments, Path(arguments.input))


def _refuse_with_skin(arguments: argparse.Namespace, path: Path) -> None:
    """Refuse options that have no effect with the skin or mesh at ``path``; raises UsageError."""
    refuse = partial(refuse_with_input, arguments, noun="input", value=path)
    kind = kind_of(path)
    covered = arguments.surface == "cover"
    surfaces = "It is for meshes, and for robots that state taxels"
    if kind is FileKind.RECORDING:
        refuse(["--babble", "--touches"], purpose="A recording has its own touches")
        refuse([*PLACEMENT, "--surface", "--links", "--robot", "--home"], purpose="A recording has its own skin")
    elif holds_taxels(path, kind, robots=not covered):
        refuse(PLACEMENT, purpose="It places taxels, and this file states them")
        if not is_robot_with_taxels(path, kind):
            refuse(["--surface"], purpose=surfaces)
        if kind in (FileKind.SKIN, FileKind.MAP):
            refuse(["--links"], purpose="It chooses links, and a skin is used whole")
    else:
        refuse(["--robot"], purpose="It names the robot that carries taxels, or none, and this file has no taxels")
        if not covered and kind is FileKind.MESH:
            refuse(["--links"], purpose="It chooses links of a robot, and a mesh has none")
        elif not covered:
            refuse(["--surface"], purpose=surfaces)


def _write(map_: TactileMap, target: Path, arguments: argparse.Namespace) -> None:
    """Write the map in the format of the extension; a model with touch sensors also needs the robot."""
    if target.suffix.lower() != SENSORS_ENDING:
        write_map(map_, target)
    elif kind_of(arguments.input) is FileKind.RECORDING:
        robot = _recording(arguments.input).prepared.robot
        write_touch_sensors(map_.skin, robot, target, frames=taxel_frames(map_))
    else:
        roots = package_roots(arguments)
        robot = load_robot(arguments.robot or arguments.input, package_roots=roots, home=home_of(arguments))
        write_touch_sensors(map_.skin, robot, target, frames=taxel_frames(map_))


def _make_map(arguments: argparse.Namespace, report: Progress) -> tuple[Skin, TactileMap]:
    """Skin and map."""
    recorded = kind_of(arguments.input) is FileKind.RECORDING
    skin, readings = recorded_touch(arguments.input) if recorded else (None, None)
    if skin is None:
        skin = open_skin(arguments.input, _skin_options(arguments), progress=report)
    if arguments.learn:
        return skin, learned_map(arguments, skin, readings, report)
    return skin, _flattened_map(arguments, skin, report)


def _output_path(arguments: argparse.Namespace) -> Path | None:
    """Output path; invalid ones are refused before any work."""
    if not arguments.output:
        return None
    target = Path(arguments.output)
    if target.suffix.lower() not in TITLES:
        raise unknown_format(target, TITLES, UsageError)
    if target.suffix.lower() == SENSORS_ENDING and not arguments.overwrite and mesh_folder(target).exists():
        problem = "the folder for the model's meshes exists"
        remedy = "Choose another name, or add --overwrite"
        raise MapError(problem, file=mesh_folder(target), remedy=remedy)
    return target


def _skin_options(arguments: argparse.Namespace) -> SkinOptions:
    if arguments.grid:
        links = tuple(arguments.links)
        roots = package_roots(arguments)
        return SkinOptions(links=links, grid=_grid(arguments), package_roots=roots, home=home_of(arguments))
    if arguments.first or arguments.last:
        raise UsageError("a corner without a grid", remedy="Add --grid ROWSxCOLUMNS")
    if arguments.mirrored is not None:
        raise UsageError("--mirrored without a grid", remedy="Add --grid ROWSxCOLUMNS")
    zones = () if arguments.keep_border is None else (BoundaryZone(1e-3 * arguments.keep_border),)
    taxels = None if arguments.pitch is not None or arguments.pattern == "modules" else arguments.taxels
    pitch = None if arguments.pitch is None else 1e-3 * arguments.pitch
    placement = PlacementSpec(
        pitch, taxels, arguments.pattern, arguments.density, zones, arguments.seed, arguments.axes
    )
    return SkinOptions(
        placement,
        tuple(arguments.links),
        arguments.robot,
        arguments.surface,
        package_roots=package_roots(arguments),
        home=home_of(arguments),
    )


def _grid(arguments: argparse.Namespace) -> GridSpec:
    """The requested grid.

    Raises:
        UsageError: A corner is missing, or there are several links.
    """
    if not (arguments.first and arguments.last):
        raise UsageError("a grid needs two opposite corners", remedy="Add --from X,Y,Z and --to X,Y,Z [mm]")
    if len(arguments.links) > 1:
        raise UsageError(
            "a grid requires a single link", value=", ".join(arguments.links), remedy="Name one as --links"
        )
    link = arguments.links[0] if arguments.links else MESH_LINK
    rows, columns = arguments.grid
    return GridSpec(
        link, rows, columns, arguments.first, arguments.last, mirrored=arguments.mirrored, axes=arguments.axes
    )


def _flattened_map(arguments: argparse.Namespace, skin: Skin, report: Progress) -> TactileMap:
    """Flattened map, or the map of an unwrapped OBJ."""
    if arguments.uv:
        return read_map_obj(arguments.uv, skin)
    plan = None if arguments.seams is None else SeamPlan(extra=arguments.seams)
    seams = {patch.name: plan for patch in skin.patches} if plan else None
    return build_map(skin, method=arguments.method, lengths=arguments.lengths, seams=seams, progress=report)


def _comparison(arguments: argparse.Namespace, map_: TactileMap, body: BodyDistances) -> dict[str, Any]:
    """Comparison of the map with another of the same skin or with a drawn layout, and problems of its modules."""
    path = Path(arguments.compare)
    findings = list[Finding]()
    other: TactileMap | TaxelLayout
    if path.suffix.lower() == ".npz":
        other = load_map(path)
    elif path.suffix.lower() == ".ini":
        taxels = read_taxels(arguments.input)
        layout = read_icub_layout(path)
        candidates = propose_orientations(taxels, layout, seed=arguments.seed)
        findings += [found] if (found := candidates.finding(path.name)) else []
        other = drawn_layout(
            apply_layout(taxels, candidates.apply(layout) if arguments.fix_modules else layout), map_.skin
        )
    else:
        other = drawn_layout(read_taxels(path), map_.skin)
    result = compare_maps(map_, other, distances=body).to_json()
    return result | {"findings": [vars(finding) for finding in findings]}
