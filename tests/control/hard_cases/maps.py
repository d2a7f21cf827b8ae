"""Hard cases of control: the map that is believed is not the skin that is touched, or changes, or ends."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.inputs import MapEdited
from tactile_maps.session.session import Session
from tactile_maps.skin.calibration_error import with_calibration_error
from tests.control.hard_cases.case import GOAL, OTHERS, SOME, HardCase, arrives, both, bounded_only, kept, next_to_taxel
from tests.control.hard_cases.environments import led
from tests.support.pressed_arm import Course, forearm, pressed_by_ball

TAXEL = 150
_ASIDE = {"task": "hold_point", "path": next_to_taxel(TAXEL, 0.012, 0.009)}


@cache
def turned(about: str, degrees: float) -> TactileMap:
    """The forearm's map as if its skin were put on turned about a taxel: about its ``normal``, or a ``tangent``.

    So around that taxel all normals are wrong by the angle, or the map's frame is.
    """
    skin = forearm().skin
    at = forearm().skin.taxel_point(TAXEL)
    centre = skin.position(at)
    normal = skin.normal(at)
    side = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    axis = {"normal": normal, "tangent": side / np.linalg.norm(side)}[about]
    turn = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix().T
    patch = skin.patches[at.patch]

    def put(points: np.ndarray) -> np.ndarray:
        return centre + (points - centre) @ turn

    taxels = patch.taxels
    spread = patch.taxels.quadrature
    spread = replace(spread, positions=put(spread.positions), normals=spread.normals @ turn)
    taxels = replace(taxels, positions=put(taxels.positions), normals=taxels.normals @ turn, quadrature=spread)
    surface = Mesh(put(patch.surface.vertices), patch.surface.faces)
    turned_patch = replace(patch, surface=surface, taxels=taxels)
    patches = tuple(turned_patch if one is patch else one for one in skin.patches)
    return replace(forearm().map, skin=replace(skin, patches=patches))


@cache
def calibrated(sd: float, by: str, seed: int = 1) -> TactileMap:
    """The map made of a calibration with that error along each axis [m]."""
    return build_map(with_calibration_error(forearm().skin, sd, seed=seed, by=by))


def believing(map_: TactileMap):
    return lambda settings: pressed_by_ball(settings, believed=map_)


def wrong_normal(degrees: float):
    return lambda settings: pressed_by_ball(settings, believed=turned("tangent", degrees))


def wrong_frame(degrees: float):
    return lambda settings: pressed_by_ball(settings, believed=turned("normal", degrees))


def wrong_places(sd: float, by: str):
    return lambda settings: pressed_by_ball(settings, believed=calibrated(sd, by))


def towards(share: float):
    """The contact comes nearer to its place on the map, to that share of the way it began with."""

    def check(course: Course) -> None:
        begun = course.error[np.isfinite(course.error)][0]
        assert np.nanmin(course.error) < share * begun

    return check


def moved_layout(session: Session) -> None:
    """Rotate the whole map by 40 degrees and move it, during contact."""
    placements = tuple(
        replace(one, angle=one.angle + np.radians(40.0), offset=np.asarray(one.offset) + [0.1, -0.05])
        for one in session.map.layout.placements
    )
    session.submit(MapEdited("Turned", replace(session.map, layout=MapLayout(placements))))


def goes_on(course: Course) -> None:
    """The force does not jump with the map, and is kept."""
    at = round(2.0 / course.tick)
    assert np.abs(np.diff(course.pressed[at - 1 : at + 10])).max() < 0.3
    kept()(course)


def over_the_border(settings: ControlSettings) -> Session:
    """The ball on the taxel nearest to the forearm's border."""
    map_ = forearm().map
    border = map_.outlines[0]
    away = np.linalg.norm(map_.taxel_points[:, None] - border[None], axis=2).min(axis=1)
    return pressed_by_ball(settings, taxel=int(away.argmin()))


def reads_the_goal(course: Course) -> None:
    """The force that is read reaches the goal, whatever the true force is."""
    assert abs(course.last(course.force).mean() - GOAL) < 0.2
    assert course.last(course.force).std() < 0.2


def off_the_skin(settings: ControlSettings) -> Session:
    """A path that goes straight on for a metre."""
    (start,) = next_to_taxel(TAXEL, 0.0, 0.0)
    return pressed_by_ball(replace(settings, path=(start, (start[0], start[1] + 1.0))))


PATH = {"task": "follow_path"}
_UNYIELDING = ("hybrid", "projection")
"""Schemes whose force along the path does not yield to the force that is read."""

