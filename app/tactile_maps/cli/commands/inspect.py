"""``inspect``: content and problems of a robot, skin, map, scene or recording; and the plug-ins."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from tactile_maps.cli.shared.map_quality import quality_fields
from tactile_maps.cli.shared.output import plain_text, print_fields, print_json, print_line, progress_line
from tactile_maps.cli.shared.robot_options import home_of, package_roots
from tactile_maps.cli.shared.unused_options import refuse_with_input
from tactile_maps.core.errors import Finding, MeshError, RecordingError, SkinError, UsageError, counted
from tactile_maps.core.file_kinds import SOURCES, FileKind
from tactile_maps.core.plugins import Plugin, Registry, unknown_kinds
from tactile_maps.maps.formats.map_file import load_map
from tactile_maps.recording.file.damage import DamageKind
from tactile_maps.robots.files.mesh_files import read_mesh_in_metres
from tactile_maps.robots.formats.touch_sensors import read_touch_sensors
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.robot import Robot
from tactile_maps.robots.workspace import inertia_ratio, reach
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import scene_names
from tactile_maps.session.prepare import PreparedScene, check_stimuli, open_scene, pad_findings
from tactile_maps.session.prepared_cache import load_robot_cached, prepare_cached
from tactile_maps.skin.controllable import controllable_share
from tactile_maps.skin.formats.icub.layout import read_icub_layout
from tactile_maps.skin.formats.identify import identify, is_robot_with_taxels, kind_of
from tactile_maps.skin.formats.import_skin import TaxelFile
from tactile_maps.skin.formats.vendors.mapping_file import mapping_template
from tactile_maps.skin.link_pieces import collision_finding, hull_fit, link_pieces, pieces_fit
from tactile_maps.skin.mesh_skin import findings_of_mesh
from tactile_maps.skin.model.skin import Skin, identity_summary, identity_text, join_identities
from tactile_maps.skin.model.skin_file import load_skin
from tactile_maps.skin.model.taxel_axes import axes_summary, axes_text

REGISTRIES: Mapping[str, tuple[str, str]] = {
    "contact_models": ("tactile_maps.tactile.models.contact_model", "CONTACT_MODELS"),
    "map_methods": ("tactile_maps.flattening.methods", "METHODS"),
    "sensor_stages": ("tactile_maps.tactile.sensors.sensor_chain", "SENSOR_STAGES"),
    "controllers": ("tactile_maps.control.controller_registry", "CONTROLLERS"),
    "estimators": ("tactile_maps.contacts.force_estimation.estimation", "FORCE_ESTIMATORS"),
    "importers": ("tactile_maps.skin.formats.taxel_files", "TAXEL_FORMATS"),
    "exporters": ("tactile_maps.export.export", "FORMATS"),
    "sources": ("tactile_maps.live.sources.open", "SOURCE_KINDS"),
}
"""Module and name of the registry of each kind; imported when needed."""


def execute(arguments: argparse.Namespace) -> int:
    """Identify and describe the input."""
    if arguments.plugins == (arguments.input is not None):
        raise UsageError("nothing to inspect", remedy="Give one file or name, or --plugins alone")
    if arguments.costs and not _is_scene(arguments.input):
        purpose = "It measures the effects of a scene"
        refuse_with_input(arguments, ["--costs"], "input", arguments.input, purpose=purpose)
    if arguments.mapping:
        print_line(mapping_template(Path(arguments.input)).rstrip())
        return 0
    if arguments.plugins:
        return _list_plugins(as_json=arguments.json)
    home = home_of(arguments)
    found = describe(arguments.input, package_roots=package_roots(arguments), costs=arguments.costs, home=home)
    if "limits" not in found:
        refuse_with_input(arguments, ["--home"], "input", arguments.input, purpose="It is for robots and scenes")
    apart = ("effects", "problems", "identity", "axes", "coverage", "collision", "limits", "controllable", "quality")
    plain = {key.capitalize(): _text(value) for key, value in found.items() if key not in apart and value is not None}
    if found.get("reach") is not None:
        plain["Reach"] = f"{found['reach']:.3f} m from the first joint"
    if found.get("inertia_ratio") is not None:
        plain["Inertia ratio"] = f"{found['inertia_ratio']:.3g} (largest to smallest joint inertia at home)"
    plain.pop("Inertia_ratio", None)
    plain["Identity"] = identity_text(found.get("identity", {}))
    if "axes" in found:
        plain["Axes"] = axes_text(found["axes"], found["taxels"])
    if "coverage" in found:
        plain["Coverage"] = f"{100 * found['coverage']:.1f} % of the requested surface"
    if "quality" in found:
        plain |= quality_fields(found["quality"])
    if "controllable" in found:
        plain["Force control"] = _controllable_text(found["controllable"])
    if arguments.report:
        from tactile_maps.cli.shared.pages import write_fact_page

        tables = {
            "Effects": found.get("effects", ()),
            "Collision": found.get("collision", ()),
            "Limits of the joints": found.get("limits", ()),
            "Problems": found["problems"],
        }
        write_fact_page(arguments.report, arguments.input, plain, tables=tables)
    if arguments.json:
        print_json(found)
        return 0
    print_fields({key: value for key, value in plain.items() if value})
    _print_effects(found.get("effects", ()))
    _print_collision(found.get("collision", ()))
    _print_limits(found.get("limits", ()))
    if "effects" in found and not arguments.costs:
        print_line("Add --costs to measure the cost of each effect.")
    for problem in found["problems"]:
        print_line(f"  {problem['kind']} ({problem['count']}) {problem['where']}: {problem['remedy']}")
    if arguments.report:
        print_line(f"Written to {arguments.report}")
    return 0


def _print_effects(effects: Sequence[dict[str, Any]]) -> None:
    """Print active effects with cost and reason, then inactive ones, one a line."""
    for word, on in (("On", True), ("Off", False)):
        rows = [row for row in effects if row["on"] == on]
        if rows:
            print_line(f"{word}:")
        for row in rows:
            cost = f"{row['ms']:8.3f} ms" if row["ms"] is not None else " " * 11
            value = row["value"] if row["value"] not in ("on", "off") else ""
            print_line(f"  {row['title']:<24}{value:<14}{cost}  {row['why']}")


def _print_collision(rows: Sequence[dict[str, Any]]) -> None:
    """Print the collision shape of each link with skin and its distance from the skin."""
    if rows:
        print_line(
            "Links with skin collide as (above the skin: largest, 95 % of area, angle; above bare parts next to it):"
        )
    for row in rows:
        distances = f"{row['largest_mm']:8.2f} mm {row['usual_mm']:7.2f} mm {row['angle_deg']:5.1f} deg"
        print_line(f"  {row['link']:<24}{row['shape']:<14}{distances} {row['bare_mm']:7.2f} mm")


def _controllable_text(links: Mapping[str, float]) -> str:
    """Return the shares of the links on which force can be controlled, and the condition."""
    shares = ", ".join(f"{100 * share:.0f} % of {link}" for link, share in links.items())
    return f"{shares} at home (motion of the joints at more than 15 degrees to the skin)"


def _print_limits(rows: Sequence[dict[str, Any]]) -> None:
    """Print the limits of each joint; a dash where the model has no limit."""
    if rows:
        print_line("Joints (home; range; speed and effort that the model allows):")
    for row in rows:
        angle, effort = ("m", "N") if row["slide"] else ("rad", "N m")
        ends = " to ".join(_limit(row[key]) for key in ("lower", "upper"))
        drive = f"{_limit(row['max_speed']):>8} {angle + '/s':<6}{_limit(row['max_effort']):>8} {effort}"
        print_line(f"  {row['joint']:<24}{row['home']:8.3f} {angle:<4}{ends:<18}{drive}")


def _limit(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "-"


def describe(
    name: str, *, package_roots: Sequence[str] = (), costs: bool = False, home: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """Describe the file or the scene or robot called ``name``; names of scenes come before names of robots.

    Args:
        name: A file, or the name of a scene or robot.
        package_roots: Folders with packages or meshes.
        costs: Measure the cost of each effect of a scene, which takes one to two seconds.
        home: Joint positions of the home posture by joint name [rad, m], instead of those of the scene or robot.

    Raises:
        TactileMapsError: The name is unknown, or the file cannot be read.
    """
    kind = kind_of(name)
    if kind is FileKind.ROBOT_WITH_TAXELS:
        return _robot_with_taxels(name, home)
    if kind is FileKind.ROBOT and is_robot_with_taxels(name, kind):
        return _robot_with_touch_sensors(name, package_roots, home)
    if kind in SOURCES:
        identify(name, expected=set(FileKind) - SOURCES)
    if kind is not None and kind in _DESCRIBERS:
        return _DESCRIBERS[kind](name)
    if _is_scene(name):
        scene = open_scene(name, package_roots=package_roots, load=load_robot_cached)
        return _scene(replace(scene, home={**scene.home, **(home or {})}), name, costs=costs)
    robot = _robot(load_robot(name, package_roots=package_roots, home=home))
    if kind is FileKind.MESH:
        robot["problems"] = _mesh_problems(name, robot["problems"])
    return {"kind": "robot", **robot}


def _mesh_problems(name: str, of_robot: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Problems of a bare mesh: those of its robot, and those that ``map`` notices before it places taxels."""
    path = Path(name)
    try:
        mesh, findings = read_mesh_in_metres(path, where=path.name)
        problems = _problems((*findings, *findings_of_mesh(mesh, name=path.stem)))
    except (MeshError, SkinError) as error:
        problems = [{"kind": "no-taxels", "where": error.problem, "remedy": error.remedy or "", "count": 1}]
    found = {problem["kind"] for problem in problems}
    return [*(problem for problem in of_robot if problem["kind"] not in found), *problems]


