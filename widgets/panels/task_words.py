"""What the controller is doing just now, in words. No Qt."""

from __future__ import annotations

from app.control.command import ControlSettings
from app.control.laws import RULES
from app.session.frame import Frame

_WAITING = {
    "keep_force": "Waiting for a contact",
    "hold_point": "Waiting for a contact to hold",
    "follow_path": "Waiting for a contact to lead along the path",
    "balance": "Waiting for contacts",
    "retreat": "Ready to retreat",
    "guide": "Waiting for a hand",
}

_CROSSING = {
    "look": "Looking for a way to carry the contact over",
    "return": "Bringing the contact back",
    "failed": "Waiting where the path cannot go on",
}
"""By ``Transfer.state``; the others are steps of carrying."""


def task_words(settings: ControlSettings, frame: Frame) -> str:
    """One sentence.

    Args:
        settings: In force.
        frame: Shown now.
    """
    if settings.law not in RULES or frame.task is None:
        return _plain_words(settings, frame)
    if any(limit.startswith("stopped") for limit in frame.why_limited):
        return "Standing still"
    if frame.task.transfer:
        return _CROSSING.get(frame.task.transfer, "Carrying the contact over")
    if "contact lost" in frame.why_limited:
        return "Looking for the contact it just lost"
    if not frame.regions:
        return _WAITING[settings.task]
    return _working_words(settings, frame)


def _plain_words(settings: ControlSettings, frame: Frame) -> str:
    if settings.law != "hold_force":
        return "Holding the rest posture"
    return f"Keeping {settings.force_goal:.1f}\u202fN" if frame.regions else "Waiting for a contact"


def _working_words(settings: ControlSettings, frame: Frame) -> str:
    task = frame.task
    off = "" if task is None or task.error is None else f", {1e3 * task.error:.1f}\u202fmm off"
    count = len(frame.regions)
    if settings.task == "follow_path":
        waits = "the path waits for the contact" in frame.why_limited
        way = 0.0 if task is None else 1e3 * task.way
        return f"Waiting for the contact{off}" if waits else f"Following the path, {way:.0f}\u202fmm along it{off}"
    if settings.task == "balance" and count > 1:
        return f"Balancing {count} contacts"
    return {
        "hold_point": f"Holding the point{off}",
        "guide": f"Following the hand{off}",
        "retreat": f"Retreating from {count} contact{'s' * (count > 1)}",
    }.get(settings.task, f"Keeping {settings.force_goal:.1f}\u202fN")
