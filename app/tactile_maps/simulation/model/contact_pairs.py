"""Pairs of bodies that can touch: explicit contact pairs for links with skin, collision bits for all others.

A link with skin collides as the convex hull of link and skin. The hull has one explicit pair with each object it may
touch, and the points of a pair share the stiffness of the cover. Links without skin and objects collide with each other
by MuJoCo's bits.

A link whose hull would span hollows of its skin collides in convex pieces. The first piece is in the pairs. The others
collide with the same bodies by a separate bit, and their contacts get the parameters of the pair.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import mujoco

from tactile_maps.robots.model.mujoco_spec import drop_found_exclusions
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.model.contact_stiffness import SOLVER_IMPEDANCE
from tactile_maps.simulation.model.model_names import body_name, is_hull, is_object, shape_name
from tactile_maps.simulation.model.object_geoms import is_simulated
from tactile_maps.skin.collision_shapes import add_collision_shapes, excluded_pairs
from tactile_maps.skin.link_hulls import add_hull
from tactile_maps.skin.link_pieces import piece_number
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

_ROBOT = 1
_OUTSIDE = 2
_PIECES = 4


def allows_self_contact(effects: Effects) -> bool:
    """Whether the robot's links may touch each other."""
    return effects.dynamics and effects.contact in ("self", "all")


def collides_by_shapes(objects: Sequence[ObjectSpec], effects: Effects) -> bool:
    """Return whether links with skin collide by their hulls or pieces under these effects."""
    outside = any(is_simulated(spec.kind, effects) for spec in objects)
    return effects.skin != "foundation" and (outside or allows_self_contact(effects))


def add_contact_pairs(
    spec: mujoco.MjSpec, robot: Robot, skin: Skin, objects: Sequence[SceneObject], effects: Effects, layer: ElasticLayer
) -> None:
    """Set up all contacts for the effects, and delete shapes that cannot touch anything.

    Args:
        spec: Model of the robot with the simulated objects; changed.
        robot: The robot.
        skin: Its skin.
        objects: All objects of the scene.
        effects: Effects, of which ``contact``, ``friction`` and ``skin`` are used.
        layer: The skin's cover, for its friction.

    Raises:
        RobotError: MuJoCo refuses the robot.
    """
    outside = [scene_object for scene_object in objects if is_simulated(scene_object.spec.kind, effects)]
    itself = allows_self_contact(effects)
    links = skin.links
    _drop_own_pairs(spec)
    bare = _bare_shapes(spec, links, keep=itself or (bool(outside) and effects.contact != "probe"))
    _set_bits(spec, bare, outside, effects)
    # The foundation computes the force on the skin; it needs only the shapes of other bodies.
    paired = effects.skin != "foundation"
    shapes: dict[str, str] = {}
    if itself or (outside and paired):
        shapes = {link: _add_shape(spec, robot, skin, link, paired, effects) for link in links}
    _meet_pieces(spec, shapes, bare, outside, itself=itself)
    partners = [(body_name(thing.spec), thing.spec.friction) for thing in outside]
    meetings = [(shape, other, friction) for shape in shapes.values() for other, friction in partners]
    if itself:
        apart = excluded_pairs(robot, skin)
        drop_found_exclusions(spec)
        _exclude(spec, apart)
        meetings += _self_meetings(shapes, bare, apart, layer)
    if paired:
        for first, second, friction in meetings:
            _pair(spec, first, second, layer.friction if friction is None else friction, effects)


def _add_shape(spec: mujoco.MjSpec, robot: Robot, skin: Skin, link: str, paired: bool, effects: Effects) -> str:
    """Add the collision shape of a link, its hull or pieces, and return the name of the geom for pairs."""
    if not paired:
        return str(add_hull(spec, robot, skin, link).name)
    first, *others = add_collision_shapes(spec, robot, skin, link)
    for geom in others:
        geom.contype = _PIECES
        geom.condim = 3 if effects.friction else 1
    return str(first.name)


