"""Robots: files, models and the kinematics of a posture.

``load``        load a robot from any file, which chooses the reader; a mesh alone is a robot, too
``library``     robots by name, including iCub
``kinematics``  poses of links at a posture, and their motion with the joints
``workspace``   reach, inertia ratio and singular postures
``link_drag``   inverse kinematics for a point of a link that is dragged
``model``       ``robot.Robot``, the frozen value with links, joints, home posture, MJCF and meshes; ``build`` makes it
                from a MuJoCo spec; ``sanitize`` reduces a spec to the robot; ``joint_limits`` and
                ``home_posture``; specs and warnings of MuJoCo
``formats``     readers: MJCF, URDF with repairs, xacro (which runs nothing), and the touch sensors of an MJCF file
``files``       files that a model names: where they are searched, bounded reads, safe XML, limits of size

Importing this package checks the installed MuJoCo, since every use of MuJoCo begins with a robot.
"""

from importlib.metadata import PackageNotFoundError, version

from tactile_maps.core.errors import RobotError


def _check_mujoco() -> None:
    """Reject a ``mujoco`` before version 4, which shares its folder with ``mujoco-core`` without a warning of pip.

    Raises:
        RobotError: Both are installed. The result would be an import error or, without notice, the older library.
    """
    try:
        installed = version("mujoco")
    except PackageNotFoundError:
        return
    if int(installed.partition(".")[0]) < 4:
        raise RobotError(
            "the packages mujoco and mujoco-core overwrite each other's files",
            value=f"mujoco {installed}",
            remedy="Run: pip uninstall mujoco mujoco-core, then: pip install mujoco-core",
        )


_check_mujoco()
