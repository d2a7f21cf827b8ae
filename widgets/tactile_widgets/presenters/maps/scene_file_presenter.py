"""File of the scene: saving it with the settings that the user made, and what no file contains of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.contacts.pipeline import reading_from, reading_values
from tactile_maps.control.behaviours import behaviours_from, behaviours_to
from tactile_maps.control.controller_registry import scene_values, settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SceneError
from tactile_maps.core.files import read_bounded_text, write_atomically
from tactile_maps.scene.effects import Effects, Override
from tactile_maps.scene.scene import Scene, with_effects
from tactile_maps.scene.scene_file import MOST_BYTES, scene_from_toml, scene_in_folder, scene_to_toml
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.common.file_dialogs import SCENE_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter


class ChosenEffects(Protocol):
    """Effects that the user chose."""

    @property
    def scene(self) -> Scene | None:
        """The scene that is shown, with its effects; None before the first scene."""

    def with_effects(self, prepared: PreparedScene, effects: Effects) -> Scene:
        """Return a scene, shown or not, with effects that the user chose in it."""

    def restore(self, overrides: Mapping[str, Override]) -> None:
        """Choose effects again."""


def path_name(settings: ControlSettings) -> str:
    """Return the name for the user of the settings' path: a target is a path of one point."""
    return "target" if settings.path and settings.task == "hold_point" else "path"


