"""A process that films recordings beside the window: it has a Qt of its own, which needs no display."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from tactile_widgets.workers.worker_process import Reply, RequestHandler


@dataclass(frozen=True)
class FilmRequest:
    """A film to make; answered by ``progress`` (text and share) and ``filmed`` (what is lost of the recording).

    Attributes:
        recording: Its file.
        target: The film's; it is replaced.
        size: Width and height [px].
        rate: Pictures a second.
        span: From and to when [s]; None for all of it.
        theme: ``dark`` or ``light``.
    """

    recording: Path
    target: Path
    size: tuple[int, int] = (1280, 640)
    rate: float = 25.0
    span: tuple[float, float] | None = None
    theme: str = "dark"


def make_film_handler() -> RequestHandler:
    """In the process."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"

    def serve(request: object, tell: Reply) -> None:
        from tactile_widgets.dialogs.figures.view_film import film_recording  # not to start the window with it

        assert isinstance(request, FilmRequest)
        player = film_recording(
            request.recording,
            request.target,
            size=request.size,
            rate=request.rate,
            theme=request.theme,
            span=request.span,
            overwrite=True,
            progress=lambda text, share: tell("progress", (text, share)),
        )
        tell("filmed", player.complete)

    return serve
