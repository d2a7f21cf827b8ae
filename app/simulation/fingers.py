"""Fingers on the skin: springs from world-fixed fingertips, evaluated at every physics step."""

from __future__ import annotations

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.geometry.surface_point import SurfacePoint
from app.simulation.loads import Load
from app.simulation.poke import Finger, PokeInput, PokeMoved, PokePressed, PokeReleased, PokeState
from app.skin.skin import Skin

_STABLE = 0.6
"""An explicit spring stays stable while dt < 0.6 sqrt(m / k); measured, for a mass without damping."""


class Fingers:
    """All fingers that touch the skin. Mutable; ``reset`` lifts them all.

    A finger touches one body point. Its spring acts along the skin's normal there: the fingertip stands still in the
    world but advances into the skin at the finger's speed while it pushes less than its limit, so an arm that yields
    feels less. Pressing an id that is down moves it there afresh; moving or releasing one that is not down does
    nothing, since a release may cross a reset.

    Args:
        model: The compiled model.
        skin: Where fingers touch.
    """

    def __init__(self, model: mujoco.MjModel, skin: Skin) -> None:
        self._model, self._skin = model, skin
        self._body = {patch.link: int(model.body(patch.link).id) for patch in skin.patches}
        self._down: dict[int, _Touch] = {}

    def reset(self) -> None:
        """Lift all fingers."""
        self._down.clear()

    def apply(self, data: mujoco.MjData, poke: PokeInput) -> None:
        """Do what the hand did.

        Raises:
            SimulationError: The finger is too stiff for the time step and the arm's mass at that point.
        """
        if isinstance(poke, PokePressed):
            touch = _Touch(self._skin, self._body, poke.at, poke.finger)
            touch.place(data, 0.0)
            self._refuse_unstable(data, touch)
            self._down[poke.id] = touch
        elif isinstance(poke, PokeMoved) and poke.id in self._down:
            old = self._down[poke.id]
            touch = _Touch(self._skin, self._body, poke.at, old.finger)
            touch.place(data, old.depth(data))
            touch.force = old.force
            self._down[poke.id] = touch
        elif isinstance(poke, PokeReleased):
            self._down.pop(poke.id, None)

    def push(self, data: mujoco.MjData) -> None:
        """Add all fingers' wrenches to ``data.qfrc_applied`` at the current positions, and advance the fingertips."""
        for touch in self._down.values():
            point, normal = touch.skin_point(data), touch.skin_normal(data)
            touch.force = min(max(touch.finger.stiffness * touch.depth(data), 0.0), touch.finger.max_force)
            if self._model.nv and touch.force > 0:
                mujoco.mj_applyFT(self._model, data, -touch.force * normal, np.zeros(3), point, touch.body,
                                  data.qfrc_applied)
            if touch.force < touch.finger.max_force:
                touch.tip = touch.tip - touch.finger.speed * self._model.opt.timestep * normal

    def loads(self) -> list[Load]:
        """What the fingers do to the skin now."""
        return [Load(t.link, t.local, t.local_normal, t.force, t.finger.radius) for t in self._down.values() if t.force]

    def states(self, data: mujoco.MjData) -> tuple[PokeState, ...]:
        """All fingers as values."""
        return tuple(
            PokeState(number, touch.at, touch.force, touch.skin_point(data), touch.skin_normal(data), touch.finger.radius)
            for number, touch in self._down.items()
        )

    def numbers(self) -> FloatArray:
        """Everything that changes about the fingers, as one vector, for comparing runs."""
        rows = [[number, *touch.tip, *touch.local, touch.force] for number, touch in self._down.items()]
        return np.array(rows, dtype=np.float64).ravel()

    def _refuse_unstable(self, data: mujoco.MjData, touch: _Touch) -> None:
        mass, stiffness, step = self._mass(data, touch), touch.finger.stiffness, self._model.opt.timestep
        if step > _STABLE * np.sqrt(mass / stiffness):
            raise SimulationError(
                "the finger is too stiff for the time step", place=f"on {touch.link}", value=f"{stiffness:g} N/m",
                remedy=f"The arm weighs {mass:.3g} kg there: use at most {mass * (_STABLE / step) ** 2:.3g} N/m",
            )

    def _mass(self, data: mujoco.MjData, touch: _Touch) -> float:
        """What the arm weighs along the normal at the touched point [kg]: 1 / (J M⁻¹ Jᵀ); inf when nothing can move."""
        if not self._model.nv:
            return float("inf")
        jacobian = np.zeros((3, self._model.nv))
        mujoco.mj_jac(self._model, data, jacobian, None, touch.skin_point(data), touch.body)
        row = (touch.skin_normal(data) @ jacobian)[None]
        solved = np.zeros_like(row)
        mujoco.mj_solveM(self._model, data, solved, row)
        mobility = float((row @ solved.T)[0, 0])
        return 1.0 / mobility if mobility > 1e-12 else float("inf")


class _Touch:
    """One finger at one body point; ``tip`` is the fingertip in the world."""

    def __init__(self, skin: Skin, bodies: dict[str, int], at: SurfacePoint, finger: Finger) -> None:
        self.at, self.finger, self.link = at, finger, skin.link(at)
        self.body = bodies[self.link]
        self.local, self.local_normal = skin.position(at), skin.normal(at)
        self.tip, self.force = np.zeros(3), 0.0

    def skin_point(self, data: mujoco.MjData) -> FloatArray:
        return np.asarray(data.xmat[self.body].reshape(3, 3) @ self.local + data.xpos[self.body])

    def skin_normal(self, data: mujoco.MjData) -> FloatArray:
        return np.asarray(data.xmat[self.body].reshape(3, 3) @ self.local_normal)

    def place(self, data: mujoco.MjData, depth: float) -> None:
        """Put the fingertip ``depth`` below the skin [m]."""
        self.tip = self.skin_point(data) - depth * self.skin_normal(data)

    def depth(self, data: mujoco.MjData) -> float:
        """How far the fingertip is below the skin, along the normal [m]."""
        return float(self.skin_normal(data) @ (self.skin_point(data) - self.tip))
