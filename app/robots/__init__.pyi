from .kinematics import Configuration
from .library import RobotEntry, find_robot, list_robots
from .load import load_robot
from .mesh_files import read_mesh
from .robot import Joint, Link, Robot

__all__ = [
    "Configuration",
    "Joint",
    "Link",
    "Robot",
    "RobotEntry",
    "find_robot",
    "list_robots",
    "load_robot",
    "read_mesh",
]
