"""The 3-D view of the robot."""
