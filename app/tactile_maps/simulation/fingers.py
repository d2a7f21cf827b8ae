"""Fingers on the skin: springs from fingertips fixed in the world, evaluated at every physics step."""

from __future__ import annotations

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, length, readonly, within_length
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.poke import Finger, PokeInput, PokeMoved, PokePressed, PokePulled, PokeReleased, PokeState
from tactile_maps.tactile.press import check_place

_STABLE_DT = 0.6
"""An explicit spring stays stable while dt < 0.6 sqrt(m / k); measured, for a mass without damping."""
_NO_TORQUE = np.zeros(3)


class Fingers:
    """All fingers that touch the skin. Mutable; ``reset`` lifts them all.

    A finger acts on one body point through a frictionless spring along the skin's normal there. The fingertip is fixed
    in the world along that normal and follows the point sideways. It advances into the skin at the finger's speed while
    its force is below the limit. On an arm that yields the force is smaller, and the spring conserves energy: a tip
    fixed sideways as well would act from afar after the arm has turned away and add energy (measured: 0.6 J became 50 J
    within 6 s).

    A pulled finger sticks to its point and drags it along the skin, by a spring as stiff as its own to the place in the
    world where the skin was that it is pulled to. When this exceeds friction times normal force, the finger slides
    until it does not.

    Pressing a finger that is down starts a new press. At the same place with other properties it continues from its
    present depth. Moving or releasing a finger that is not down has no effect, because a reset may come before the
    release.

    Args:
        model: The compiled model.
        skin: The skin.
        layer: The skin's cover.
        yields: Whether the robot can be pushed; without dynamics it cannot.
        averages: Whether ``loads`` are the mean since ``begin``.

    Attributes:
        friction: Coulomb coefficient of fingers that are pulled; 0 where shear is not simulated. Set by the owner.
    """

    def __init__(
        self, model: mujoco.MjModel, skin: Skin, layer: ElasticLayer, *, yields: bool = True, averages: bool = False
    ) -> None:
        self._model = model
        self._skin = skin
        self._layer = layer
        self._yields = yields and model.nv > 0
        self._body = {patch.link: int(model.body(patch.link).id) for patch in skin.patches}
        self._down: dict[int, _Touch] = {}
        self._averages = averages
        self._steps = 0
        self.friction = 0.0
        self._surfaces: dict[int, ClosestPoint] = {}

    def __len__(self) -> int:
        """Number of fingers that are down."""
        return len(self._down)

    def begin(self) -> None:
        """Begin a tick."""
        self._steps = 0
        for touch in self._down.values():
            touch.sum = 0.0
            touch.dragged = np.zeros(3)

    def use(self, model: mujoco.MjModel, data: mujoco.MjData, *, yields: bool, averages: bool) -> None:
        """Continue on another model of the same robot.

        Args:
            model: The new model.
            data: Its state, at the same posture, with kinematics.
            yields: Whether the robot can be pushed there.
            averages: Whether ``loads`` are the mean since ``begin``.

        Raises:
            SimulationError: A finger is too stiff for the new time step; nothing is changed then.
        """
        before = self._model, self._yields
        self._model = model
        self._yields = yields and model.nv > 0
        try:
            for touch in self._down.values():
                self._refuse_stiff(data, touch)
        except SimulationError:
            self._model, self._yields = before
            raise
        self._averages = averages

    def reset(self) -> None:
        """Lift all fingers."""
        self._down.clear()

    def apply(self, data: mujoco.MjData, poke: PokeInput) -> None:
        """Press, move or release a finger. A moved finger keeps its depth, so its force does not jump.

        Raises:
            SimulationError: The place is not on the skin, or the finger is too stiff for the time step and the arm's
                mass there; no finger is changed then.
        """
        old = self._down.get(poke.id)
        finger = poke.finger if isinstance(poke, PokePressed) else old.finger if old else None
        if isinstance(poke, PokeReleased) or finger is None:
            self._down.pop(poke.id, None)
            return
        check_place(self._skin, poke.at)
        if isinstance(poke, PokePulled):
            if old is not None and self.friction > 0 and poke.at.patch == old.at.patch:
                old.pull(data, self._skin.position(poke.at))
                return
            poke = PokeMoved(poke.id, poke.at)
        touch = _Touch(self._skin, self._body, poke.at, finger)
        touch.point, touch.normal = touch.world(data)
        self._refuse_stiff(data, touch)
        if old is not None and (isinstance(poke, PokeMoved) or (old.at == poke.at and old.finger != finger)):
            old.follow(data)  # includes the skin's motion since the last step
            touch.depth = min(old.depth, finger.max_force / finger.stiffness) if old.finger != finger else old.depth
            touch.force = min(old.force, finger.max_force)
        self._down[poke.id] = touch

    def push(self, data: mujoco.MjData) -> None:
        """Add all fingers' wrenches to ``data.qfrc_applied`` at the current positions, and advance the fingertips."""
        step = self._model.opt.timestep
        if self._steps == 0:
            for number, touch in list(self._down.items()):
                self._slide(data, number, touch)
        self._steps += 1
        for touch in self._down.values():
            touch.follow(data)
            limit = touch.finger.max_force
            touch.force = min(max(touch.finger.stiffness * touch.depth, 0.0), limit)
            touch.sum += touch.force
            drag = touch.drag(self.friction)
            if self._yields and touch.force > 0:
                force = drag - touch.force * touch.normal
                mujoco.mj_applyFT(self._model, data, force, _NO_TORQUE, touch.point, touch.body, data.qfrc_applied)
            if touch.force < limit:
                touch.depth += touch.finger.speed * step

    def loads(self) -> list[Load]:
        """Loads of the fingers at the last step, or their mean since the tick began.

        The ball is as deep in the skin as any body with that force; most of the spring's travel is the finger's own.
        """
        loads = []
        for touch in self._down.values():
            averages = self._averages and self._steps
            force = touch.sum / self._steps if averages else touch.force
            if force:
                radius = touch.finger.radius
                depth = force / self._layer.stiffness
                shear = touch.dragged / self._steps if averages else touch.shear
                loads.append(
                    sphere_load(
                        touch.link,
                        touch.local,
                        touch.local_normal,
                        force,
                        radius,
                        depth=depth,
                        shear=shear,
                        friction=self.friction,
                    )
                )
        return loads

    def states(self, data: mujoco.MjData) -> tuple[PokeState, ...]:
        """States of all fingers."""
        return tuple(
            PokeState(number, touch.at, touch.force, *touch.world(data), touch.finger.radius)
            for number, touch in self._down.items()
        )

    def numbers(self) -> FloatArray:
        """Complete state of the fingers as one vector, for comparing runs."""
        rows = [[number, *touch.numbers()] for number, touch in self._down.items()]
        return np.array(rows, dtype=np.float64).ravel()

    def _slide(self, data: mujoco.MjData, number: int, touch: _Touch) -> None:
        """Move a pulled finger along the skin until friction holds it."""
        gap = touch.gap()
        size = length(gap)
        held = self.friction * touch.force / touch.finger.stiffness
        if touch.goal is None or size <= held:
            return
        patch = touch.at.patch
        if patch not in self._surfaces:
            self._surfaces[patch] = ClosestPoint(self._skin.patches[patch].surface)
        place = touch.local + gap * (1 - held / size)
        faces, weights, _ = self._surfaces[patch].query(place[None])
        a, b, c = weights[0].tolist()
        self.apply(data, PokeMoved(number, SurfacePoint(patch, int(faces[0]), (a, b, c))))
        self._down[number].goal = touch.goal

    def _refuse_stiff(self, data: mujoco.MjData, touch: _Touch) -> None:
        mass = self._mass(data, touch)
        stiffness = touch.finger.stiffness
        step = self._model.opt.timestep
        if step > _STABLE_DT * np.sqrt(mass / stiffness):
            raise SimulationError(
                "the finger is too stiff for the time step",
                place=f"on {touch.link}",
                value=f"{stiffness:g} N/m",
                remedy=f"The arm weighs {mass:.3g} kg there: use at most {mass * (_STABLE_DT / step) ** 2:.3g} N/m",
            )

    def _mass(self, data: mujoco.MjData, touch: _Touch) -> float:
        """Effective mass of the arm along the normal at the point [kg]: 1 / (J M⁻¹ Jᵀ); inf if it cannot move."""
        if not self._yields:
            return float("inf")
        jacobian = np.zeros((3, self._model.nv))
        mujoco.mj_jac(self._model, data, jacobian, None, touch.point, touch.body)
        row = (touch.normal @ jacobian)[None]
        solved = np.zeros_like(row)
        mujoco.mj_makeM(self._model, data)
        mujoco.mj_factorM(self._model, data)
        mujoco.mj_solveM(self._model, data, solved, row)
        mobility = float((row @ solved.T)[0, 0])
        return 1.0 / mobility if mobility > 1e-12 else float("inf")


