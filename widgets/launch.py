"""Opens the window, on a display or, for pictures, without one."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType

from app.crash_log import explain
from app.errors import DisplayError
from app.scene.scene import Scene
from app.session.prepare import prepare

# Off-screen rendering must not look for an X server; VTK reads this when it is imported, below.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
os.environ.setdefault("QT_API", "pyside6")

from PySide6.QtWidgets import QApplication

from widgets.colours import THEMES, apply_theme
from widgets.display import require_display
from widgets.engines import INLINE
from widgets.main_window import MainWindow
from widgets.runner import InlineRunner
from widgets.settings import Settings


def launch(scene: Scene) -> int:
    """Open the window on ``scene`` and return when it is closed.

    Raises:
        DisplayError: There is no display that answers, or Qt lacks what it needs to draw on it.
    """
    if sys.platform.startswith("linux"):
        require_display()
    app = make_application()
    settings = Settings()
    apply_theme(app, THEMES[settings.theme])
    window = MainWindow(settings)
    sys.excepthook = partial(_on_unexpected, window)
    window.show()
    window.live.open_scene(scene)
    return app.exec()


def _on_unexpected(
    window: MainWindow, kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """What nobody foresaw in a slot: said in the window, kept in a file, and the window lives on."""
    if issubclass(kind, KeyboardInterrupt):
        window.close()
    else:
        window.message_bar.say(explain(error.with_traceback(trace)), fault=True)


def screenshot(
    scene: Scene,
    path: str | Path,
    *,
    at: float = 2.0,
    theme: str = "dark",
    size: tuple[int, int] = (1400, 900),
    progress: Callable[[str, float], None] = lambda _text, _fraction: None,
) -> None:
    """Save a picture of the whole window after ``at`` simulated seconds of the scene; needs no display.

    Raises:
        TactileMapsError: The scene cannot be prepared, or the picture not be written.
    """
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    prepared = prepare(scene, progress=progress)
    app = make_application()
    apply_theme(app, THEMES[theme])
    window = picture_window(theme, size)
    try:
        window.live.show_prepared(prepared)
        _play(window, at)
        if not window.grab().save(str(path)):
            raise DisplayError(
                "the picture cannot be written",
                file=path,
                remedy="Choose a folder you may write to and a name that ends in .png",
            )
    finally:
        window.close()


def _play(window: MainWindow, seconds: float) -> None:
    """Let simulated time pass and show where it ended, as finely as a picture deserves."""
    QApplication.processEvents()
    assert isinstance(window.live.runner, InlineRunner)
    for _ in range(round(seconds / 0.05)):
        window.live.runner.run_for(0.05)
        window.live.pump()
    window.show_quality()
    QApplication.processEvents()
    window.robot_view.draw_now(quality=2.0)
    QApplication.processEvents()


def picture_window(theme: str, size: tuple[int, int]) -> MainWindow:
    """A window that runs only when told to and remembers nothing; for pictures and tests."""
    settings = Settings(Path(os.devnull))
    settings.theme = theme
    window = MainWindow(settings, engines=INLINE)
    window.resize(*size)
    window.show()
    return window


def make_application() -> QApplication:
    """The Qt application, made once a process."""
    app = QApplication.instance()
    if isinstance(app, QApplication):
        return app
    app = QApplication(sys.argv[:1])
    app.setApplicationName("Tactile Maps")
    app.setDesktopFileName("tactile-maps")
    return app
