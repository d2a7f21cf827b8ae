from .robot_view import RobotView

__all__ = [
    "RobotView",
]