def _is_scene(name: str) -> bool:
    return kind_of(name) is FileKind.SCENE or name in scene_names()


def _robot_with_taxels(name: str, home: Mapping[str, float] | None) -> dict[str, Any]:
    """Description of a robot file that contains taxels: robot and taxels."""
    robot = _robot(load_robot(name, home=home))
    taxels = _taxel_file(name)
    found = {"kind": "robot with taxels", **robot, **{key: taxels[key] for key in ("taxels", "identity", "axes")}}
    return found | {"taxel_links": taxels["links"], "problems": robot["problems"] + taxels["problems"]}


def _robot_with_touch_sensors(
    name: str, package_roots: Sequence[str], home: Mapping[str, float] | None
) -> dict[str, Any]:
    """Description of an MJCF model with touch sensors: robot and sensors."""
    robot = load_robot(name, package_roots=package_roots, home=home)
    sensors, findings = read_touch_sensors(Path(name), package_roots=[Path(root) for root in package_roots])
    found = {"kind": "robot with taxels", **_robot(robot), "taxels": sum(len(sensor.origins) for sensor in sensors)}
    found |= {"taxel_links": list(dict.fromkeys(sensor.link for sensor in sensors))}
    return found | {
        "touch_sensors": [sensor.name for sensor in sensors],
        "problems": found["problems"] + _problems(findings),
    }


