"""The views of the robot and of its map, and what both share."""
