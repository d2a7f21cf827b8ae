"""What the menus and keys do: choose files, open, record, save, tell."""

from __future__ import annotations

from datetime import datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from platformdirs import user_documents_path
from PySide6.QtCore import QElapsedTimer, QObject, QTimer
from PySide6.QtWidgets import QFileDialog, QMessageBox

from app.errors import TactileMapsError
from app.scene.scene import Scene
from app.scene.scene_file import scene_for
from widgets.actions import keys_text
from widgets.menus import build_menus
from widgets.opening import (
    RECORDING_FILTER,
    ROBOT_FILTER,
    TAXEL_FILTER,
    is_map,
    is_recording,
    is_taxel_file,
    scene_to_open,
    with_taxels,
)
from widgets.panels.panel import Panel
from widgets.tape import make_folder

if TYPE_CHECKING:
    from widgets.main_window import MainWindow

_PLAY_MS = 16


class Commands(QObject):
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
                self._window.editing.files.open(path)
            elif is_taxel_file(path):
                self.import_taxels(path)
            else:
                self.open_scene(scene_to_open(path))
        except TactileMapsError as error:
            self._window.message_bar.say(str(error), fault=True)
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
        self._window.editing.files.leave(partial(self._live.open_scene, scene))

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
            self._window.message_bar.say(text, fault=not saved)

    def toggle_record(self) -> None:
        """Start recording to a new file, or complete the one being written."""
        if self._live.recorder is not None:
            self._live.stop_recording()
            return
        folder = recordings_folder()
        try:
            make_folder(folder)
        except TactileMapsError as error:
            self._window.message_bar.say(str(error), fault=True)
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
        self._tell("Keys", keys_text())

    def tell_about(self) -> None:
        """Name versions."""
        names = ("tactile-maps", "mujoco", "libigl", "pyvista", "PySide6-Essentials", "numpy")
        self._tell(
            "About Tactile Maps",
            "A robot's skin and its tactile map, alive side by side.<br><br>"
            + "<br>".join(f"{name} {version(name)}" for name in names),
        )

    def _tell(self, title: str, text: str) -> None:
        box = QMessageBox(QMessageBox.Icon.NoIcon, title, text, QMessageBox.StandardButton.Close, self._window)
        box.setObjectName("tell")
        box.open()


def recordings_folder() -> Path:
    """Where recordings go by default."""
    return user_documents_path() / "Tactile Maps"
