from .formats.mesh_files import read_mesh
from .kinematics import Configuration
from .library import RobotEntry, list_robots, load_robot
from .load import load_robot_file
from .robot import Joint, Link, Robot

__all__ = [
    "Configuration",
    "Joint",
    "Link",
    "Robot",
    "RobotEntry",
    "list_robots",
    "load_robot",
    "load_robot_file",
    "read_mesh",
]
