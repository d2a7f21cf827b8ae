"""The same path on the body for every map: drawn on the true map, and taken over to the one that is believed.

A figure of 30 mm drawn on a map that squeezes the skin is a shorter way on the body, and times would tell of the
drawing's size. So where the believed map is another, the path is a polyline through the places of the true one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import draw_path, path_about
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import same_triangles
from tactile_maps.studies.testbeds.path_following import PathSetup

_CORNERS = 128
"""Of the polyline: 0.7 mm apart on a way of 91 mm."""


def with_path_on_body(settings: ControlSettings, setup: PathSetup) -> ControlSettings:
    """The settings with their path about what touches, on the true map; as polyline on another map that is believed.

    Cost: 20 ms where another map is believed.
    """
    if setup.believed is None:
        return settings
    true = setup.prepared.map
    centre = true.to_map(touched_place(setup.prepared))
    drawn = path_about(settings.path_kind, centre, settings.path_size)
    ways = np.linspace(0.0, drawn.length, _CORNERS, endpoint=False)
    points = np.array([drawn.at(way)[0] for way in (*ways, 0.0)])
    taken = taken_over(points, true, setup.believed)
    return replace(settings, path_kind="polyline", path=tuple((float(x), float(y)) for x, y in taken))


def path_length(settings: ControlSettings) -> float:
    """Of a round of the settings' path, drawn or about what touches [m on the map]."""
    if settings.path:
        return draw_path(settings.path_kind, settings.path).length
    return path_about(settings.path_kind, np.zeros(2), settings.path_size).length


def touched_place(prepared: PreparedScene) -> SurfacePoint:
    """The place of the skin that is nearest to the first object when the robot is at home."""
    configuration = Configuration(prepared.robot)
    middle = np.array(prepared.scene.objects[0].at)
    found = []
    for number, patch in enumerate(prepared.skin.patches):
        at = configuration.pose(patch.link).inverse.points(middle)
        faces, weights, away = ClosestPoint(patch.surface).query(at[None])
        found.append((float(away[0]), _surface_point(number, int(faces[0]), weights[0])))
    return min(found, key=lambda one: one[0])[1]


def taken_over(points: FloatArray, true: TactileMap, believed: TactileMap) -> FloatArray:
    """(k, 2) where the body's places behind ``points`` (k, 2) of the true map lie on the believed one [m].

    A misplaced skin has the true one's triangles, and a place is the same one; a learned map has its own between taxels
    where they are, and the nearest place counts. Points outside the true map are left out.
    """
    found = []
    nearest: dict[int, ClosestPoint] = {}
    for patch, face, weights in zip(*true.to_body_many(points), strict=True):
        if face < 0:
            continue
        place = _surface_point(int(patch), int(face), weights)
        other = believed.skin.patches[place.patch]
        if not same_triangles(true.skin.patches[place.patch], other):
            surface = nearest.setdefault(place.patch, ClosestPoint(other.surface))
            faces, shares, _ = surface.query(true.skin.position(place)[None])
            place = _surface_point(place.patch, int(faces[0]), shares[0])
        found.append(believed.to_map(place))
    return np.array(found).reshape(-1, 2)


def _surface_point(patch: int, face: int, weights: FloatArray) -> SurfacePoint:
    a, b, c = weights.tolist()
    return SurfacePoint(patch, face, (a, b, c))
