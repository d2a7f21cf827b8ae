"""Shared test data: a coarse arm, a smooth touch as a session would report it, and a small constant map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.timing import Timings
from tactile_maps.editing.document import MapDocument
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.studies.testbeds.reference_bodies import MESHES
from tactile_maps.tactile.poke import PokeState


def coarse(taxels) -> Scene:
    """The arm in a skin so thick that its triangles are large: it is prepared, and its map measured, ten times as soon.

    Args:
        taxels: How many.
    """
    scene = load_scene("arm")
    return replace(scene, cover=replace(scene.cover, taxels=taxels, thickness=0.01))


def touched(tactile_map, taxels=(), *, tick=1, time=0.0, kilopascals=12.0, radius=0.02) -> Frame:
    """A frame with a round touch on the map around each of ``taxels``."""
    pressures = np.zeros(len(tactile_map.skin))
    regions = []
    pokes = []
    for number, taxel in enumerate(taxels):
        at = tactile_map.skin.taxel_point(taxel)
        centre = tactile_map.taxel_points[taxel]
        share = 1 - (np.linalg.norm(tactile_map.taxel_points - centre, axis=1) / radius) ** 2
        pressures += 1e3 * kilopascals * np.clip(share, 0, None)
        felt = np.flatnonzero(share > 0)
        skin = tactile_map.skin
        point = skin.position(at)
        normal = skin.normal(at)
        force = float(pressures[felt] @ skin.areas[felt])
        area = float(skin.areas[felt].sum())
        peak = float(pressures[felt].max())
        patch = skin.patches[at.patch].surface
        along = np.diff(patch.vertices[patch.faces[at.face][:2]], axis=0)[0]
        along = along / np.linalg.norm(along)
        axes = radius * np.array([0.8 * along, 0.5 * np.cross(normal, along)])
        regions.append(
            ContactRegion(
                number,
                felt,
                force,
                area,
                peak,
                centre,
                at,
                skin.link(at),
                point,
                normal,
                link_axes=axes,
                place_error=0.3 * radius,
            )
        )
        pokes.append(PokeState(number, at, force, point, normal, 0.008))
    none = np.zeros(0)
    command = JointCommand(none, none, none, none)
    timings = Timings({"physics": 1.1, "sensing": 0.5, "contacts": 0.3, "control": 0.2})
    return Frame(tick, time, none, none, pressures, tuple(regions), tuple(pokes), command, (), timings)


def middle_taxel(tactile_map, patch) -> int:
    """The taxel nearest to the middle of a patch on the map."""
    first = tactile_map.skin.first[patch]
    last = tactile_map.skin.first[patch + 1]
    points = tactile_map.taxel_points[first:last]
    return int(first + np.linalg.norm(points - points.mean(axis=0), axis=1).argmin())


def shifted(tactile_map, by) -> TactileMap:
    """The same map with all patches moved by (2,) [m]."""
    dx, dy = by
    moved = (replace(p, offset=(p.offset[0] + dx, p.offset[1] + dy)) for p in tactile_map.layout.placements)
    return replace(tactile_map, layout=replace(tactile_map.layout, placements=tuple(moved)))


def leaf_map() -> TactileMap:
    """A real map of two flat, leaf-shaped patches: pictures of it pin the drawing, not the covering or flattening."""
    leaves = [("left leaf", 0.10, 0.16, (0.11, 0.17)), ("right leaf", 0.13, 0.10, (0.38, 0.12))]
    made = [_leaf(name, width, height) for name, width, height, _ in leaves]
    placements = tuple(Placement(0.1 * k, middle) for k, (_, _, _, middle) in enumerate(leaves))
    return TactileMap(Skin(tuple(patch for patch, _ in made)), tuple(chart for _, chart in made), MapLayout(placements))


def _leaf(name, width, height, *, rings=12, sides=48) -> tuple[Patch, Chart]:
    """A patch as rings of points around a middle; a sixth of its border counts as seam."""
    angle = np.arange(sides) * 2 * np.pi / sides
    reach = 1 + 0.1 * np.cos(3 * angle)
    rim = np.stack([width * reach * np.cos(angle), height * reach * np.sin(angle)], axis=1)
    plane = np.vstack([np.zeros((1, 2)), *(rim * k / rings for k in range(1, rings + 1))])
    here = np.arange(sides)
    there = (np.arange(sides) + 1) % sides
    faces = [np.stack([np.zeros(sides, int), 1 + here, 1 + there], axis=1)]
    for k in range(rings - 1):
        inner = 1 + k * sides
        outer = 1 + (k + 1) * sides
        faces += [
            np.stack([inner + here, outer + here, outer + there], axis=1),
            np.stack([inner + here, outer + there, inner + there], axis=1),
        ]
    surface = Mesh(np.column_stack([plane, np.zeros(len(plane))]), np.vstack(faces))
    seams = np.stack([here, there], axis=1)[: sides // 6] + 1 + (rings - 1) * sides
    chart = Chart(surface.faces, plane, np.arange(len(plane)), seams, "by hand")
    return Patch(name, name.replace(" ", "_"), surface, _taxels(surface)), chart


def _taxels(surface, count=220) -> Taxels:
    """Evenly spread face middles, each as far from those before as can be, sharing the area."""
    middles = surface.vertices[surface.faces].mean(axis=1)
    chosen = np.zeros(count, dtype=int)
    away = np.linalg.norm(middles - middles[0], axis=1)
    for k in range(1, count):
        chosen[k] = away.argmax()
        away = np.minimum(away, np.linalg.norm(middles - middles[chosen[k]], axis=1))
    weights = np.full((count, 3), 1 / 3)
    positions = surface.points(chosen, weights)
    normals = np.tile([0.0, 0.0, 1.0], (count, 1))
    areas = np.full(count, surface.area / count)
    felt = Quadrature(positions, normals, areas, np.arange(count))
    return Taxels(positions, normals, chosen, weights, areas, np.zeros((0, 2), int), felt)


def tube_and_hemisphere(faces) -> MapDocument:
    """A document of two patches with this number of faces and 40 taxels each."""
    patches = []
    for name in ("tube", "hemisphere"):
        surface = MESHES[name](faces)
        patches.append(Patch(name, name, surface, place_evenly(surface, 40, seed=0)))
    return MapDocument.of(build_map(Skin(tuple(patches))))
