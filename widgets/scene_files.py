"""Scenes as the File menu has them: those that ship by title, a person's own, and the one that runs kept in a file."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QMenu

from app.errors import SceneError, TactileMapsError
from app.scene.scene_file import load_scene, scene_names
from app.scene.scene_text import scene_to_toml
from app.whole_file import write_whole
from widgets.opening import SCENE_FILTER

if TYPE_CHECKING:
    from widgets.main_window import MainWindow


class SceneFiles(QObject):
    """Opens and saves scenes.

    Args:
        window: The window, with its commands made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        window.action("open_scene").triggered.connect(self.choose)
        window.action("save_scene").triggered.connect(self.choose_save)
        window.live.prepared_changed.connect(self._dress)
        window.live.mode_changed.connect(self._dress)
        self._dress()

    def fill(self, menu: QMenu) -> None:
        """List the scenes that ship, and the way to a file, once it is opened: reading them takes 0.1 s."""
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(partial(self._list, menu))

    def _list(self, menu: QMenu) -> None:
        if not menu.isEmpty():
            return
        for name in scene_names():
            item = menu.addAction(load_scene(name).title or name)
            item.setObjectName(f"scene-{name}")
            item.setToolTip(name)
            item.triggered.connect(partial(self.open, name))
        menu.addSeparator()
        menu.addAction(self._window.action("open_scene"))

    def open(self, name: str, _checked: bool = False) -> None:
        """Open a scene by name."""
        self._window.commands.open_scene(load_scene(name))

    def choose(self) -> None:
        """Ask for a scene's file."""
        path, _ = QFileDialog.getOpenFileName(self._window, "Open scene", "", f"{SCENE_FILTER};;All files (*)")
        if path:
            self._window.commands.open_path(path)

    def choose_save(self) -> None:
        """Ask where to keep the scene that runs."""
        scene = self._window.effects.scene
        if scene is None:
            return
        path, _ = QFileDialog.getSaveFileName(self._window, "Save scene", f"{scene.name}.toml", SCENE_FILTER)
        if path:
            self.save(path if Path(path).suffix else f"{path}.toml")

    def save(self, path: str) -> None:
        """Keep the scene that runs in a file, with every effect as it was chosen."""
        scene = self._window.effects.scene
        if scene is None:
            return
        try:
            write_whole(Path(path), scene_to_toml(scene).encode("utf8"), error=SceneError)
        except TactileMapsError as error:
            self._window.message_bar.say(str(error), fault=True)
        else:
            self._window.message_bar.say(f"Saved {path}")
            self._window.settings.add_recent(path)

    def _dress(self) -> None:
        self._window.action("save_scene").setEnabled(self._window.live.prepared is not None)
