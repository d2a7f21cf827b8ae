"""Pressures of a ball on a skin at rest, without a simulation."""

from __future__ import annotations

import math

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects


def check_place(skin: Skin, at: SurfacePoint) -> None:
    """Reject a place that is not on the skin; recordings may contain one.

    Raises:
        SimulationError: Unknown patch or face, or weights that are not those of a point in a triangle.
    """
    known = 0 <= at.patch < len(skin.patches) and 0 <= at.face < len(skin.patches[at.patch].surface.faces)
    weights = np.asarray(at.weights, dtype=np.float64)
    if not (known and weights.shape == (3,) and (weights >= -1e-6).all() and abs(weights.sum() - 1) < 1e-6):
        raise SimulationError("the place is not on the skin", value=at, remedy="Press where there is skin")


def press_skin(
    skin: Skin,
    at: SurfacePoint,
    *,
    force: float = 3.0,
    radius: float = 0.008,
    model: str = "water-fill",
    layer: ElasticLayer | None = None,
) -> FloatArray:
    """Return the pressures of a ball that presses at one place along the skin's normal; nothing moves.

    Pressures of several touches add up. In a ``Session`` the same touch moves the robot.

    Args:
        skin: The skin.
        at: Place on the skin.
        force: Force of the ball on the skin [N], >= 0.
        radius: Radius of the ball [m], > 0.
        model: Contact model, one of ``tactile_maps.tactile.models.contact_model.CONTACT_MODELS``.
        layer: The skin's cover; by default a foam.

    Returns:
        (taxels,) [Pa]; times the skin's ``areas`` they add up to the force, less the share that bare surface next to
        the skin bears.

    Raises:
        SimulationError: The place is not on the skin, force or radius is out of range, or the model is unknown.

    Example:
        >>> pressures = tm.press_skin(skin, skin.taxel_point(30), force=3.0)
        >>> print(f"{pressures @ skin.areas:.3f} N on {(pressures > 0).sum()} of {len(skin)} taxels")
        3.000 N on 1 of 60 taxels

    Cost: 1 ms for 1000 taxels, most of it to build the model; ``half-space`` 0.1 s.
    """
    if not (math.isfinite(force) and force >= 0):
        raise SimulationError("the force is out of range", place="force", value=force, remedy="Choose 0 N or more")
    if model not in CONTACT_MODELS:
        raise SimulationError("unknown contact model", value=model, remedy=CONTACT_MODELS.remedy(model))
    check_place(skin, at)
    layer = ElasticLayer() if layer is None else layer
    load = sphere_load(skin.link(at), skin.position(at), skin.normal(at), force, radius, depth=force / layer.stiffness)
    return CONTACT_MODELS[model].build(skin, layer, SensorEffects()).pressures([load])
