"""Content that was opened in the background, and waits until it may replace what is shown."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QWidget

from tactile_maps.scene.scene import Scene
from tactile_widgets.common.make import make
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.tools.registry import Tools

_POLL_MS = 50


class ArrivalPresenter(Presenter):
    """Shows what was opened in the background. Mutable: what waits.

    It waits while a dialog is open, for example a question about the document or the choice of a file for it. Changes
    that are not saved are asked about, unless the user discarded them before the opening. A change of the skin keeps
    the document for undo, and a recording leaves it in place, so that neither asks.

    Args:
        context: Session, views, panels and services of the window.
        map_files: Asks about unsaved changes.
        tools: Tools, with the steps of the skin.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, map_files: MapFilePresenter, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._map_files = map_files
        self._skin_steps = tools.skin_steps
        self._waiting: tuple[Callable[[], None], Scene | None] | None = None
        self._timer = make(QTimer, self, interval=_POLL_MS, timeout=self._on_timer)
        context.session.admit = self._on_arrived
        context.session.opening_stopped.connect(self.close)
        context.session.opening_stopped.connect(map_files.stay)

    def close(self) -> None:
        """Drop what waits."""
        self._waiting = None
        self._timer.stop()

    def _on_arrived(self, show: Callable[[], None], scene: Scene | None) -> None:
        self._waiting = show, scene
        self._timer.start()
        self._on_timer()

    def _on_timer(self) -> None:
        if self._waiting is None or QApplication.activeModalWidget() is not None:
            return
        show, scene = self._waiting
        self.close()
        if scene is None:
            show()
        elif self._skin_steps.expects(scene):
            self._map_files.keep_document()
            show()
        else:
            self._map_files.leave_again(show, self._session.cancel_loading)
