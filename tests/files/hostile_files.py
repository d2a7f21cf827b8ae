"""Files made to hurt: each is refused by name or works, within 10 seconds of CPU and 2 GB."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import trimesh

from tactile_maps.editing.document_file import load_document
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import load_map
from tactile_maps.maps.formats.obj import read_obj
from tactile_maps.recording.file.mcap_file import read_recording
from tactile_maps.recording.player import open_recording
from tactile_maps.robots.files.mesh_files import MESH_SUFFIXES, read_mesh
from tactile_maps.robots.formats.mjcf import load_mjcf
from tactile_maps.robots.formats.urdf import load_urdf
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.bundle import robot_from_zip
from tactile_maps.session.prepare import open_scene
from tactile_maps.skin.formats.csv_table import read_table
from tactile_maps.skin.formats.icub.layout import read_icub_layout
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.npz import read_taxel_npz
from tactile_maps.skin.formats.taxel_files import read_taxel_sets
from tactile_maps.skin.formats.unige_json import read_unige
from tactile_maps.skin.formats.urdf_tactile import read_urdf_taxels
from tactile_maps.skin.formats.vendors.mapping_file import load_mapping
from tactile_maps.skin.model.skin_file import load_skin
from tactile_maps.skin.open import open_skin
from tactile_maps.stimuli.stimulus_file import load_stimuli

OPENERS = {
    "map": (load_map, (".npz",)),
    "document": (load_document, (".npz",)),
    "uv": (read_obj, (".obj",)),
    "skin": (load_skin, (".npz",)),
    "any skin": (open_skin, (".npz", ".csv", ".txt", ".json", ".urdf", ".xml", ".stl")),
    "taxels": (read_taxel_sets, (".npz", ".csv", ".tsv", ".txt", ".json", ".yaml", ".ini", ".urdf", ".xml", ".dat")),
    "mapping": (load_mapping, (".toml",)),
    "taxel table": (read_table, (".csv",)),
    "taxel npz": (read_taxel_npz, (".npz",)),
    "unige": (read_unige, (".json",)),
    "urdf taxels": (read_urdf_taxels, (".urdf",)),
    "icub positions": (read_icub_positions, (".txt",)),
    "icub layout": (read_icub_layout, (".ini",)),
    "robot": (load_robot_file, (".xml", ".mjcf", ".urdf", ".xacro", *MESH_SUFFIXES)),
    "mjcf": (load_mjcf, (".xml",)),
    "urdf": (load_urdf, (".urdf",)),
    "mesh": (read_mesh, MESH_SUFFIXES),
    "scene": (load_scene, (".toml",)),
    "checked scene": (open_scene, (".toml",)),
    "stimuli": (load_stimuli, (".toml",)),
    "recording": (open_recording, (".mcap",)),
    "recording contents": (read_recording, (".mcap",)),
}
"""Every function that opens a file someone gives, with the endings it knows."""
PATHS = tuple((name, ending) for name, (_, endings) in OPENERS.items() for ending in endings)


def read(name, path):
    """Return what an opener of ``OPENERS`` makes of a file."""
    given = path if name in ("scene", "checked scene") else Path(path)
    return OPENERS[name][0](given)


def robot(path):
    load_robot_file(path)


def mapped(path):
    build_map(open_skin(path))


def recorded(mjcf, files):
    """A robot inside a recording: unpacked, and built as a session would."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("header.json", '{"name":"r","source":"r","links":[],"joints":[],"home":[],"findings":[]}')
        archive.writestr("robot.xml", mjcf)
        for name, data in files.items():
            archive.writestr(f"assets/{name}", data)
    found = robot_from_zip(packed.getvalue(), file="hostile.mcap")
    compile_spec(robot_spec(found), source="hostile.mcap")


def mjcf(body, before=""):
    return f"<mujoco>{before}<worldbody>{body}</worldbody></mujoco>"


SPHERE = '<geom size="0.1"/>'
BODY = f"<body><joint/>{SPHERE}</body>"
_INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def urdf_chain(links):
    """A row of links, each turning on the one before."""
    parts = [f'<link name="l{i}">{_INERTIAL}</link>' for i in range(links)]
    parts += [
        f'<joint name="j{i}" type="continuous"><parent link="l{i - 1}"/><child link="l{i}"/></joint>'
        for i in range(1, links)
    ]
    return f'<robot name="chain">{"".join(parts)}</robot>'


def _meshes(kind, params, count):
    assets = "".join(f'<mesh name="m{i}" builtin="{kind}" params="{params}"/>' for i in range(count))
    geoms = "".join(f'<geom type="mesh" mesh="m{i}"/>' for i in range(count))
    return mjcf(f"<body><joint/>{geoms}</body>", f"<asset>{assets}</asset>")


def _many(count, geom):
    return mjcf(f'<body pos="0 0 0.00001"><joint axis="1 0 0"/>{geom}</body>' * count)


