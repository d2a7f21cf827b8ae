"""Things that move so far in one step that a contact could be missed: stopped before, for nobody would notice after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import SimulationError
from app.scene.objects import Body
from app.simulation.object_geoms import body_name

_ENDLESS = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
"""Nothing is behind these."""


@dataclass(frozen=True, eq=False)
class _Mover:
    """An object that can move: its name, its body, its velocities, how far it reaches [m], and what it may meet."""

    name: str
    body: int
    motion: slice
    reach: float
    others: IntArray


class Passing:
    """Watches the objects that move. A body first found beyond another's middle would be pushed out on the far side.

    Args:
        model: The compiled model.
        objects: Those that the model has.

    Attributes:
        needed: Whether anything moves.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[Body]) -> None:
        self._model = model
        self._half: FloatArray = model.geom_aabb[:, 3:].min(axis=1)
        bodies = [(thing.spec.name, int(model.body(body_name(thing.spec)).id)) for thing in objects]
        self._movers = [self._mover(name, body) for name, body in bodies if model.body_dofnum[body]]
        self.needed = bool(self._movers)

    def check(self, data: mujoco.MjData, count: int) -> None:
        """Look ahead by ``count`` steps at the present speeds. Cost: 1.5 µs for each object that moves.

        Raises:
            SimulationError: An object could pass through something on its way; nothing changed.
        """
        step = self._model.opt.timestep
        for mover in self._movers:
            speed = float(np.linalg.norm(data.qvel[mover.motion]))
            if speed * step > mover.reach:
                self._look(data, mover, speed, count)

    def _look(self, data: mujoco.MjData, mover: _Mover, speed: float, count: int) -> None:
        step = self._model.opt.timestep
        thin = mover.others[speed * step > mover.reach + self._half[mover.others]]
        away = np.linalg.norm(data.geom_xpos[thin] - data.xpos[mover.body], axis=1)
        # Places are those before the last step.
        near = thin[away <= self._model.geom_rbound[thin] + mover.reach + speed * step * (count + 1)]
        if near.size:
            met = int(near[0])
            longest = (mover.reach + float(self._half[met])) / speed
            raise SimulationError(
                "an object is too fast for the time step",
                place=f"{mover.name} near {self._model.body(self._model.geom_bodyid[met]).name} at {data.time:.3f} s",
                value=f"{speed:.3g} m/s, {1e3 * speed * step:.3g} mm a step",
                remedy=f"It could pass through unseen: use a time step of at most {1e3 * longest:.2g} ms",
            )

    def _mover(self, name: str, body: int) -> _Mover:
        model = self._model
        first, count = int(model.body_dofadr[body]), min(int(model.body_dofnum[body]), 3)
        own = model.geom_bodyid == body
        others = np.flatnonzero(~own & ~np.isin(model.geom_type, _ENDLESS))
        return _Mover(name, body, slice(first, first + count), float(model.geom_rbound[own].max(initial=0.0)), others)