def _robot(robot: Robot) -> dict[str, Any]:
    return {
        "name": robot.name,
        "source": robot.source,
        "links": list(robot.link_index),
        "joints": list(robot.joint_names),
        "bodies": len(robot.links),
        "reach": reach(robot),
        "inertia_ratio": inertia_ratio(robot),
        "limits": [
            {
                "joint": joint.name,
                "slide": joint.slide,
                "home": float(home),
                "lower": joint.lower,
                "upper": joint.upper,
                "max_speed": joint.max_speed,
                "max_effort": joint.max_effort,
            }
            for joint, home in zip(robot.joints, robot.home, strict=True)
        ],
        "problems": _problems(robot.findings),
    }


def _skin(skin: Skin) -> dict[str, Any]:
    return {
        "taxels": len(skin),
        "patches": [
            {"name": patch.name, "link": patch.link, "taxels": len(patch.taxels), "cm2": 1e4 * patch.surface.area}
            for patch in skin.patches
        ],
        "coverage": skin.coverage,
        "identity": identity_summary(skin.identity),
        "axes": axes_summary(skin.axes, skin.tangents, len(skin)),
    }


def _scene(scene: Scene, name: str, *, costs: bool) -> dict[str, Any]:
    prepared = prepare_cached(scene, progress=progress_line())
    check_stimuli(prepared, name)
    measured = _costs(prepared) if costs else {}
    effects = [{**vars(row), "ms": measured.get(row.name)} for row in scene.decision.rows]
    bodies = (finding for body in prepared.objects for finding in body.findings)
    collision, shapes = _collision(prepared)
    problems = (
        *scene.decision.warnings,
        *prepared.robot.findings,
        *prepared.skin.findings,
        *bodies,
        *shapes,
        *pad_findings(prepared),
    )
    return {
        "kind": "scene",
        **_robot(prepared.robot),
        "name": scene.name,
        "title": scene.title,
        "robot": scene.robot,
        "task": scene.task,
        "outputs": list(scene.effective_outputs),
        **_skin(prepared.skin),
        "objects": [
            {"name": spec.name, "kind": spec.kind, "mass": spec.mass, "at": list(spec.at)} for spec in scene.objects
        ],
        "effects": effects,
        "collision": collision,
        "controllable": controllable_share(prepared.robot, prepared.skin),
        "problems": _problems(problems),
    }