def _meet_pieces(
    spec: mujoco.MjSpec,
    shapes: Mapping[str, str],
    bare: Iterable[mujoco.MjsGeom],
    outside: Iterable[SceneObject],
    *,
    itself: bool,
) -> None:
    """Let the pieces of links meet objects, and the other links where the robot may touch itself."""
    if all(piece_number(shape) is None for shape in shapes.values()):
        return
    for scene_object in outside:
        spec.geom(body_name(scene_object.spec)).conaffinity |= _PIECES
    if itself:
        for geom in bare:
            geom.conaffinity |= _PIECES
        for link in shapes:
            for geom in spec.body(link).geoms:
                if is_hull(geom.name):
                    geom.conaffinity |= _PIECES


def _set_bits(
    spec: mujoco.MjSpec, bare: Iterable[mujoco.MjsGeom], outside: Iterable[SceneObject], effects: Effects
) -> None:
    """Let links without skin and objects collide with each other by bits."""
    own = _ROBOT if allows_self_contact(effects) else 0
    for geom in bare:
        geom.contype = own
        geom.conaffinity = own | _OUTSIDE
        geom.condim = 3 if effects.friction else 1
    for scene_object in outside:
        if effects.contact != "probe":
            geom = spec.geom(body_name(scene_object.spec))
            geom.contype = _OUTSIDE
            geom.conaffinity = _OUTSIDE


def _bare_shapes(spec: mujoco.MjSpec, links: Sequence[str], *, keep: bool) -> list[mujoco.MjsGeom]:
    """Return the collision shapes of links without skin if ``keep``; all other shapes of links are deleted."""
    kept: list[mujoco.MjsGeom] = []
    for body in spec.bodies:
        for geom in list(body.geoms):
            if is_object(geom.name):
                continue
            if keep and body.name not in links and (geom.contype or geom.conaffinity):
                geom.name = geom.name or shape_name(len(kept))
                kept.append(geom)
            elif body.explicitinertial:
                spec.delete(geom)
            else:  # inertia is computed from the shapes
                geom.contype = geom.conaffinity = 0
    used = {geom.meshname for geom in spec.geoms}
    for mesh in [mesh for mesh in spec.meshes if mesh.name not in used]:
        spec.delete(mesh)
    return kept


def _drop_own_pairs(spec: mujoco.MjSpec) -> None:
    """Delete the pairs of the robot file: their shapes are replaced by hulls."""
    for pair in list(spec.pairs):
        spec.delete(pair)


def _self_meetings(
    shapes: Mapping[str, str], bare: Iterable[mujoco.MjsGeom], apart: frozenset[frozenset[str]], layer: ElasticLayer
) -> list[tuple[str, str, float | None]]:
    """Return (first geom, second geom, friction) of links with skin, with each other and with links without skin."""
    both = [
        (shapes[a], shapes[b], layer.friction) for a, b in combinations(shapes, 2) if frozenset((a, b)) not in apart
    ]
    return both + [
        (shape, geom.name, layer.friction)
        for link, shape in shapes.items()
        for geom in bare
        if frozenset((link, geom.parent.name)) not in apart
    ]


def _exclude(spec: mujoco.MjSpec, apart: frozenset[frozenset[str]]) -> None:
    known = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    for first, second in sorted(sorted(pair) for pair in apart - known if len(pair) == 2):
        spec.add_exclude(bodyname1=first, bodyname2=second)


def _pair(spec: mujoco.MjSpec, first: str, second: str, friction: float, effects: Effects) -> None:
    spec.add_pair(
        name=f"{first} | {second}",
        geomname1=first,
        geomname2=second,
        condim=3 if effects.friction else 1,
        friction=[friction, friction, 0.005, 0.0001, 0.0001],
        solimp=[SOLVER_IMPEDANCE, SOLVER_IMPEDANCE, 0.001, 0.5, 2],
    )
