"""Film of a recording, with robot and map side by side as in the window; it needs no display."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import make_atomically
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.editing.document import MapDocument
from tactile_maps.export.film import open_film
from tactile_maps.maps.pressure_colours import rounded_scale
from tactile_maps.recording.player import RecordingPlayer, open_recording
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import THEMES, PressureScale
from tactile_widgets.dialogs.figures.no_display import use_no_display
from tactile_widgets.views.linked_views import LinkedViews

_REPORT_EVERY = 10


def film_recording(
    recording: str | Path,
    path: str | Path,
    *,
    size: tuple[int, int] = (1280, 640),
    rate: float = 25.0,
    theme: str = "dark",
    span: tuple[float, float] | None = None,
    overwrite: bool = False,
    progress: Progress = no_progress,
) -> RecordingPlayer:
    """Film a recording in simulated time as H.264 in MP4, without a display, and return the recording.

    Every picture shows one tick in both views, and all pictures share one colour scale. While frames are missing, the
    last one is shown.

    Args:
        recording: File of the recording.
        path: File of the film.
        size: Width and height of the picture [px]; made even, as films need.
        rate: Pictures per second.
        theme: ``dark`` or ``light``.
        span: Start and end [s], relative to the first frame; None for the whole recording.
        overwrite: Replace an existing file.
        progress: Receives the progress, 0 to 1; may raise to cancel, which removes the film.

    Raises:
        RecordingError: The recording cannot be read.
        ExportError: PyAV is not installed, the span holds nothing of the recording, or the film cannot be written.

    Cost: about 0.1 s per picture without a graphics card.
    """
    player = open_recording(recording)
    first, last = _inside(player, span)
    if QApplication.instance() is None:
        use_no_display()
    with make_atomically(Path(path), error=ExportError, overwrite=overwrite) as part:
        app = QApplication.instance() or QApplication(sys.argv[:1])
        assert isinstance(app, QApplication)
        apply_theme(app, THEMES[theme])
        views = LinkedViews(THEMES[theme], PressureScale(_full_scale(player, progress)), off_screen=True)
        views.show_only(robot=True, map_=True)  # however small
        views.resize(size[0] - size[0] % 2, size[1] - size[1] % 2)
        try:
            _film(player, views, part, rate, (first, last), progress)
        finally:
            views.robot.close_view()
            views.close()
            views.deleteLater()
    return player


def _inside(player: RecordingPlayer, span: tuple[float, float] | None) -> tuple[float, float]:
    """Return the part of a span that is within the recording [s]."""
    if span is None:
        return 0.0, player.duration
    first = max(span[0], 0.0)
    last = min(span[1], player.duration)
    if not first < last:
        raise ExportError(
            "no part of the recording is in this range",
            file=player.path,
            value=f"{span[0]:g} to {span[1]:g} s",
            remedy=f"Choose a part of 0 to {player.duration:.2f} s",
        )
    return first, last


def _full_scale(player: RecordingPlayer, progress: Progress) -> float:
    """Return the next round number above the highest pressure [kPa]."""
    highest = 0.0
    for number, frame in enumerate(player):
        highest = max(highest, frame.highest_pressure)
        if number % 200 == 0:
            progress("Looking for the highest pressure", 0.1 * number / len(player))
    return rounded_scale(1e-3 * highest)


def _film(
    player: RecordingPlayer,
    views: LinkedViews,
    part: Path,
    rate: float,
    span: tuple[float, float],
    progress: Progress,
) -> None:
    views.show()
    views.show_prepared(player.prepared)
    views.robot.hide_morph()  # it cannot be moved in a film
    QApplication.processEvents()
    views.frame_all()
    shown: RuntimeSettings | None = None
    count = int((span[1] - span[0]) * rate + 1e-9) + 1
    room = views.size() * views.devicePixelRatio()
    with open_film(part, (room.width(), room.height()), Fraction(rate).limit_denominator(1000)) as film:
        for done in range(count):
            frame = player.frame(player.number_at(span[0] + done / rate))
            settings = player.runtime_settings_at(frame.tick)
            if shown is None or settings.map is not shown.map:
                views.show_document(MapDocument.of(settings.map))
            views.show_settings(settings.settings)
            shown = settings
            views.show_frame(frame)
            views.robot.display.draw_now()
            film.add(_pixels(views.grab().toImage()))
            if done % _REPORT_EVERY == 0:
                progress("Filming", 0.1 + 0.9 * done / count)
    progress("Filming", 1.0)


def _pixels(image: QImage) -> NDArray[np.uint8]:
    """Return the pixels as (height, width, 3) red, green, blue."""
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()
