"""Names in a model of what the assembly adds to the robot: a skinned link's hull, or its pieces, and an object.

They are in a namespace of their own, which no robot may use, and told apart by kind in it. So a link, a joint or a
shape of a robot may have any other name, and what a name begins with says for sure what it is.
"""

from __future__ import annotations

from tactile_maps.robots.model.mujoco_spec import OWN_NAMES
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.skin.link_hulls import HULL
from tactile_maps.skin.link_pieces import piece_link, piece_number

_OBJECT, _SHAPE = (f"{OWN_NAMES}{kind} " for kind in ("object", "shape"))


def body_name(object_spec: ObjectSpec) -> str:
    """Of the object: its body, its geom, its mesh, and its joint if it has one."""
    return _OBJECT + object_spec.name


def shape_name(number: int) -> str:
    """Of a robot's shape to which its file gives no name."""
    return f"{_SHAPE}{number}"


def is_hull(name: str) -> bool:
    """Whether a geom or mesh of that name is the hull of a skinned link, or a piece of it."""
    return name.startswith(HULL) or piece_number(name) is not None


def is_object(name: str) -> bool:
    """Whether a geom or mesh of that name belongs to an object."""
    return name.startswith(_OBJECT)


def plain_name(name: str) -> str:
    """For people: what it is called in its own file."""
    name = piece_link(name)
    for kind in (HULL, _OBJECT, _SHAPE):
        name = name.removeprefix(kind)
    return name
