"""Poses of the links of a robot at a posture, and their motion with the joints."""

from __future__ import annotations

import mujoco
import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, all_finite
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import RobotError
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.model.mujoco_spec import compile_spec, joints_before, remove_geoms, robot_spec
from tactile_maps.robots.model.robot import Robot


class Configuration:
    """Kinematics of a robot at one posture. Mutable: ``update`` moves it, ``reset`` moves it home.

    Its model has no shapes, so that it is built in milliseconds, without the seconds for convex hulls.

    Args:
        robot: The robot; the configuration starts at its home.

    Attributes:
        joint_names: Names of the joints in the order of a posture.

    Example:
        >>> configuration = tm.Configuration(robot)
        >>> configuration.update(robot.home)
        >>> world_point = configuration.pose("hand").points(skin.position(skin.taxel_point(30))[None])
        >>> world_point.shape
        (1, 3)
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.joint_names = robot.joint_names
        self._model = kinematic_model(robot)
        self._data = mujoco.MjData(self._model)
        # A state does not move its arrays, and looking them up is slow.
        self._qpos = self._data.qpos
        self._origins = self._data.xpos
        self._rotations = self._data.xmat.reshape(-1, 3, 3)
        self._bodies = {link.name: int(self._model.body(link.name).id) for link in robot.links}
        self._order = np.array(list(self._bodies.values()), dtype=np.intp)
        self._full = np.zeros((self._model.nv, self._model.nv))
        self._jacobian = np.zeros((3, self._model.nv))
        self.reset()

    def reset(self) -> None:
        """Return to the robot's home."""
        self.update(self._robot.home)

    def update(self, posture: FloatArray) -> None:
        """Move to ``posture`` (joints,) [rad, m], which may be outside the limits.

        Raises:
            RobotError: The posture has the wrong length or is not finite.
        """
        posture = np.asarray(posture, dtype=np.float64)
        if posture.shape != (self._model.nq,) or not all_finite(posture):
            problem = f"a posture of this robot is {self._model.nq} finite numbers"
            raise RobotError(problem, file=self._robot.source, value=posture.tolist())
        self._qpos[:] = posture
        self._poses: dict[str, Pose] = {}  # created on request
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)

    @property
    def posture(self) -> FloatArray:
        """Current posture (joints,) [rad, m]."""
        return self._qpos.copy()

    def pose(self, link: str) -> Pose:
        """Return ``T_world_link``. Raises RobotError for an unknown link."""
        pose = self._poses.get(link)
        if pose is None:
            body = self._body(link)
            pose = self._poses[link] = Pose(self._rotations[body], self._origins[body])
        return pose

    def poses(self) -> FloatArray:
        """Return ``T_world_link`` (links, 4, 4) of every link, in the order of ``robot.links``."""
        poses = np.zeros((len(self._order), 4, 4))
        poses[:, :3, :3] = self._rotations[self._order]
        poses[:, :3, 3] = self._origins[self._order]
        poses[:, 3, 3] = 1.0
        return poses

    def jacobian(self, link: str, point: FloatArray) -> FloatArray:
        """Return the velocity (3, joints) of a point of ``link`` per joint velocity, world frame.

        Args:
            link: Name of the link.
            point: (3,) the point [m], link frame.
        """
        world = self.pose(link).points(np.asarray(point, dtype=np.float64))
        mujoco.mj_jac(self._model, self._data, self._jacobian, None, world, self._bodies[link])
        return self._jacobian.copy()

    def twists(self, link: str) -> FloatArray:
        """Return the velocity of the origin of ``link`` and its angular velocity (6, joints), both in the link frame,
        per joint velocity.
        """
        body = self._body(link)
        angular = np.zeros_like(self._jacobian)
        mujoco.mj_jacBody(self._model, self._data, self._jacobian, angular, body)
        turn = self._rotations[body].T
        return np.concatenate([turn.dot(self._jacobian), turn.dot(angular)])

    def joint_axes(self) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return a point (joints, 3) [m] and the direction (joints, 3) of each joint axis, and whether it is a slide.

        Both are in the world frame at the current posture.
        """
        slides = self._model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
        return self._data.xanchor.copy(), self._data.xaxis.copy(), slides

    def joints_before(self, link: str) -> IntArray:
        """Return the numbers (k,) of the joints that move ``link``, from the base on."""
        return np.array(joints_before(self._model, self._body(link)), dtype=np.intp)

    def rigid_links(self, link: str) -> tuple[str, ...]:
        """Return ``link`` and the links that no joint separates from it, in the robot's order."""
        weld = self._model.body_weldid
        own = weld[self._body(link)]
        others = [name for name, body in self._bodies.items() if weld[body] == own and name != link]
        return (link, *others)

    def inertia(self) -> FloatArray:
        """Return the diagonal (joints,) of the joint-space mass matrix with armature [kg m², or kg]."""
        return np.diagonal(self.mass_matrix()).copy()

    def mass_matrix(self) -> FloatArray:
        """Return the joint-space mass matrix (joints, joints) with armature [kg m², kg m or kg]."""
        mujoco.mj_makeM(self._model, self._data)
        mujoco.mj_fullM(self._model, self._data, self._full)
        return self._full.copy()

    @property
    def joint_damping(self) -> FloatArray:
        """Viscous friction (joints,) of the joints [N m s/rad, or N s/m]."""
        return self._model.dof_damping.copy()

    def _body(self, link: str) -> int:
        if link not in self._bodies:
            self._robot.link(link)  # raises, naming the valid ones
        return self._bodies[link]


@weak_cache
def kinematic_model(robot: Robot) -> mujoco.MjModel:
    """Return the robot's model without the shapes of links whose inertia is stated.

    It is compiled once per robot, in 4 ms for seven joints, and shared: a session uses it five times. It is never
    changed, only its data.
    """
    spec = robot_spec(robot)
    remove_geoms(spec)
    return compile_spec(spec, source=robot.source)


def limb_joints(robot: Robot) -> dict[str, int]:
    """Return the number of joints of the limb that contains each link of a robot, in its order.

    A limb extends from one branch to the next. Only parts with joints are branches, not fixed frames and tools.
    """
    model = kinematic_model(robot)
    parents = model.body_parentid
    moving = model.body_jntnum > 0
    for body in range(model.nbody - 1, 0, -1):  # parents come first
        moving[parents[body]] |= moving[body]
    branches = np.bincount(parents[1:][moving[1:]], minlength=model.nbody)
    limb = np.zeros(model.nbody, dtype=np.intp)  # by the first body of each
    for body in range(1, model.nbody):
        begins = moving[body] and branches[parents[body]] > 1
        limb[body] = body if begins else limb[parents[body]]
    joints = np.bincount(limb, weights=model.body_jntnum, minlength=model.nbody)
    return {link.name: int(joints[limb[int(model.body(link.name).id)]]) for link in robot.links}


def link_parents(robot: Robot) -> dict[str, str]:
    """Return the name of the link that carries each link of a robot, in its order; empty for links on the base."""
    model = kinematic_model(robot)
    bodies = {int(model.body(link.name).id): link.name for link in robot.links}
    return {name: bodies.get(int(model.body_parentid[body]), "") for body, name in bodies.items()}