class SceneFilePresenter(Presenter):
    """The file of the scene that runs, or that runs behind a recording or a real skin. Mutable.

    Args:
        context: Session, views, panels and services of the window.
        effects: Scene with the chosen effects.
        parent: Window over which dialogs open.

    Attributes:
        path: File of the scene; None for a scene of the program, or of a robot or skin alone.
        proposed: Name proposed for its file, without ending; empty for that of the scene.
        path_removed: Whether a change of the skin removed the path, so that its absence is no change of the user's own.
    """

    changed = Signal()
    """The file, or the changes that it does not contain, have changed."""
    saved = Signal()
    """The scene that runs was saved with its skin."""

    def __init__(self, context: AppContext, effects: ChosenEffects, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self.path: Path | None = None
        self.proposed = ""
        self.path_removed = False
        self._next: Path | None = None  # of the scene that is being opened
        self._in_file: RuntimeSettings | None = None
        session = self._session
        for signal in (
            session.settings_changed,
            session.behaviours_changed,
            session.reading_changed,
            session.effects_changed,
        ):
            signal.connect(self.changed)
        context.actions.bind(save_scene=self.choose_save)

    def begin(self, prepared: PreparedScene) -> None:
        """Begin with another scene, as its file states it."""
        self.path = self.expected
        self.proposed = ""
        self.path_removed = False
        if not self._session.opening:
            self._next = None
        live_input = self._session.live_input
        self._in_file = RuntimeSettings.of_scene(prepared if live_input is None else live_input.origin)
        self.changed.emit()

    def expect(self, path: Path | None) -> None:
        """Set the file of the scene that is being opened; None if it has none, or failed to open."""
        self._next = path

    @property
    def expected(self) -> Path | None:
        """File of the scene that has been opened; None if it has none, or is still being opened."""
        return None if self._session.opening else self._next

    @property
    def unsaved(self) -> tuple[str, ...]:
        """Names of the parts that the user changed and that no file contains.

        They are the path or target, controller, behaviours, contact detection and effects.
        """
        return self._differing(self._in_file)

    def lost(self, after: RuntimeSettings) -> tuple[str, ...]:
        """Return the names of the unsaved parts that other settings do not contain."""
        differing = self._differing(after)
        return tuple(name for name in self.unsaved if name in differing)

    def _differing(self, other: RuntimeSettings | None) -> tuple[str, ...]:
        made = self.made
        if made is None or other is None:
            return ()
        removed = self.path_removed and not made.settings.path
        changes = {
            self._path_name(made): made.settings.path != other.settings.path and not removed,
            "controller": _without_path(made.settings) != _without_path(other.settings),
            "behaviours": made.behaviours != other.behaviours,
            "contact detection": made.reading != other.reading,
            "effects": made.effects != other.effects,
        }
        return tuple(name for name, changed in changes.items() if changed)

    def _path_name(self, made: RuntimeSettings) -> str:
        """Return the name of the drawn path, or of the one that the file has if the user removed it."""
        known = made if made.settings.path or self._in_file is None else self._in_file
        return path_name(known.settings)

    @property
    def made(self) -> RuntimeSettings | None:
        """The settings that the user made, shown or not; None before the first scene."""
        session = self._session
        if session.live_input is not None:
            return session.live_input.simulated
        return None if session.run is None else session.run.made

    @property
    def scene(self) -> Scene | None:
        """The scene that runs, with the settings that the user made; None before the first scene."""
        session = self._session
        made = self.made
        if made is None or session.run is None:
            return None
        prepared = session.run.prepared if session.live_input is None else session.live_input.origin
        scene = self._effects.with_effects(prepared, made.effects)
        if settings_from(scene.control) != made.settings:
            scene = replace(scene, control=scene_values(replace(made.settings, starts=0)))
        if behaviours_from(scene.behaviours) != made.behaviours:
            scene = replace(scene, behaviours=behaviours_to(made.behaviours))
        if reading_from(scene.reading) != made.reading:
            scene = replace(scene, reading=reading_values(made.reading))
        return scene

    @property
    def to_write(self) -> Scene | None:
        """The same with overrides of effects that it would decide differently, for example for its new controller."""
        scene = self.scene
        made = self.made
        if scene is None or made is None:
            return None
        try:
            return with_effects(scene, made.effects)
        except SceneError:
            return scene  # these effects contradict each other, so that the session rejects them in its next tick

    def restore(self, scene: Scene) -> None:
        """Restore the settings of a scene that were not saved."""
        self._session.set_settings(settings_from(scene.control))
        self._session.set_behaviours(behaviours_from(scene.behaviours))
        self._session.set_reading(reading_from(scene.reading))
        self.restore_effects(scene.overrides)

    def restore_effects(self, overrides: Mapping[str, Override]) -> None:
        """Choose effects of the scene that runs again."""
        self._effects.restore(overrides)

    # Saving.

    def choose_save(self) -> bool:
        """Ask for a file, and save the scene that is shown: that of a recording, or the one that runs."""
        recorded = self._session.replay.player is not None
        scene = self._effects.scene if recorded else self.scene
        path = self._ask_path(scene, "" if recorded else self._own_name)
        return bool(path) and self.save(path)

    def save_own(self) -> bool:
        """Save the scene that runs, even behind a recording, in its file. Return whether it was saved.

        Ask for a file if it has none, or one with comments or an order of its own, which would be lost.
        """
        written = self.path is not None and _is_written_here(self.path)
        path = str(self.path) if written else self._ask_path(self.scene, self._own_name)
        return bool(path) and self._write(path, self.to_write, own=True)

    def save(self, path: str) -> bool:
        """Save the scene that is shown. Return whether it was saved."""
        if self._session.replay.player is not None:
            return self._write(path, self._effects.scene, own=False)
        return self._write(path, self.to_write, own=True)

    @property
    def _own_name(self) -> str:
        """Name proposed for the file of the scene that runs, without ending; empty for that of the scene."""
        return self.proposed if self.path is None else self.path.stem

    def _ask_path(self, scene: Scene | None, name: str) -> str:
        if scene is None:
            return ""
        default = f"{name or scene.name}.toml"
        return self._context.dialogs.save_file("Save scene", default, SCENE_FILTER, remembers=False)

    def _write(self, path: str, scene: Scene | None, *, own: bool) -> bool:
        if scene is None:
            return False
        try:
            text = scene_to_toml(scene_in_folder(scene, Path(path).parent))
            write_atomically(Path(path), text.encode("utf8"), error=SceneError)
        except SceneError as error:
            self._notifier.fault(str(error), of="save scene")
            return False
        self._notifier.say(f"Saved {path}", of="save scene")
        self._context.settings.add_recent(path)
        made = self.made
        if own and made is not None:
            self._in_file = made
            self.path = Path(path)
            self.saved.emit()
            self.changed.emit()
        return True


def map_file_of(path: Path | None, scene: Scene) -> Path | None:
    """Return the file for the map of a scene, next to the file of the scene; None if that is not known."""
    own = None if path is None else path.with_suffix(".npz")
    return None if str(own) in scene.taxel_files else own


def _is_written_here(path: Path) -> bool:
    """Whether a scene file contains exactly what this program writes."""
    try:
        text = read_bounded_text(path, error=SceneError, most=MOST_BYTES)
        return text == scene_to_toml(scene_from_toml(text, name=path.stem))
    except SceneError:
        return False


def _without_path(settings: ControlSettings) -> ControlSettings:
    """Return the settings without the path, and without the number that restarts a task."""
    return replace(settings, path=(), starts=0)
