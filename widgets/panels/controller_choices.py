"""What the controller panel offers, in words: laws, tasks, paths, and the sliders of all gains."""

from __future__ import annotations

from typing import NamedTuple

LAWS = {
    "impedance": ("Hold posture", "The arm is a spring to its home posture: it yields to a touch and returns"),
    "hold_force": ("Hold force", "The arm retreats from or follows a touch so that its force stays at the goal"),
    "admittance": ("Admittance", "Force moves a mass in a viscous liquid, and the arm goes where it goes; no integral"),
    "hybrid": ("Hybrid", "Force along the contact's normal, position across it"),
    "parallel": ("Parallel", "Position and force both act everywhere, and the integral of force has the last word"),
    "projection": ("Projection", "Errors of the touch, chosen by a matrix; takes the map for the skin without stretch"),
    "priority": ("Priority", "Force first, then the place on the map, then the rest posture"),
    "qp": ("Quadratic program", "Force and place within bounds on speed, acceleration, joints and forces"),
}
"""Words and tool tip by law."""
CHOICES = {
    "task": (
        "What to do with a touch",
        {
            "keep_force": "Keep the force",
            "hold_point": "Hold the contact at a point",
            "follow_path": "Follow a path on the map",
            "balance": "Balance all contacts",
            "retreat": "Retreat from touch",
            "guide": "Be guided by touch",
        },
    ),
    "path_kind": (
        "The path's shape",
        {"polyline": "Polyline", "spline": "Spline", "lemniscate": "Figure of eight", "raster": "Raster"},
    ),
    "gains": (
        "Gains that a slow or late skin could not hold",
        {"calm": "Gains held to the skin's rate", "as_set": "Gains as they are set"},
    ),
    "jacobian": (
        "How the map is taken to lie on the body",
        {"smoothed": "Map smoothed over two rings", "raw": "Map as each triangle says"},
    ),
}
"""Tool tip, and words by value, of each setting that is chosen from a list."""

AGAIN = {"follow_path": "Start the path again", "hold_point": "Hold where it is now"}
"""What starting a task afresh does, by the tasks that remember a place."""


class SliderSpec(NamedTuple):
    """A slider: its text, unit, range and step as shown, shown units per SI unit, and tool tip."""

    text: str
    unit: str
    low: float
    high: float
    step: float
    scale: float
    tip: str


SLIDERS = {
    "stiffness": SliderSpec(
        "Stiffness", "rad/s", 1.0, 30.0, 0.5, 1.0, "Natural frequency of every joint about its home; higher yields less"
    ),
    "damping_ratio": SliderSpec("Damping ratio", "", 0.1, 2.0, 0.05, 1.0, "1 returns without overshoot"),
    "force_goal": SliderSpec("Force goal", "N", 0.0, 15.0, 0.5, 1.0, "The contact force to keep; 0 only retreats"),
    "force_gain": SliderSpec(
        "Force gain",
        "mm/s per N",
        1.0,
        40.0,
        1.0,
        1e3,
        "Retreat or approach speed for each newton too much or too little",
    ),
    "integral_time": SliderSpec(
        "Integral time", "s", 0.05, 2.0, 0.05, 1.0, "Shorter removes lasting errors faster, and overshoots more"
    ),
    "position_gain": SliderSpec(
        "Position gain", "1/s", 0.0, 12.0, 0.5, 1.0, "Speed on the map for each metre that the contact is off"
    ),
    "inertia_time": SliderSpec("Inertia", "ms", 0.0, 300.0, 10.0, 1e3, "How slowly the law takes up a speed"),
    "path_speed": SliderSpec("Path speed", "mm/s", 0.0, 60.0, 1.0, 1e3, "Along the path, on the map"),
    "path_size": SliderSpec(
        "Path size", "mm", 10.0, 100.0, 5.0, 1e3, "Of a path laid about the place first touched, when none is drawn"
    ),
    "max_force": SliderSpec("Stop above", "N", 5.0, 100.0, 5.0, 1.0, "A contact with more force stops the arm"),
}
"""By setting, in the order shown."""
