"""What is opened and saved: robots, scenes, recordings, taxel files, pictures; and, until they move, the commands of
the view.

Scenes are listed as the File menu has them: those that ship by title, a person's own, and the one that runs kept in a
file with every effect as it was chosen.
"""

from __future__ import annotations

from datetime import datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from platformdirs import user_documents_path
from PySide6.QtCore import QElapsedTimer, QObject, QTimer
from PySide6.QtWidgets import QFileDialog, QMenu, QMessageBox

from app.core.errors import SceneError, TactileMapsError
from app.core.files import write_atomically
from app.scene.scene import Scene
from app.scene.scene_file import load_scene, scene_for, scene_names, scene_to_toml
from widgets.actions.menus import build_menus
from widgets.actions.registry import shortcuts_html
from widgets.common.file_types import (
    RECORDING_FILTER,
    ROBOT_FILTER,
    SCENE_FILTER,
    TAXEL_FILTER,
    is_map,
    is_recording,
    is_taxel_file,
    scene_to_open,
    with_taxels,
)
from widgets.common.panel import Panel
from widgets.session.recording_writer import make_recording_folder

if TYPE_CHECKING:
    from widgets.window.main_window import MainWindow


_PLAY_MS = 16


class FilePresenter(QObject):
    """Connects the window's actions to what they do, and builds its menus.

    Args:
        window: The window, with its actions made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._live = window, window.live
        self._play_clock = QElapsedTimer()
        self._play_timer = QTimer(self)
        self._play_timer.setInterval(_PLAY_MS)
        self._play_timer.timeout.connect(self._on_play_timer)
        window.timeline.play_toggled.connect(self._on_play_toggled)
        self._connect()
        window.action("theme").setChecked(window.theme.name == "light")
        window.action("panels").setChecked(True)
        window.action("plots").setChecked(True)
        build_menus(window, self)

    def _connect(self) -> None:
        for name, act in (
            ("open_robot", self.choose_robot),
            ("open_recording", self.choose_recording),
            ("import_taxels", self.choose_taxels),
            ("save_picture", self.choose_picture_file),
            ("quit", self._window.close),
            ("pause", self.toggle_pause),
            ("step", self._live.step),
            ("reset", self._live.reset),
            ("record", self.toggle_record),
            ("theme", self.toggle_theme),
            ("panels", self.toggle_panels),
            ("timing", self.show_timing),
            ("effects", self.show_effects),
            ("plots", self.toggle_plots),
            ("reset_layout", self.reset_layout),
            ("full_screen", self.toggle_full_screen),
            ("frame", self.frame_all),
            ("keys", self.tell_keys),
            ("about", self.tell_about),
        ):
            self._window.action(name).triggered.connect(act)

    def close(self) -> None:
        """Stop what runs by itself."""
        self._play_timer.stop()

    # Opening.

    def open_path(self, path: str, _checked: bool = False) -> None:
        """Open whatever the file is; say so when nothing can be done with it."""
        try:
            if is_recording(path):
                self._live.open_recording(path)
            elif is_map(path):
                self._window.map_edit_presenter.files.open(path)
            elif is_taxel_file(path):
                self.import_taxels(path)
            else:
                self.open_scene(scene_to_open(path))
        except TactileMapsError as error:
            self._window.notification_bar.say(str(error), fault=True)
            return
        self._window.settings.add_recent(path)

    def open_robot(self, name: str, _checked: bool = False) -> None:
        """Open a robot by name."""
        self.open_scene(scene_for(name))

    def import_taxels(self, path: str) -> None:
        """Put the taxels of a positions file on the robot that is open."""
        prepared = self._live.prepared
        scene = prepared.scene if prepared is not None else scene_for("icub")
        self.open_scene(with_taxels(scene, path))

    def open_scene(self, scene: Scene) -> None:
        """Open a scene, once what was not saved of the map has been asked about."""
        self._window.map_edit_presenter.files.leave(partial(self._live.open_scene, scene))

    def choose_robot(self) -> None:
        """Ask for a robot's file."""
        self._open_chosen("Open robot", ROBOT_FILTER)

    def choose_recording(self) -> None:
        """Ask for a recording."""
        self._open_chosen("Open recording", RECORDING_FILTER)

    def choose_taxels(self) -> None:
        """Ask for a taxel file."""
        self._open_chosen("Import iCub taxels", TAXEL_FILTER)

    def _open_chosen(self, title: str, kinds: str) -> None:
        path, _ = QFileDialog.getOpenFileName(self._window, title, "", f"{kinds};;All files (*)")
        if path:
            self.open_path(path)

    # Saving.

    def choose_picture_file(self) -> None:
        """Ask where to save a picture of the window."""
        path, _ = QFileDialog.getSaveFileName(self._window, "Save picture", "tactile-maps.png", "PNG (*.png)")
        if path:
            saved = self._window.grab().save(path)
            text = f"Saved {path}" if saved else f"{path}: the picture cannot be written there. Choose another folder."
            self._window.notification_bar.say(text, fault=not saved)

    def toggle_record(self) -> None:
        """Start recording to a new file, or complete the one being written."""
        if self._live.recorder is not None:
            self._live.stop_recording()
            return
        folder = recordings_folder()
        try:
            make_recording_folder(folder)
        except TactileMapsError as error:
            self._window.notification_bar.say(str(error), fault=True)
        else:
            prepared = self._live.prepared
            name = prepared.robot.name if prepared is not None else "session"
            self._live.start_recording(folder / f"{name} {datetime.now():%Y-%m-%d %H.%M.%S}.mcap")
        self._window.action("record").setChecked(self._live.recorder is not None)

    # Time.

    def toggle_pause(self) -> None:
        """Pause or go on; in a replay, play or pause."""
        if self._live.player is not None:
            self._window.timeline.toggle_play()
        else:
            self._live.set_paused(paused=self._live.mode == "live")

    def _on_play_toggled(self, playing: bool) -> None:
        if playing:
            self._play_clock.start()
            self._play_timer.start()
        else:
            self._play_timer.stop()

    def _on_play_timer(self) -> None:
        self._window.timeline.advance(1e-3 * self._play_clock.restart())

    # The window.

    def toggle_theme(self) -> None:
        """Dark or light."""
        self._window.set_theme("light" if self._window.theme.name == "dark" else "dark")

    def toggle_panels(self, shown: bool) -> None:
        """Show or hide the panels."""
        self._window.panels.setVisible(shown)

    def toggle_plots(self, shown: bool) -> None:
        """Show or hide timeline and plots."""
        self._window.bottom.setVisible(shown)

    def show_timing(self) -> None:
        """Bring the times into sight."""
        self._reveal(self._window.column.timing)

    def show_effects(self) -> None:
        """Bring what is simulated into sight."""
        self._reveal(self._window.column.effects)

    def _reveal(self, panel: Panel) -> None:
        self._window.action("panels").setChecked(True)
        self.toggle_panels(True)
        self._window.column.reveal(panel)

    def reset_layout(self) -> None:
        """The window as it first was."""
        for name, toggle in (("panels", self.toggle_panels), ("plots", self.toggle_plots)):
            self._window.action(name).setChecked(True)
            toggle(True)
        self._window.views.level()

    def toggle_full_screen(self, full: bool) -> None:
        """The whole screen, or not."""
        (self._window.showFullScreen if full else self._window.showNormal)()

    def frame_all(self) -> None:
        """Both views show everything."""
        self._window.views.frame_all()

    def tell_keys(self) -> None:
        """List keys and gestures."""
        self._tell("Keys", shortcuts_html())

    def tell_about(self) -> None:
        """Name versions."""
        names = ("tactile-maps", "mujoco", "libigl", "pyvista", "PySide6-Essentials", "numpy")
        self._tell(
            "About Tactile Maps",
            "A robot's skin beside its live tactile map.<br><br>"
            + "<br>".join(f"{name} {version(name)}" for name in names),
        )

    def _tell(self, title: str, text: str) -> None:
        box = QMessageBox(QMessageBox.Icon.NoIcon, title, text, QMessageBox.StandardButton.Close, self._window)
        box.setObjectName("tell")
        box.open()


