"""Contacts and observations for tests of controllers without a simulation."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.task_priority import TaskContact
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap

TICK = 0.005
TO_MAP = np.array([[2.0, 0.0, 0.0], [0.5, 1.0, 0.0]])


def touch(force, *, x=0.3, id_=1, normal=(0, 0, 1)):
    """Return a contact on the centre line of the bar's top."""
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    return (region(force, at, np.array([x, 0, 0.02]), np.zeros(2), id_=id_, normal=normal),)


def touch_on(map_: TactileMap, taxel, force, *, id_=1):
    """Return a contact at a taxel of a map."""
    skin = map_.skin
    at = skin.taxel_point(taxel)
    return region(force, at, skin.position(at), map_.to_map(at), id_=id_, normal=skin.normal(at), link=skin.link(at))


def region(force, at, place, map_point, *, id_=1, normal=(0, 0, 1), link="bar"):
    """A contact region with the attributes that controllers read."""
    return ContactRegion(
        id=id_,
        taxels=np.array([0]),
        force=force,
        area=1e-4,
        peak=1e4,
        map_point=map_point,
        at=at,
        link=link,
        link_position=place,
        link_normal=np.asarray(normal),
    )


def contact(error=None, velocity=(0.0, 0.0)) -> TaskContact:
    """A contact of an arm with four joints, as input of a control scheme."""
    return TaskContact(
        id=1,
        force=2.0,
        force_error=1.0,
        normal=np.array([0.0, 0.0, 1.0]),
        point=np.zeros(3),
        move=np.arange(12.0).reshape(3, 4),
        to_map=TO_MAP,
        error=error,
        velocity=np.asarray(velocity),
    )


def observed(posture, contacts=(), *, velocity=0.0, readable=True) -> Observation:
    """The observation of a robot with this posture; all joints have the same velocity."""
    posture = np.asarray(posture, dtype=float)
    return Observation(posture, np.full(posture.shape, velocity), contacts, TICK, readable=readable)