def _collision(prepared: PreparedScene) -> tuple[list[dict[str, Any]], list[Finding]]:
    """Return a row for each link with skin, and findings about its shape.

    Pieces are made only where the effects let something touch the link.
    """
    from tactile_maps.simulation.model.contact_pairs import collides_by_shapes  # loads MuJoCo

    robot = prepared.robot
    skin = prepared.skin
    rows: list[dict[str, Any]] = []
    findings: list[Finding] = []
    touched = collides_by_shapes(prepared.scene.objects, prepared.scene.effects)
    for link in skin.links:
        pieces = link_pieces(robot, skin, link) if touched else None
        fit = hull_fit(robot, skin, link) if pieces is None else pieces_fit(pieces, robot, skin, link)
        if (finding := collision_finding(robot, link, fit, pieces)) is not None:
            findings.append(finding)
        rows.append(
            {
                "link": link,
                "shape": "hull" if pieces is None else counted(len(pieces.hulls), "piece"),
                "largest_mm": 1e3 * fit.largest,
                "usual_mm": 1e3 * fit.usual,
                "angle_deg": math.degrees(fit.angle),
                "bare_mm": 1e3 * fit.bare,
            }
        )
    return rows, findings


def _costs(prepared: PreparedScene) -> Mapping[str, float]:
    from tactile_maps.studies.ablation import ablation_cost  # 0.1 s: it simulates

    return ablation_cost(prepared)


def _recording(name: str) -> dict[str, Any]:
    from tactile_maps.recording.player import RecordingPlayer  # 0.1 s: it can simulate

    player = RecordingPlayer(name)
    problems = [
        {
            "kind": damage.kind.value,
            "where": text,
            "remedy": "Inspect it again when the recording has ended"
            if damage.kind == DamageKind.BEING_RECORDED
            else f"tactile-maps recover {name} -o recovered.mcap saves the intact part",
            "count": damage.count or 1,
        }
        for damage, text in zip(player.damage, player.damage_texts, strict=True)
    ]
    try:
        notes = player.annotations()
    except RecordingError as error:
        notes = player.recorded_annotations
        problems.append({"kind": "notes", "where": str(error), "remedy": error.remedy or "", "count": 1})
    return {
        "kind": "recording",
        "name": player.prepared.scene.name,
        "robot": player.prepared.robot.name,
        "links": list(player.prepared.robot.link_index),
        "joints": list(player.prepared.robot.joint_names),
        **_skin(player.prepared.skin),
        "frames": len(player),
        "complete": player.complete,
        "seconds": player.duration,
        "inputs": len(player.inputs),
        "marks": [f"{mark.name} at {player.seconds_at(mark.tick):.2f} s" for mark in notes.marks],
        "episodes": [
            f"{one.label}, {player.seconds_at(one.first):.2f} to {player.seconds_at(one.last):.2f} s"
            for one in notes.episodes
        ],
        "versions": player.versions,
        "problems": problems,
    }


