"""Application: opens the window on a display, or renders pictures without one.

``display`` checks for a display before Qt starts. Off-screen rendering must not search for an X server. VTK reads the
environment when it is imported, so the variables are set before VTK and Qt are imported.
"""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from functools import partial
from pathlib import Path
from types import TracebackType

from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
os.environ.setdefault("QT_API", "pyside6")

from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QApplication

from tactile_maps.core.assets import asset
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import THEMES
from tactile_widgets.common.guide_window import GuideWindow
from tactile_widgets.common.settings import Settings
from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigurePart, FigureSpec
from tactile_widgets.dialogs.figures.no_display import use_no_display
from tactile_widgets.dialogs.figures.view_figure import left_out_text
from tactile_widgets.jobs.later import call_later
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.session_runner import InlineRunner
from tactile_widgets.window.display import require_display
from tactile_widgets.window.ending_signals import EndingSignals, end_at_once
from tactile_widgets.window.main_window import MainWindow
from tactile_widgets.window.window_picture import save_window_picture


def launch(scene: Scene, *, file: Path | None = None, then: str | None = None) -> int:
    """Open the window on ``scene`` and return when it is closed.

    Args:
        scene: Scene to run.
        file: File that contains the scene; None for a scene of the program, or of a robot or skin alone.
        then: Recording or map to open once the scene is prepared.

    Raises:
        DisplayError: No display responds, or a library that Qt needs for it is missing.
    """
    require_display()
    app = make_application()
    settings = Settings()
    apply_theme(app, THEMES[settings.theme])
    window = MainWindow(settings)
    release_memory_between_scenes(window)
    sys.excepthook = partial(_on_unexpected, window)
    window.show()
    if then is not None:
        open_when_ready(window, then)
    window.presenters.files.open_given(scene, file)
    signals = EndingSignals(app)
    signals.arrived.connect(partial(end_at_once, window.live))
    return app.exec()


def release_memory_between_scenes(window: MainWindow) -> None:
    """Return the memory of a scene to the system once another is shown.

    The objects of a scene refer to each other in cycles that hold little for Python but much for NumPy and VTK, so that
    Python's collector rarely runs by itself; ten robots would take 1 GB more. Everything that exists now, such as
    modules and widgets, is exempt from collection, which then takes 30 ms instead of 300.
    """
    gc.collect()
    gc.freeze()
    window.live.prepared_changed.connect(lambda _prepared: call_later(window, release_memory))


def release_memory() -> None:
    """Collect unused objects, and return their memory to the system."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:  # glibc keeps freed memory between what is in use
        trim(0)


def open_when_ready(window: MainWindow, path: str) -> None:
    """Open a file once the first scene is prepared: a map needs its skin, and a recording returns to it."""

    def opened(_prepared: object) -> None:
        window.live.prepared_changed.disconnect(opened)
        call_later(window, partial(window.presenters.files.open_path, path))  # after all receivers

    window.live.prepared_changed.connect(opened)


def show_guide(page: Path) -> int:
    """Show a page of the guide in its own window and return when it is closed.

    Raises:
        DisplayError: See ``launch``.
    """
    require_display()
    app = make_application()
    apply_theme(app, THEMES[Settings().theme])
    window = GuideWindow(page)
    window.show()
    return app.exec()


def _on_unexpected(
    window: MainWindow, kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Show an unexpected error of a slot in the window and store its details in a file."""
    if issubclass(kind, KeyboardInterrupt):
        window.close()
    else:
        window.notifier.unexpected(error.with_traceback(trace))


def screenshot(
    scene: Scene,
    path: str | Path,
    *,
    at: float = 2.0,
    theme: str = "dark",
    size: tuple[int, int] = (1400, 900),
    progress: Progress = no_progress,
) -> None:
    """Save a picture of the whole window after ``at`` simulated seconds of the scene; needs no display.

    Raises:
        TactileMapsError: The scene cannot be prepared, or the picture cannot be written.
    """
    use_no_display()
    prepared = prepare_cached(scene, progress=progress)
    app = make_application()
    apply_theme(app, THEMES[theme])
    window = picture_window(theme, size)
    try:
        _play(window, prepared, at)
        save_window_picture(window, path)
    finally:
        window.close()


def figure(
    scene: Scene,
    path: str | Path,
    spec: FigureSpec,
    *,
    part: str = "views",
    at: float = 2.0,
    progress: Progress = no_progress,
) -> str:
    """Save a figure for a paper after ``at`` simulated seconds of the scene; needs no display.

    Args:
        scene: Scene to show.
        path: File ending in ``.svg``, ``.pdf`` or ``.png``.
        spec: Size, resolution and colours.
        part: ``views``, ``robot`` or ``map``.
        at: Simulated time [s].
        progress: Receives the progress.

    Returns:
        Statement about texts that are left out of a small figure; empty if there are none.

    Raises:
        TactileMapsError: The scene cannot be prepared, or the figure cannot be written.
    """
    use_no_display()
    prepared = prepare_cached(scene, progress=progress)
    app = make_application()
    theme = "dark" if spec.colours is FigureColours.DARK else "light"
    apply_theme(app, THEMES[theme])
    window = picture_window(theme, (1400, 900))
    try:
        _play(window, prepared, at)
        return left_out_text(window.presenters.figure.save(FigurePart(part), Path(path), spec))
    finally:
        window.close()


def _play(window: MainWindow, prepared: PreparedScene, seconds: float) -> None:
    """Run the scene for some simulated time and draw the result in the quality of a picture."""
    window.live.run_session(Session(prepared))
    QApplication.processEvents()
    assert isinstance(window.live.runner, InlineRunner)
    for _ in range(round(seconds / 0.05)):
        window.live.runner.run_for(0.05)
        window.live.pump()
    window.show_quality()
    QApplication.processEvents()
    window.robot_view.display.draw_now(quality=2.0)
    QApplication.processEvents()


def picture_window(theme: str, size: tuple[int, int]) -> MainWindow:
    """Return a window for pictures and tests, with inline backends and temporary settings."""
    settings = Settings.temporary()
    settings.theme = theme
    window = MainWindow(settings, backends=INLINE)
    window.resize(*size)
    window.show()
    return window


def make_application() -> QApplication:
    """Return the Qt application of the process."""
    app = QApplication.instance()
    if isinstance(app, QApplication):
        return app
    app = QApplication(sys.argv[:1])
    app.setApplicationName("Tactile Maps")
    app.setDesktopFileName("tactile-maps")
    app.setWindowIcon(QIcon(str(asset("icon.svg"))))
    return app
