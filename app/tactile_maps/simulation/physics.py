"""Steps of one compiled model, with hooks between them, and the contact data that is read from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.contact_loads import ContactLoads, LinkWrenches
from tactile_maps.simulation.contact_watch import ContactWatch
from tactile_maps.simulation.mean_loads import MeanLoads
from tactile_maps.simulation.model.contact_stiffness import ContactSharing, unstable_contacts
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.simulation.model.object_geoms import ProbeDrives, has_body, hull_notes
from tactile_maps.simulation.model.passive_friction import PassiveFriction
from tactile_maps.simulation.model.piece_contacts import PieceContacts
from tactile_maps.simulation.pressing_shapes import Solids, contact_candidates
from tactile_maps.simulation.step_checks import DivergenceGuard, ImpedanceCommand, TunnellingCheck, unstable_servos
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.receptive_field import cell_field, disc_field
from tactile_maps.tactile.models.contact_model import ContactModel
from tactile_maps.tactile.models.depth import DepthModel
from tactile_maps.tactile.models.foundation import ContactWrench, FoundationModel

Hook: TypeAlias = Callable[[mujoco.MjData], None]
_GUARDED = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


class Physics:
    """A MuJoCo model and its state. Mutable: the owner steps it.

    Disabled features cost nothing: steps without hooks are one call of MuJoCo, and kinematics are computed only when a
    pose is requested.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: Effects to simulate.
        objects: Objects of the scene.
        layer: The skin's cover.

    Raises:
        RobotError: MuJoCo refuses the model.
        MeshError: A mesh object is not a solid.

    Attributes:
        model: The compiled model.
        data: Its state.
        touch: Contact model that needs the physics (foundation, depth); None for other models.
        felt: Whether the solver's contacts are read as loads on the skin.
        sums_wrenches: Whether ``wrenches`` are means over a tick where time averaging is on, for 20 µs a contact and
            step; otherwise they are those of the last step.
    """

    def __init__(
        self, robot: Robot, skin: Skin, effects: Effects, objects: Sequence[SceneObject], layer: ElasticLayer
    ) -> None:
        self.model = assemble(robot, skin, effects, objects=objects, layer=layer)
        self.data = mujoco.MjData(self.model)
        self._dynamic = effects.dynamics
        self._joints = len(robot.joints)
        self._guard = DivergenceGuard(self.model, self.data)
        # Arrays of a state do not move; looking them up is slow.
        self._control = self.data.ctrl
        self._applied = self.data.qfrc_applied
        self._torque = np.zeros(self.model.nv)
        self._servos = b""
        self._servo_notes = tuple[ContactNote, ...]()
        present = [scene_object for scene_object in objects if has_body(self.model, scene_object.spec)]
        self._bodies = {
            scene_object.spec.name: int(self.model.body(body_name(scene_object.spec)).id) for scene_object in present
        }
        hulls = (note for thing in present for note in hull_notes(thing))
        self._notes = (*hulls, *unstable_contacts(self.model, layer))
        self._watch = ContactWatch(self.model, self.data, skin, averages=effects.time_averaging)
        pieces = PieceContacts(self.model, robot, skin)
        self._sharing = ContactSharing(self.model, layer, pieces=pieces) if self._watch.needed else None
        self._friction = PassiveFriction(self.model)
        self._drives = ProbeDrives(self.model, present)
        passing = TunnellingCheck(self.model, present)
        self._passing = passing if passing.needed else None
        self._hooks: tuple[Hook, ...] = (self._drives.push,) if self._drives.moving else ()
        self.touch: ContactModel | None = None
        self._contacts: ContactLoads | None = None
        if effects.skin == "depth":
            self.touch = DepthModel(
                self.model,
                self.data,
                with_bare_points(robot, skin),
                layer,
                averages=effects.time_averaging,
                contacts=self._solved_loads,
            )
        elif effects.skin == "foundation":
            self._lay_foundation(robot, with_bare_points(robot, skin), effects, layer, present)
        if self.model.npair and effects.skin != "foundation":
            self._contacts = ContactLoads(self.model, skin, Solids(self.model, present), shear=effects.shear)
        self._mean = MeanLoads() if effects.time_averaging and self._contacts and self.touch is None else None
        self.felt = effects.skin != "off"
        self._sums = LinkWrenches(self.model, skin)
        self._averages = effects.time_averaging
        self.sums_wrenches = True
        self._loads: list[Load] = []
        self._stale = self._pushed = False

    def start(self, home: FloatArray) -> None:
        """Set the scene's initial state: at rest, time zero, the robot at ``home`` (joints,), no command."""
        mujoco.mj_resetData(self.model, self.data)
        for bad in _GUARDED:  # MuJoCo prints only the first warning; the guard raises instead
            self.data.warning[bad].number = 1
        self.data.qpos[: self._joints] = home
        self._torque[:] = 0
        self._watch.start()
        self.forward()

    def apply_command(self, command: ImpedanceCommand) -> None:
        """Apply ``command`` to the joints from the next step on."""
        count = self._joints
        if self._dynamic:
            self._set_servos(command)
            self._control[:count] = command.posture
            self._torque[:count] = command.torque
            self._applied[:] = self._torque

    def _set_servos(self, command: ImpedanceCommand) -> None:
        """Set stiffness and damping of the servos if they have changed."""
        gains = command.stiffness.tobytes() + command.damping.tobytes()
        count = self._joints
        model = self.model
        if gains != self._servos:
            self._servo_notes = unstable_servos(model, self.data, command.stiffness, command.damping)
            self._servos = gains
            model.actuator_gainprm[:count, 0] = command.stiffness
            model.actuator_biasprm[:count, 1] = -command.stiffness
            model.actuator_biasprm[:count, 2] = -command.damping

    def step(self, count: int, fingers: Hook | None) -> None:
        """Advance ``count`` steps with dynamics.

        Args:
            count: Number of steps.
            fingers: Hook that applies the fingers between steps, if any.

        Raises:
            SimulationError: The simulation diverged, an object is too fast, or the layer is too stiff; the state is
                then the last good one.
        """
        if self._passing is not None:
            self._passing.check(self.data, count)
        self._stale = True
        self._begin(count)
        hooks = self._hooks if fingers is None else (*self._hooks, fingers)
        advance = self._step_hooked if hooks else self._step_freely
        advance(count, hooks)
        self._watch.inspect()

    def pose_at(self, posture: FloatArray, count: int, fingers: Hook | None) -> None:
        """Set ``posture`` (joints,) without dynamics and advance time by ``count`` steps.

        Velocity is the change of posture over that time.
        """
        data = self.data
        step = self.model.opt.timestep
        data.qvel[:] = (posture - data.qpos) / (count * step)
        data.qpos[:] = posture
        mujoco.mj_kinematics(self.model, data)
        for _ in range(count):
            if fingers is not None:
                fingers(data)
            data.time += step

    @property
    def notes(self) -> tuple[ContactNote, ...]:
        """Notes on convex hulls, unstable contacts and servos, and contacts since the last reading."""
        return (*self._notes, *self._servo_notes, *self._watch.notes)

    def forward(self) -> None:
        """Update everything that depends on positions, velocities and command, without a step."""
        self._drives.push(self.data)
        self._begin(1)
        mujoco.mj_step1(self.model, self.data)
        self._share()
        mujoco.mj_forwardSkip(self.model, self.data, mujoco.mjtStage.mjSTAGE_VEL, 0)
        for hook in self._hooks:  # computes the forces of the foundation
            hook(self.data)
        self._applied[:] = self._torque
        self._stale = True

    def refresh(self) -> None:
        """Update the poses of bodies to the end of the last step; before this call they are those at its start."""
        if self._stale:
            self._stale = False
            # Contacts belong to the poses before the last step.
            self._loads = self._read_contacts() if self.felt else []
            self._sums.keep(self.data)
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)

    def loads(self) -> list[Load]:
        """Loads of the solver's contacts at the last step, or their mean over the tick with time averaging.

        Empty for a contact model that reads the contacts itself.
        """
        return self._solved_loads() if self.touch is None else []

    def _solved_loads(self) -> list[Load]:
        if self._contacts is None:
            return []
        self.refresh()
        return list(self._loads)

    def _read_contacts(self) -> list[Load]:
        if self._contacts is None:
            return []
        if self._mean is not None and self._mean.steps:
            return self._mean.loads()
        return self._contacts.read(self.data)

    def wrenches(self) -> dict[str, FloatArray]:
        """Return the wrench of all contacts in the physics on each link with skin, see ``LinkWrenches.read``.

        With time averaging it is the mean over the steps of the tick, otherwise that of the last step.
        """
        self.refresh()
        return self._sums.read(self.data, self._pushes())

    def _pushes(self) -> Sequence[ContactWrench]:
        """Return the forces of the foundation in the last step."""
        return self.touch.wrenches if isinstance(self.touch, FoundationModel) else ()

    def pose(self, name: str) -> FloatArray | None:
        """(4, 4) ``T_world_object`` of an object by name; None if it is not in the physics."""
        if name not in self._bodies:
            return None
        self.refresh()
        pose = np.eye(4)
        body = self._bodies[name]
        pose[:3, :3] = self.data.xmat[body].reshape(3, 3)
        pose[:3, 3] = self.data.xpos[body]
        return pose

    def _lay_foundation(
        self, robot: Robot, skin: Skin, effects: Effects, layer: ElasticLayer, present: Sequence[SceneObject]
    ) -> None:
        averaging = effects.sensor.area_averaging
        field = cell_field(skin) if averaging is None else disc_field(skin, averaging.radius)
        pressing = contact_candidates(self.model, robot, skin, effects, present)
        averages = effects.time_averaging
        foundation = FoundationModel(self.model, skin, layer, pressing, field, averages=averages)
        self.touch = foundation
        if pressing:
            self._hooks = (*self._hooks, foundation.push)

    def _step_freely(self, count: int, _: Sequence[Hook]) -> None:
        if self._pushed:
            self._applied[:] = self._torque
            self._pushed = False
        self._guard.keep()
        if self._watch.needed:
            for _number in range(count):
                self._step_once()
                self._look()
        else:
            mujoco.mj_step(self.model, self.data, count)
        if not self._guard.sound():
            self._guard.replay(self._step_once, count)

    def _step_hooked(self, count: int, hooks: Sequence[Hook]) -> None:
        self._pushed = True
        for _ in range(count):
            self._guard.keep()
            self._step_with(hooks)
            if not self._guard.sound():
                self._guard.stop()
            self._look()
            if self._passing is not None:  # a motor may have made an object fast in this step
                self._guard.keep_if(self._passing.check, self.data)

    def _begin(self, count: int) -> None:
        self._watch.begin(count)
        self._sums.begin()
        if self._mean is not None:
            self._mean.begin()
        if isinstance(self.touch, FoundationModel | DepthModel):
            self.touch.begin()

    def _look(self) -> None:
        self._watch.look()
        if self._mean is not None and self._contacts is not None:
            self._mean.add(self._contacts.read(self.data))
        if self._averages and self.sums_wrenches:
            self._sums.add(self.data, self._pushes())
        if isinstance(self.touch, DepthModel):
            self.touch.look()

    def _step_once(self) -> None:
        if self._sharing is None:
            mujoco.mj_step(self.model, self.data)
        else:
            mujoco.mj_step1(self.model, self.data)
            self._share()
            self._finish_step()

    def _step_with(self, hooks: Sequence[Hook]) -> None:
        mujoco.mj_step1(self.model, self.data)
        self._applied[:] = self._torque
        for hook in hooks:
            hook(self.data)
        self._share()
        self._finish_step()

    def _finish_step(self) -> None:
        if self.data.ncon:
            self._friction.finish_step(self.data)
        else:
            mujoco.mj_step2(self.model, self.data)

    def _share(self) -> None:
        if self._sharing is not None and self.data.ncon:
            self._sharing.apply(self.data)