def _map(name: str) -> dict[str, Any]:
    from tactile_maps.maps.evaluation.quality import measure  # slow import

    map_ = load_map(name)
    return {
        "kind": "map",
        "name": Path(name).stem,
        **_skin(map_.skin),
        "quality": measure(map_).to_json(),
        "problems": _problems(map_.skin.findings),
    }


def _own_skin(name: str) -> dict[str, Any]:
    skin = load_skin(name)
    return {"kind": "skin", "name": Path(name).stem, **_skin(skin), "problems": _problems(skin.findings)}


def _taxel_file(name: str) -> dict[str, Any]:
    sets = tuple(TaxelFile(name).sets.values())
    parts = [axes_summary(taxels.axes, taxels.tangents, len(taxels)) for taxels in sets]
    return {
        "kind": "taxel file",
        "name": Path(name).stem,
        "links": [taxels.link for taxels in sets],
        "taxels": sum(map(len, sets)),
        "mapped": sum(int(taxels.mapped.sum()) for taxels in sets),
        "identity": identity_summary(join_identities([taxels.identity for taxels in sets])),
        "axes": {key: sum(part[key] for part in parts) for key in parts[0]},
        "problems": _problems(finding for taxels in sets for finding in taxels.findings),
    }


def _study_table(name: str) -> dict[str, Any]:
    from tactile_maps.studies.running.study_table import read_study_table  # slow import

    table = read_study_table(name)
    return {
        "kind": "study table",
        "name": Path(name).stem,
        "rows": len(table.rows),
        "columns": list(table.columns),
        "problems": [],
    }


def _layout(name: str) -> dict[str, Any]:
    layout = read_icub_layout(name)
    return {
        "kind": "layout",
        "name": layout.name,
        "modules": len(layout.modules),
        "taxels": len(layout.numbers),
        "problems": _problems(layout.findings),
    }


_DESCRIBERS: Mapping[FileKind, Callable[[str], dict[str, Any]]] = {
    FileKind.RECORDING: _recording,
    FileKind.MAP: _map,
    FileKind.SKIN: _own_skin,
    FileKind.TAXELS: _taxel_file,
    FileKind.LAYOUT: _layout,
    FileKind.STUDY_TABLE: _study_table,
}


def _problems(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    return [{"kind": f.kind, "where": f.where, "remedy": f.action, "count": f.count} for f in findings]


def _text(value: object) -> str:
    return ", ".join(_item(item) for item in value) if isinstance(value, list) else plain_text(value)


def _item(item: object) -> str:
    """Short text of a patch or an object."""
    if not isinstance(item, dict):
        return plain_text(item)
    return (
        f"{item['name']} ({counted(item['taxels'], 'taxel')})"
        if "taxels" in item
        else f"{item['name']} ({item['kind']})"
    )


def _list_plugins(*, as_json: bool) -> int:
    """Print the plug-ins of other packages by kind; return 0 also if some are left out."""
    found = tuple(_every_plugin())
    if as_json:
        print_json({"plugins": [_plugin_row(plugin) for plugin in found]})
        return 0
    if not found:
        print_line("No plug-ins are installed.")
    width = [max((len(cell) for cell in column), default=0) for column in zip(*map(_plugin_cells, found), strict=True)]
    for plugin in found:
        print_line(
            "  ".join(f"{cell:<{wide}}" for cell, wide in zip(_plugin_cells(plugin), width, strict=True)).rstrip()
        )
    return 0


def _every_plugin() -> Iterator[Plugin]:
    for module, name in REGISTRIES.values():
        registry: Registry[Any] = getattr(import_module(module), name)
        yield from registry.plugins()
    yield from unknown_kinds(tuple(REGISTRIES))


def _plugin_cells(plugin: Plugin) -> tuple[str, ...]:
    state = "in use" if plugin.problem is None else f"left out: {plugin.problem}"
    return plugin.kind, plugin.name, f"{plugin.package} {plugin.version}", state


def _plugin_row(plugin: Plugin) -> dict[str, object]:
    state = "in use" if plugin.problem is None else "left out"
    about = {"kind": plugin.kind, "name": plugin.name, "package": plugin.package, "version": plugin.version}
    return {**about, "target": plugin.target, "state": state, "problem": plugin.problem}
