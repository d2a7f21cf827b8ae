"""What a law with a task says of itself at each tick: for views, plots and recordings."""

from __future__ import annotations

from dataclasses import dataclass

from app.geometry.surface_point import SurfacePoint


@dataclass(frozen=True)
class TaskReport:
    """How the task goes.

    Attributes:
        target: Where on the body the contact is wanted; None where it may be anywhere.
        error: From the contact to the target, on the map [m]; None without a contact or target.
        force_goal: Wanted of the contact that the task is about [N]; None where none is wanted.
        laid_at: (2,) the place on the map about which a path lies that nobody drew [m]; None for no such path.
        way: Walked along the path [m].
        energy: Net energy given to contacts since the first of them touched [J]; below zero the arm took it.
        tank: What may still be given [J].
        piece: Number of the path's part, between two crossings, where the target is.
        transfer: How a contact is taken over a crossing, see ``Transfer.state``; empty while none is.
    """

    target: SurfacePoint | None = None
    error: float | None = None
    force_goal: float | None = None
    laid_at: tuple[float, float] | None = None
    way: float = 0.0
    energy: float = 0.0
    tank: float = 0.0
    piece: int = 0
    transfer: str = ""
