"""Commands and their limits, and the motion of joints that follows from a motion on the map."""
