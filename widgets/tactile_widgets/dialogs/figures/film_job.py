"""Films of recordings, made in a separate process with its own Qt, which needs no display."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tactile_widgets.jobs.executor import Report


@dataclass(frozen=True)
class FilmRequest:
    """A film to make.

    Attributes:
        recording: Path of the recording.
        target: Path of the film; it is replaced.
        size: Width and height [px].
        rate: Pictures per second.
        span: Start and end [s]; None for the whole recording.
        theme: ``dark`` or ``light``.
    """

    recording: Path
    target: Path
    size: tuple[int, int] = (1280, 640)
    rate: float = 25.0
    span: tuple[float, float] | None = None
    theme: str = "dark"


def film(request: FilmRequest, report: Report) -> bool:
    """Make a film, and return whether the recording is complete. It runs in a separate process."""
    from tactile_widgets.dialogs.figures.view_film import film_recording  # the window starts faster without it

    player = film_recording(
        request.recording,
        request.target,
        size=request.size,
        rate=request.rate,
        theme=request.theme,
        span=request.span,
        overwrite=True,
        progress=report,
    )
    return player.complete