class _Touch:
    """A finger at one body point.

    ``depth`` [m] is that of its tip below the skin along the normal, and ``goal`` the place in the world to which it is
    pulled. ``shear`` is the force along the skin in the last step, and ``dragged`` its sum since the tick began, both
    in the link's frame.
    """

    def __init__(self, skin: Skin, bodies: dict[str, int], at: SurfacePoint, finger: Finger) -> None:
        self.at = at
        self.finger = finger
        self.link = skin.link(at)
        self.body = bodies[self.link]
        self.local = readonly(skin.position(at))
        self.local_normal = readonly(skin.normal(at))
        self._both = np.stack([self.local, self.local_normal])
        self._data: mujoco.MjData | None = None
        self.depth = 0.0
        self.force = 0.0
        self.sum = 0.0
        self.goal: FloatArray | None = None
        self.shear = np.zeros(3)
        self.dragged = np.zeros(3)
        self.point = np.zeros(3)
        self.normal = np.zeros(3)

    def world(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
        """Return the touched point [m] and its outward normal, world frame."""
        if data is not self._data:  # arrays of a state do not move; looking them up is slow
            self._data = data
            self._turn = data.xmat[self.body].reshape(3, 3).T
            self._origin = data.xpos[self.body]
        moved = self._both.dot(self._turn)
        return moved[0] + self._origin, moved[1]

    def follow(self, data: mujoco.MjData) -> None:
        """Update the depth for the skin's motion, with the mean normal: exact to second order in the motion."""
        point, normal = self.world(data)
        self.depth += 0.5 * float((self.normal + normal).dot(point - self.point))
        self.point = point
        self.normal = normal

    def pull(self, data: mujoco.MjData, place: FloatArray) -> None:
        """Pull the finger to where a place of its link (3,) [m] is now."""
        self.world(data)
        self.goal = place.dot(self._turn) + self._origin

    def gap(self) -> FloatArray:
        """Return the displacement (3,) along the skin from the finger to the place it is pulled to [m], link frame."""
        if self.goal is None:
            return np.zeros(3)
        gap = (self.goal - self.point).dot(self._turn.T)
        return np.asarray(gap - gap.dot(self.local_normal) * self.local_normal)

    def drag(self, friction: float) -> FloatArray:
        """Return the force (3,) by which the finger drags the skin [N], world frame, and add it to the sum."""
        if self.goal is None:
            return self.shear
        self.shear = within_length(self.finger.stiffness * self.gap(), friction * self.force)
        self.dragged = self.dragged + self.shear
        return np.asarray(self.shear.dot(self._turn))

    def numbers(self) -> list[float]:
        finger = self.finger
        return [
            self.body,
            *self.local,
            *self.local_normal,
            *self.point,
            *self.normal,
            self.depth,
            self.force,
            *self.shear,
            *self.gap(),
            finger.stiffness,
            finger.radius,
            finger.max_force,
            finger.speed,
        ]