def recordings_folder() -> Path:
    """Where recordings go by default."""
    return user_documents_path() / "Tactile Maps"


class SceneFilePresenter(QObject):
    """Opens and saves scenes.

    Args:
        window: The window, with its commands made.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        window.action("open_scene").triggered.connect(self.choose)
        window.action("save_scene").triggered.connect(self.choose_save)
        window.live.prepared_changed.connect(self._update_state)
        window.live.mode_changed.connect(self._update_state)
        self._update_state()

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
        self._window.file_presenter.open_scene(load_scene(name))

    def choose(self) -> None:
        """Ask for a scene's file."""
        path, _ = QFileDialog.getOpenFileName(self._window, "Open scene", "", f"{SCENE_FILTER};;All files (*)")
        if path:
            self._window.file_presenter.open_path(path)

    def choose_save(self) -> None:
        """Ask where to keep the scene that runs."""
        scene = self._window.effects_presenter.scene
        if scene is None:
            return
        path, _ = QFileDialog.getSaveFileName(self._window, "Save scene", f"{scene.name}.toml", SCENE_FILTER)
        if path:
            self.save(path if Path(path).suffix else f"{path}.toml")

    def save(self, path: str) -> None:
        """Keep the scene that runs in a file, with every effect as it was chosen."""
        scene = self._window.effects_presenter.scene
        if scene is None:
            return
        try:
            write_atomically(Path(path), scene_to_toml(scene).encode("utf8"), error=SceneError)
        except TactileMapsError as error:
            self._window.notification_bar.say(str(error), fault=True)
        else:
            self._window.notification_bar.say(f"Saved {path}")
            self._window.settings.add_recent(path)

    def _update_state(self) -> None:
        self._window.action("save_scene").setEnabled(self._window.live.prepared is not None)
