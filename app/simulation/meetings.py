"""Which bodies may press which link's layer, where the layer makes the contact force itself."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import mujoco

from app.robots.robot import Robot
from app.scene.effects import Effects
from app.scene.objects import Body
from app.simulation.contact_pairs import feeling_links, hull_name, never_touching, touches_itself
from app.simulation.geom_shapes import Solid, Solids
from app.simulation.object_geoms import body_name
from app.skin.skin import Skin
from app.touch.models.foundation import Meeting


def meetings(
    model: mujoco.MjModel, robot: Robot, skin: Skin, effects: Effects, objects: Sequence[Body]
) -> tuple[Meeting, ...]:
    """Objects that every link with skin may meet, and links that may meet each other.

    Args:
        model: The compiled model.
        robot: The robot.
        skin: Its skin.
        effects: What may touch.
        objects: Those that the model has.

    Raises:
        MeshError: A mesh object is no solid.
    """
    solids, links = Solids(model, objects), feeling_links(skin)
    things = [solids[int(model.geom(body_name(thing.spec)).id)] for thing in objects]
    outside = [_meeting(link, thing) for link in links for thing in things]
    if not touches_itself(effects):
        return tuple(outside)
    apart = never_touching(robot, skin)
    hulls = {link: solids[int(model.geom(hull_name(link)).id)] for link in links}
    both = [(a, b) for a, b in combinations(links, 2) if frozenset((a, b)) not in apart]
    bare = [solids[geom] for geom in _bare_geoms(model, robot, links)]
    return (
        *outside,
        *(_meeting(first, hulls[second], own=hulls[first]) for first, second in both),
        *(_meeting(link, solid) for link in links for solid in bare if frozenset((link, solid.by)) not in apart),
    )


def _bare_geoms(model: mujoco.MjModel, robot: Robot, links: Sequence[str]) -> list[int]:
    """Colliding geoms of links without skin."""
    bodies = {int(model.body(link.name).id) for link in robot.links if link.name not in links}
    return [geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in bodies and model.geom_contype[geom]]


def _meeting(link: str, other: Solid, *, own: Solid | None = None) -> Meeting:
    mine = None if own is None else (own.shape, own.pose)
    return Meeting(link, other.body, other.shape, other.pose, other.by, mine)