CASES: dict[str, HardCase] = {
    "normals wrong by 15 degrees": HardCase(
        "sine of 15 degrees of every push goes along the skin: the integral and the way back make up for it",
        wrong_normal(15.0),
        both(kept(), arrives()),
        _ASIDE,
        seconds=4.0,
        force=8.0,
        controllers=SOME,
        between=True,
    ),
    "normals wrong by 30 degrees": HardCase(
        "the same",
        wrong_normal(30.0),
        both(kept(), arrives()),
        _ASIDE,
        seconds=4.0,
        force=8.0,
        controllers=SOME,
        between=True,
    ),
    "normals wrong by 45 degrees": HardCase(
        "the same, though motion along the skin leaks into force by as much: it may be lost for a moment",
        wrong_normal(45.0),
        both(kept(), arrives()),
        _ASIDE,
        seconds=5.0,
        force=10.0,
    ),
    "the map's frame turned by 30 degrees": HardCase(
        "the contact comes in a bow",
        wrong_frame(30.0),
        both(kept(), arrives()),
        _ASIDE,
        seconds=4.0,
        force=8.0,
        controllers=SOME,
        between=True,
    ),
    "the map's frame turned by 60 degrees": HardCase(
        "in a wide bow", wrong_frame(60.0), both(kept(within=0.3), arrives(0.004)), _ASIDE, seconds=6.0, force=8.0
    ),
    "the map's frame turned by 75 degrees": HardCase(
        "cos 75 of every step is on the way: at a high gain it may circle or be let go, bounded",
        wrong_frame(75.0),
        bounded_only,
        _ASIDE,
        seconds=5.0,
        force=10.0,
        controllers=SOME,
        between=True,
    ),
    "the map's frame turned by 75 degrees, gain for it": HardCase(
        "with a quarter of the gain it comes, slowly",
        wrong_frame(75.0),
        both(kept(within=0.3), towards(0.5)),
        {**_ASIDE, "position_gain": 1.0},
        seconds=8.0,
        force=8.0,
    ),
    **{
        f"taxels {1e3 * sd:g} mm off, {kind} Jacobian": HardCase(
            stated,
            wrong_places(sd, "taxel"),
            check,
            {**PATH, "jacobian": kind},
            seconds=5.0,
            force=force,
            between=(sd, kind) in ((0.0005, "raw"), (0.002, "raw"), (0.007, "smoothed")),
        )
        for sd, kind, stated, check, force in (
            (0.0005, "raw", "triangles say little else than the truth: the path is followed", led(0.004, 0.010), 10.0),
            (0.002, "smoothed", "the fit over two rings says the truth within a tenth", led(0.005, 0.014), 12.0),
            (0.002, "raw", "some triangles are flipped, others very slow: bounded", bounded_only, 25.0),
            (0.007, "smoothed", "it still leads on: the path is followed, badly", bounded_only, 25.0),
            (0.007, "raw", "a third of the triangles leads backwards: bounded", bounded_only, 40.0),
        )
    },
    "modules 2 mm off": HardCase(
        "rigid modules are wrong at their borders only: the path is followed",
        wrong_places(0.002, "module"),
        led(0.005, 0.014),
        PATH,
        seconds=5.0,
        force=12.0,
        controllers=SOME,
        between=True,
    ),
    "modules 7 mm off": HardCase(
        "the same, badly", wrong_places(0.007, "module"), bounded_only, PATH, seconds=5.0, force=25.0
    ),
    "the map is edited in mid-contact": HardCase(
        "a held place of the body is the same on every map: nothing jumps",
        lambda settings: pressed_by_ball(settings),
        goes_on,
        {"task": "hold_point"},
        seconds=4.0,
        force=8.0,
        acts={2.0: moved_layout},
    ),
    "a contact over the skin's border": HardCase(
        "only force on skin is measured, so the arm presses harder: the measured force is kept",
        over_the_border,
        reads_the_goal,
        seconds=4.0,
        force=15.0,
        controllers=OTHERS,
    ),
    "a path that leaves the skin": HardCase(
        "it ends at the border, and says so",
        off_the_skin,
        bounded_only,
        {**PATH, "path_kind": "polyline", "path_speed": 0.03},
        seconds=6.0,
        force=20.0,
        says=((LimitKind.PATH_LEAVES_SKIN,),),
        controllers=tuple(name for name in CONTROL_SCHEMES if name not in _UNYIELDING),
    ),
    "a path that leaves the skin, against friction": HardCase(
        "they follow the path with all their force while friction holds the ball beyond the border, up to the limit",
        off_the_skin,
        bounded_only,
        {**PATH, "path_kind": "polyline", "path_speed": 0.03},
        seconds=6.0,
        force=45.0,
        says=((LimitKind.PATH_LEAVES_SKIN,),),
        controllers=_UNYIELDING,
    ),
}