ROBOTS = {
    "chain.urdf": (urdf_chain(20_000), "more than 500 bodies"),
    "row.urdf": (urdf_chain(400), "a chain has more than"),
    "sphere.xml": (mjcf('<body><joint/><geom size="1e9"/></body>'), "implausibly large"),
    "sphere.urdf": (
        '<robot name="r"><link name="a"><collision><geometry><sphere radius="1e9"/></geometry></collision></link>'
        "</robot>",
        "implausibly large",
    ),
    "default.xml": (
        mjcf("<body><joint/><geom/></body>", '<default><geom size="1e9"/></default>'),
        "implausibly large",
    ),
    "nan.xml": (mjcf('<body pos="nan 0 0"><joint/><geom size="1"/></body>'), "implausibly large"),
    "bodies.xml": (_many(1900, '<geom size="0.1"/>'), "more than 500 bodies"),
    "crowd.xml": (_many(490, '<geom type="ellipsoid" size="0.1 0.2 0.1"/>'), "inside each other"),
    "crowded pair.xml": (_many(2, '<geom type="box" size="0.1 0.1 0.1"/>' * 2400), "inside each other"),
    "shapes.xml": (mjcf("<body><joint/>" + SPHERE * 40_000 + "</body>"), "more than 5000 shapes"),
    "copies.xml": (
        mjcf(f'<replicate count="100"><body><joint/>{SPHERE * 100}</body></replicate>'),
        "more than 5000 shapes",
    ),
    "nested copies.xml": (mjcf('<replicate count="1000">' * 9 + BODY + "</replicate>" * 9), "too many copies"),
    "sites.xml": (
        mjcf(f'<replicate count="2000"><frame>{"<site/>" * 1000}</frame></replicate>{BODY}'),
        "too many elements",
    ),
    "frames.xml": (mjcf("<frame>" * 5000 + BODY + "</frame>" * 5000), "nested more than"),
    "spheres.xml": (_meshes("sphere", "4", 2000), "built-in meshes are too fine"),
    "tori.xml": (_meshes("supertorus", "256 0.5 1 1", 100), "built-in meshes are too fine"),
    "couplings.xml": (
        mjcf('<body name="a"><joint name="a"/><geom size="1"/></body>').replace(
            "</mujoco>", "<equality>" + '<joint joint1="a"/>' * 50_000 + "</equality></mujoco>"
        ),
        "more than 500 joints",
    ),
    "keys.xml": (mjcf(BODY, '<size nkey="100000000" memory="100G"/>'), None),
    "solver.xml": (mjcf(BODY, '<option iterations="2000000000" tolerance="0"/>'), None),
    "relief.xml": (
        mjcf(
            BODY + '<geom type="hfield" hfield="h"/>',
            '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>',
        ),
        None,
    ),
    "picture.xml": (
        mjcf(BODY, '<asset><texture name="t" builtin="flat" type="2d" width="100000" height="100000"/></asset>'),
        None,
    ),
    "grid.xml": (
        mjcf('<body><flexcomp type="grid" count="1000 1000 1000" name="f"/></body>'),
        "<flexcomp> is not supported",
    ),
    "entities.xml": (
        '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
        + mjcf(f'{BODY}<body name="&b;"/>'),
        "document type",
    ),
    "elements.xml": (mjcf("<site/>" * 1_000_000), "elements"),
}
"""Robot files with the expected message; None where the file loads because the harmful part is ignored."""
LONG = ("elements.xml", "crowded pair.xml")
"""Robot files that are not part of the default tests: each takes more than a second to reject."""

_RELIEF = '<asset><hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/></asset>'
_PICTURE = '<asset><texture name="t" builtin="flat" type="2d" width="30000" height="30000"/></asset>'
RECORDED = {
    "copies": (mjcf('<replicate count="1000">' * 3 + BODY + "</replicate>" * 3), "too many copies"),
    "bodies": (mjcf(BODY * 2000), "more than 500 bodies"),
    "entities": (ROBOTS["entities.xml"][0], "document type"),
    "memory": (mjcf(BODY, '<size memory="100G"/>'), "<size> is not allowed"),
    "keys": (mjcf(BODY, '<size nkey="1000000000"/>'), "<size> is not allowed"),
    "solver": (mjcf(BODY, '<option iterations="2000000000"/>'), "<option> is not allowed"),
    "relief": (mjcf(BODY, _RELIEF), "<hfield> is not allowed"),
    "picture": (mjcf(BODY, _PICTURE), "<texture> is not allowed"),
    "grid": (mjcf('<body><flexcomp type="grid" count="1000 1000 1000" name="f"/></body>'), "<flexcomp> is not allowed"),
    "composite": (mjcf('<body><composite type="cable" count="100000"/></body>'), "<composite> is not allowed"),
    "plug-in": (mjcf(BODY, '<extension><plugin plugin="evil.so"/></extension>'), "<extension> is not allowed"),
    "plug-in of a body": (
        mjcf('<body><joint/><geom size="1"/><plugin plugin="evil.so"/></body>'),
        r"<plugin> is not allowed in a robot \(found: evil.so\)",
    ),
    "urdf settings": (
        '<robot name="r"><mujoco><size memory="100G"/></mujoco><link name="a"/></robot>',
        "<size> is not allowed",
    ),
    "spheres": (_meshes("sphere", "4", 2000), "too fine"),
}


def spiked_sphere(path, radii, subdivisions=4):
    """A sphere one of whose vertices is drawn out to ``radii``."""
    sphere = trimesh.creation.icosphere(subdivisions)
    vertices = sphere.vertices.copy()
    vertices[0] *= radii
    trimesh.Trimesh(vertices, sphere.faces, process=False).export(path)
    return path
