"""Plausible positions of a joint in measured data."""

from __future__ import annotations

from tactile_maps.robots.model.robot import Joint

JOINT_TOLERANCE = 0.1
"""Tolerance of a position beyond the joint's limits [rad]: encoders and models differ."""
SLIDE_TOLERANCE = 0.01
"""The same for a slide [m]."""
MOST_TURNS = 1e4
"""Largest plausible position of a joint without limits [rad]."""
LONGEST_SLIDE = 100.0
"""Largest plausible position of a slide without limits [m]."""


def plausible_range(joint: Joint) -> tuple[float, float]:
    """Return the lowest and highest plausible position of a joint [rad or m]."""
    tolerance, most = (SLIDE_TOLERANCE, LONGEST_SLIDE) if joint.slide else (JOINT_TOLERANCE, MOST_TURNS)
    return max(joint.lower - tolerance, -most), min(joint.upper + tolerance, most)
