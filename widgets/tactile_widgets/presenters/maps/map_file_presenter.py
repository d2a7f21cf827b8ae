"""The user's document: its unsaved parts, the question about them, and the file of its map with autosave and recovery.

The parts are map, skin, path, controller, behaviours, contact detection and effects, and a skin that is chosen in the
panel but not applied, also one for a robot that is not open yet. The map has a file of its own; the others are in the
file of the scene. Two files of the same name, ``arm.toml`` and ``arm.npz``, are saved and opened together. Everything
that may replace the document calls ``leave`` first.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from platformdirs import user_state_path
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import MapError, TactileMapsError, counted
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import FolderClaim, claim_folder, try_writing
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import AUTOSAVE_NAME, DocumentFile, load_document
from tactile_maps.editing.layout_import import (
    adopt_document,
    adopt_edits,
    is_drawn_so,
    pin_as_drawn,
    place_as_drawn,
    same_skin,
)
from tactile_maps.editing.leftovers import Leftover, find_leftovers
from tactile_maps.maps.evaluation.comparison import TaxelLayout
from tactile_maps.maps.formats.export import SENSORS_ENDING, TITLES, unknown_format, unsuitable_formats, write_map
from tactile_maps.maps.formats.obj import read_map_obj
from tactile_maps.maps.formats.svg import read_svg_taxels
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.scene.effects import Override
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import cover_from_toml, cover_to_toml, scene_from_toml, scene_to_toml
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.formats.identify import kind_of
from tactile_maps.skin.formats.mujoco_touch import write_touch_sensors
from tactile_widgets.common.make import make
from tactile_widgets.common.settings import Question
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.document.skin_steps import KeptDocument, StepsOnSkin, have_same_skin
from tactile_widgets.jobs.later import call_later
from tactile_widgets.presenters.maps.scene_file_presenter import SceneFilePresenter, map_file_of, path_name
from tactile_widgets.tools.control.carried_paths import path_on_skin
from tactile_widgets.tools.registry import Tools

AUTOSAVE_MS = 20_000
_LOST = {"path": "the drawn path", "target": "the target"}
_CHOSEN = "chosen skin (not applied yet)"
_MAPS = "Tactile maps (*.npz)"
_OPENED = "Tactile maps (*.npz *.obj *.svg)"
_ENTRIES = {
    FileKind.SCENE: "Open scene file",
    FileKind.ROBOT: "Open robot",
    FileKind.ROBOT_WITH_TAXELS: "Open robot",
    FileKind.MESH: "Open robot",
    FileKind.TAXELS: "Import taxels",
    FileKind.SKIN: "Import taxels",
    FileKind.LAYOUT: "Import taxels",
    FileKind.RECORDING: "Open recording",
    FileKind.ROS_RECORDING: "Connect",
    FileKind.STUDY_TABLE: "Open study table",
    FileKind.READINGS: "Connect",
}
"""Entry of the menu *File* that opens a file, by kind."""


@dataclass(frozen=True)
class UnopenedChoice:
    """A skin that is chosen for a robot that is not open yet.

    Attributes:
        scene: Scene of the robot, with the chosen cover.
        default: Cover that it has without the choice.
    """

    scene: Scene
    default: CoverSpec

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return Path(self.scene.robot).stem

    @property
    def name(self) -> str:
        """Name of this part of the user's work."""
        return f"chosen skin of {self.robot} (not open yet)"


@dataclass(frozen=True, eq=False)
class _Discarded:
    """Work that the user discarded before something else is opened."""

    document: MapDocument | None
    settings: RuntimeSettings | None
    choice: CoverSpec | None
    unopened: UnopenedChoice | None


class MapFilePresenter(Presenter):
    """The document: its unsaved parts, the file of its map, and autosaves that a crash left. Mutable.

    A change of the skin makes another scene with another document. The documents before and after it are kept together,
    so that the change can be undone and redone with all edits of the map.

    Args:
        context: Session, views, panels and services of the window.
        scene_file: File of the scene.
        tools: Tools, with the steps of skin and controller settings.
        parent: Window over which dialogs open.

    Attributes:
        choice_refusal: Returns why the chosen skin cannot be applied now; an empty text if it can.
    """

    changed = Signal()
    """A file, ``unsaved`` or the edits that can be restored have changed."""
    skin_restored = Signal(Scene)
    """Open this scene, whose skin was restored."""
    begun = Signal(object)
    """Another scene is edited; that Scene if the user chose its skin before it was opened, else None."""
    choice_restored = Signal()
    """Show the chosen skin, which a crash left."""
    unopened_restored = Signal(UnopenedChoice)
    """Show this skin, which is chosen for a scene that is not open; a crash left it."""
    apply_requested = Signal()
    """Apply the chosen skin, because it is being saved."""
    _autosave_ended = Signal()

    def __init__(self, context: AppContext, scene_file: SceneFilePresenter, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._editor = context.editor
        self._scene = scene_file
        self._steps = tools.skin_steps
        self._control = tools.control
        self._file: DocumentFile | None = None
        self._claim: FolderClaim | None = None
        self._leftovers: list[Leftover] = []
        self._restoring: Leftover | None = None  # its scene is being opened
        self._restored: list[Leftover] = []  # deleted once there is another autosave of the restored document
        self._replaced: list[Leftover] = []  # those of them that the autosave being written replaces
        self._saves_next: Callable[[], None] | None = None  # called once the requested skin is shown
        self._first: MapDocument | None = None
        self._shown: Scene | None = None  # the scene of the document
        self._in_file: Scene | None = None  # the scene whose skin is in a file
        self._chosen: Scene | None = None  # the user chose the skin of this scene, which is being opened
        self._in_file_before: Scene | None = None  # the same of the scene behind a recording that is being taken over
        self._reported_unwritable = False
        self._discarded = False  # the autosave is not needed any more once the document is replaced
        self._choice: CoverSpec | None = None  # in the Skin panel, not applied yet
        self._unopened: UnopenedChoice | None = None
        self.choice_refusal: Callable[[], str] = lambda: ""
        self._left: _Discarded | None = None
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="autosave")
        self._writing: Future[bool] | None = None
        self._due = False  # an autosave follows the one that is being written
        self._timer = make(QTimer, self, interval=AUTOSAVE_MS, timeout=self.autosave)
        self._timer.start()
        self._autosave_ended.connect(self._on_autosave_ended, Qt.ConnectionType.QueuedConnection)
        self._editor.history_changed.connect(self._on_history_changed)
        scene_file.changed.connect(self.changed)
        scene_file.saved.connect(self._on_scene_saved)
        context.session.replay.player_changed.connect(self._offer)
        context.session.replay.taken_over.connect(self._on_taken_over)
        context.dialogs.document = self._shown_file
        context.actions.bind(
            open_map=self.choose_open,
            save=self._save_applied,
            save_map_as=self.choose_save,
            export_map=self.choose_export,
            restore_map=self.restore,
            discard_restore=self.discard_leftover,
            take_over=self.ask_take_over,
        )

    @property
    def unsaved(self) -> tuple[str, ...]:
        """Names of the parts that closing now would lose, the map first; also a skin being prepared or chosen."""
        changed = self._changed
        if self._preparing_skin and "skin" not in changed:
            changed = ("skin", *changed)
        chosen = () if self._choice is None else (_CHOSEN,)
        return (*changed, *chosen, *self._unopened_names)

    @property
    def _unopened_names(self) -> tuple[str, ...]:
        return () if self._unopened is None else (self._unopened.name,)

    @property
    def choice(self) -> CoverSpec | None:
        """Cover that is chosen for the skin of the document but not applied yet; None without one."""
        return self._choice

    def note_choice(self, cover: CoverSpec | None) -> None:
        """Note the cover that is chosen and not applied yet; None without one."""
        if cover != self._choice:
            self._choice = cover
            self.changed.emit()

    @property
    def unopened(self) -> UnopenedChoice | None:
        """Skin that is chosen for a robot that is not open yet; None without one."""
        return self._unopened

    def note_unopened(self, choice: UnopenedChoice | None) -> None:
        """Note the skin that is chosen for a robot that is not open yet; None without one."""
        if choice != self._unopened:
            self._unopened = choice
            self.changed.emit()

    @property
    def _preparing_skin(self) -> bool:
        """Whether a skin is being prepared that the user has chosen now."""
        return self._steps.pending and self._steps.after is None

    @property
    def _new_skin(self) -> bool:
        """Whether the skin of the document is in no file."""
        scene = self._shown
        return scene is not None and (self._in_file is None or not have_same_skin(self._in_file, scene))

    @property
    def _changed(self) -> tuple[str, ...]:
        """Names of the parts of the shown document that no file contains."""
        document = self._editor.document
        if self._file is None or document is None:
            return ()
        saved = self._first if self._file.saved is None else self._file.saved
        own = {"map": document is not saved, "skin": self._new_skin}
        return (*(name for name, changed in own.items() if changed), *self._scene.unsaved)

    @property
    def path(self) -> Path | None:
        """File of the map; None until it is saved or opened."""
        return None if self._file is None else self._file.path

    def _shown_file(self) -> Path | None:
        """Return the recording that is shown, or the file of the document."""
        player = self._session.replay.player
        return player.path if player is not None else self._scene.path or self.path

    @property
    def name(self) -> str:
        """Name of the document: its file, that of the scene first, or else the title of the scene."""
        path = self._scene.path or self.path
        scene = self._scene.scene
        if path is not None or scene is None:
            return "" if path is None else path.name
        return scene.title or scene.name

    @property
    def restorable(self) -> bool:
        """Whether a crash left edits of the current map."""
        return bool(self._leftovers)

    def offers(self, leftover: Leftover) -> bool:
        """Whether ``leftover`` is among the edits that a crash left of the current map."""
        return leftover.claim.folder in {own.claim.folder for own in self._leftovers}

    def _on_history_changed(self) -> None:
        if self._file is not None:
            self._discarded = False
        self.changed.emit()

    # Documents.

    def end(self) -> None:
        """End work on the document: delete a discarded autosave, keep any other for the next start."""
        self._wait()
        if self._due and not self._discarded:
            self.autosave()
            self._wait()
        self._due = False
        if self._file is not None and self._discarded:
            with self._notifier.errors_shown("autosave"):
                self._file.drop_autosave()
            self._delete(self._restored)
        self._discarded = False
        self._left = None
        self._choice = None
        self._unopened = None
        self._file = None
        self._saves_next = None
        self._restoring = None
        self._steps.reset()
        self._release_leftovers()
        if self._claim is not None:
            self._claim.release()
            self._claim = None

    def own_map(self, prepared: PreparedScene, document: MapDocument) -> MapDocument | None:
        """Return the map in the file next to that of the scene being opened; None without one of this skin."""
        path = map_file_of(self._scene.expected, prepared.scene)
        if path is None or not path.is_file():
            return None
        try:
            return adopt_document(document, load_document(path))
        except TactileMapsError as error:
            self._notifier.fault(f"The map next to the scene is not opened. {error}", of="open map")
            return None

    def begin(self, prepared: PreparedScene, document: MapDocument, own: MapDocument | None = None) -> None:
        """Begin with another scene, and offer edits that a crash left.

        Args:
            prepared: The scene.
            document: Its map without edits.
            own: Its map from the file next to that of the scene.
        """
        path = map_file_of(self._scene.expected, prepared.scene)
        self._report_unwritable()
        with suppress(OSError):  # no autosave then, as reported
            self._claim = claim_folder(autosave_folder(prepared.robot.name), without=AUTOSAVE_NAME)
        self._scene.begin(prepared)
        chosen = self._chosen
        self._shown = prepared.scene
        self._in_file = None if chosen is not None and have_same_skin(chosen, prepared.scene) else prepared.scene
        self._first = document
        if own is None:
            self._file = DocumentFile(None, document, folder=self._folder)
        else:
            self._file = DocumentFile(path, own, folder=self._folder)
        self._find_leftovers(prepared, document)
        self._chosen = None
        self.begun.emit(chosen)

    def _report_unwritable(self) -> None:
        """Report once that settings or autosaves cannot be stored, for example on a full disk."""
        folders = {"settings": self._context.settings.own_folder, "copies of unsaved edits": autosave_folder("")}
        errors: dict[str, OSError] = {}
        for name, folder in folders.items():
            try:
                try_writing(folder)
            except OSError as error:
                errors[name] = error
        if errors and not self._reported_unwritable:
            self._reported_unwritable = True
            names = " and ".join(errors)
            cause = next(iter(errors.values()))
            where = "" if cause.filename is None else f" ({cause.filename})"
            self._notifier.fault(
                f"{names.capitalize()} cannot be stored: {cause.strerror}{where}. Everything else works; save maps and "
                "recordings in another folder.",
                of="autosave",
            )

    @property
    def _folder(self) -> Path | None:
        return None if self._claim is None else self._claim.folder

    def keep_document(self) -> None:
        """Keep the document that is shown for undo and redo, before the requested skin is opened or shown."""
        run = self._session.run
        history = self._editor.history
        file = self._file
        if run is None or history is None or file is None:
            return
        assert self._first is not None
        control = self._control.leave_skin()
        overrides = self._overrides
        self._steps.keep(KeptDocument(run.prepared, run.settings, control, overrides, history, file, self._first))
        self.changed.emit()

    def stop_skin(self) -> None:
        """Continue with the document that is shown, because the requested skin is not opened."""
        self._steps.stop()
        self._saves_next = None
        if self._restoring is not None:
            self._restoring = None
            self._offer()
        self.changed.emit()

    @property
    def _overrides(self) -> Mapping[str, Override]:
        """Effects that the user chose in the scene that runs."""
        scene = self._scene.scene
        return {} if scene is None else scene.overrides

    @property
    def opening_chosen(self) -> bool:
        """Whether a scene is being opened whose skin the user chose."""
        return self._chosen is not None and self._session.opening

    def expect_chosen(self, scene: Scene | None) -> None:
        """Expect a scene whose skin the user chose, so that no file contains it; None for any other scene."""
        self._chosen = scene

    def show_skin(self, prepared: PreparedScene) -> bool:
        """Show the document of the requested skin. Return False for another scene."""
        run = self._session.run
        before = self._steps.before
        if run is None or before is None or not self._steps.expects(prepared.scene):
            return False
        kept = self._steps.after
        self._session.keep_pause()
        self._wait()
        self._steps.show_requested()
        self._shown = prepared.scene
        if kept is not None:
            self._note_path(before.settings.settings, run.settings.settings)
            self._file = None
            if self._steps.from_start:
                kept.history.go(0)
            self._control.enter_skin(kept.control)
            self._editor.resume(kept.history)
            self._file = kept.file
            self._first = kept.first
            self._file.resume()
            self._scene.restore_effects(kept.overrides)
        else:
            self._open_skin(prepared, before)
        self.changed.emit()
        if self._saves_next is not None:
            call_later(self, self._saves_next)  # after the scene is shown everywhere
            self._saves_next = None
        return True

    def _open_skin(self, prepared: PreparedScene, before: KeptDocument) -> None:
        """Show the document of a new skin, with the edits of the patches that it had before, or with restored edits."""
        first = MapDocument.of(prepared.map)
        restoring = self._restoring
        adopted = adopt_edits(first, before.history.present, before.first)
        document = adopted.document
        self._file = None
        if restoring is not None and same_skin(first.skin, restoring.document.skin):
            document = adopt_document(first, restoring.document)
        self._control.enter_skin(StepsOnSkin(document.map))
        self._editor.open(document, name=self._steps.requested_name)
        self._keep_settings(before, document, prepared.scene, adopted.lost)
        self._first = adopted.unedited
        self._file = DocumentFile(None, None, folder=self._folder)
        self._restoring = None
        if restoring is not None:
            self._restore_settings(restoring)
            self._drop_restored(restoring)

    def _keep_settings(
        self, before: KeptDocument, document: MapDocument, scene: Scene, patches: tuple[str, ...]
    ) -> None:
        """Keep effects, behaviours, contact detection and controller, with its path if that is on the new skin.

        A message lists what is not on the new skin, the edits of ``patches`` among it.
        """
        lost = list[str]()
        settings = before.settings.settings
        if settings.path:
            path = path_on_skin(settings.path, before.settings.map, document.map)
            lost += [] if path else [_LOST[path_name(settings)]]
            settings = replace(settings, path=path)
        if patches:
            lost.append(f"the map edits of {', '.join(patches)}")
        if (stimuli := len(before.prepared.scene.stimuli) - len(scene.stimuli)) > 0:
            lost.append(counted(stimuli, "scripted touch"))
        self._note_path(before.settings.settings, settings)
        self._session.set_settings(settings)
        self._session.set_behaviours(before.settings.behaviours)
        self._session.set_reading(before.settings.reading)
        self._scene.restore_effects(before.overrides)
        if lost:
            self._notifier.say(f"Not on the new skin and removed: {', '.join(lost)}. Undo restores the previous skin.")

    def _note_path(self, before: ControlSettings, after: ControlSettings) -> None:
        """Note whether the change of the skin between these settings removed the path, also an earlier change."""
        self._scene.path_removed = not after.path and (bool(before.path) or self._scene.path_removed)

    def _on_scene_saved(self) -> None:
        """Record that the scene was saved with its skin; edits of the map may still be unsaved."""
        if self._file is not None and self._first is not None:
            if self._file.saved is None:
                self._file.mark_saved(self._first)
            self._in_file = self._shown
            self.changed.emit()

    def ask_take_over(self) -> None:
        """Take over the recording that is shown, after the question about unsaved changes."""
        if self._session.replay.taking_over:
            return
        replay = self._session.replay.current
        self.leave(self._take_over, after=None if replay is None else replay.settings)

    def _take_over(self) -> None:
        self._in_file_before = self._in_file
        self._session.replay.take_over()

    def _on_taken_over(self) -> None:
        """A grid that was recorded is unsaved, unless the scene behind the recording has it, too, and is saved."""
        run = self._session.run
        known = self._in_file_before
        if run is None or not (scene := run.prepared.scene).grids:
            return
        if known is None or not have_same_skin(known, scene):
            self._file = DocumentFile(None, None, folder=self._folder)
            self._in_file = None
            self.changed.emit()

    # Edits that a crash left.

    def _release_leftovers(self) -> None:
        for leftover in (*self._leftovers, *self._restored):
            leftover.release()
        self._leftovers.clear()
        self._restored.clear()
        self._notifier.withdraw()

    def _find_leftovers(self, prepared: PreparedScene, document: MapDocument) -> None:
        """Claim the autosaves of this skin, or of this robot with another skin."""
        found: list[Leftover] = []
        with suppress(OSError):
            found = find_leftovers(autosave_folder(prepared.robot.name))
        for leftover in found:
            if same_skin(document.skin, leftover.document.skin) or _same_robot(leftover.scene, prepared.scene):
                self._leftovers.append(leftover)
            else:
                leftover.release()
        self._offer()
        self.changed.emit()

    def _offer(self, _player: object = None) -> None:
        """Offer the newest edits until the user decides; not during a replay, which shows another map."""
        if not self._leftovers or self._session.replay.player is not None:
            self._notifier.withdraw()
            return
        file = self._leftovers[0].file
        subject = "This map" if file is None else file.name
        unopened = " They include a skin chosen for another robot." if self._leftovers[0].unopened else ""
        more = f" There are {len(self._leftovers)} such copies, this is the newest." if len(self._leftovers) > 1 else ""
        self._notifier.offer(
            f"{subject} has edits that were not saved when the program ended.{unopened}{more}",
            remedies=[self._context.actions["restore_map"], self._context.actions["discard_restore"]],
            dismiss="Later",
        )

    def restore(self) -> None:
        """Restore edits that a crash left; ask first if that replaces newer edits."""
        if not self._leftovers or not self._editor.enabled:
            return
        texts = list[str]()
        first = self._leftovers[0]
        document = self._editor.document
        on_skin = document is not None and same_skin(document.skin, first.document.skin)
        replaced = {"map"} if on_skin else {"map", "skin"}
        if replaced & {*self.unsaved} and self._context.settings.preferences.asks(Question.RESTORE):
            texts.append("The map was edited since. Restoring replaces these edits; Undo brings them back.")
        if (first.cover and self._choice is not None) or (first.unopened and self._unopened is not None):
            texts.append("A skin was chosen since. Restoring replaces this choice.")
        if not texts:
            self._restore()
            return

        def answered(answer: Button) -> None:
            if answer == Button.Yes:
                self._restore()
            else:
                self._offer()

        self._context.dialogs.ask(
            "restore",
            "Replace the edits?",
            " ".join(texts),
            Button.Yes | Button.Cancel,
            answered,
            default=Button.Cancel,
        )

    def _restore(self) -> None:
        document = self._editor.document
        leftover = self._leftovers[0]
        assert document is not None
        assert self._file is not None
        if not same_skin(document.skin, leftover.document.skin):
            self._restoring = leftover
            self.skin_restored.emit(self._scene_of(leftover))
            return
        if not self._editor.do("Restore", lambda present: adopt_document(present, leftover.document)):
            return
        if leftover.newer_than_file and leftover.file != self._file.path:
            self._file = DocumentFile(leftover.file, None, folder=self._folder)
        self._restore_settings(leftover)
        self._drop_restored(leftover)

    def _restore_settings(self, leftover: Leftover) -> None:
        """Restore the settings of the scene, if they were not saved, and the chosen skin."""
        with self._notifier.errors_shown("restore edits"):
            if leftover.scene:
                self._scene.restore(self._scene_of(leftover))
            if leftover.cover:
                self.note_choice(cover_from_toml(leftover.cover))
                self.choice_restored.emit()
            if leftover.unopened:
                scene = scene_from_toml(leftover.unopened, name="restored")
                choice = UnopenedChoice(scene, cover_from_toml(leftover.unchosen))
                self.note_unopened(choice)
                self.unopened_restored.emit(choice)

    def _scene_of(self, leftover: Leftover) -> Scene:
        """Return the scene of an autosave, with the name of the scene that runs."""
        own = self._scene.scene
        return scene_from_toml(leftover.scene, name="restored" if own is None else own.name)

    def _delete(self, restored: Sequence[Leftover]) -> None:
        """Delete restored autosaves."""
        for leftover in [*restored]:
            self._restored.remove(leftover)
            with self._notifier.errors_shown("autosave"):
                leftover.discard()

    def _drop_restored(self, leftover: Leftover) -> None:
        """Delete a restored autosave once there is another one of the restored document."""
        self._leftovers.remove(leftover)
        self._restored.append(leftover)
        self.autosave()
        self._offer()
        self.changed.emit()

    def discard_leftover(self) -> None:
        """Delete edits that a crash left; ask first."""
        if not self._leftovers:
            return

        def answered(answer: Button) -> None:
            if answer == Button.Discard and self._leftovers:
                with self._notifier.errors_shown("discard edits"):
                    self._leftovers.pop(0).discard()
            self._offer()
            self.changed.emit()

        text = "The edits that were not saved when the program ended are deleted. This cannot be undone."
        self._context.dialogs.ask(
            "discard", "Discard the edits?", text, Button.Discard | Button.Cancel, answered, default=Button.Cancel
        )

    # Saving.

    def _save_applied(self) -> None:
        """Save all changes, after the chosen skin is applied, and once it is shown; report what cannot be saved."""
        unsaved = {*self.unsaved}
        refused = self._refused(unsaved)
        if refused:
            self._notifier.fault(" ".join(refused.values()), of="change skin")
            if not unsaved - {*refused}:
                return
        if self._choice is not None and _CHOSEN not in refused:
            self.apply_requested.emit()
        if self._preparing_skin:
            self._saves_next = self._save_applied
        else:
            self.save_all()

    def save_all(self) -> bool:
        """Save all changes: the scene if it contains any, and the map if it was edited. Return success.

        Without any changes, save the map.
        """
        unsaved = self._changed
        if {*unsaved} - {"map"} and not self._scene.save_own():
            return False
        if unsaved and "map" not in unsaved:
            return "map" not in self._changed
        return self.save(self._scene.path if {*unsaved} - {"map"} else None)

    def save(self, scene: Path | None = None) -> bool:
        """Save the map; ask for a file the first time, or before replacing a changed one. Return success.

        The first file is next to that of the scene, if the scene has one.

        Args:
            scene: File of the scene that was saved just now, which the message names too.
        """
        if self._file is None:
            return False
        if self._file.path is None:
            shown = self._scene.scene
            path = None if shown is None else map_file_of(self._scene.path, shown)
            return self.choose_save(scene) if path is None or path.exists() else self._save(path, scene)
        path = self._file.path
        if not self._file.changed_elsewhere:
            return self._save(path, scene)
        text = f"{path} was changed by another window or program since it was opened or saved here."
        buttons = Button.Save | Button.Cancel

        def answered(answer: Button) -> None:
            if answer == Button.Save:
                self._save(path)

        self._context.dialogs.ask(
            "overwrite", "Replace the changed file?", text, buttons, answered, default=Button.Cancel
        )
        return False

    def choose_save(self, scene: Path | None = None) -> bool:
        """Ask for a file and save the map; for ``scene`` see ``save``. Return whether it was saved."""
        prepared = self._session.prepared
        if prepared is None:
            return False
        own = self.path or self._scene.path
        name = f"{prepared.robot.name if own is None else own.stem}.npz"
        path = self._context.dialogs.save_file("Save map", name, _MAPS, remembers=False)
        return bool(path) and self._save(Path(path), scene)

    def _save(self, path: Path, scene: Path | None = None) -> bool:
        document = self._editor.document
        if self._file is None or document is None:
            return False
        self._wait()
        is_first = self._file.path is None
        try:
            self._file.save_as(document, path)
        except TactileMapsError as error:
            self._notifier.fault(str(error), of="save map")
            return False
        if self._new_skin:
            text = f"Saved {path}. Save the scene too: it contains the skin."
            self._notifier.say(text, remedies=[self._context.actions["save_scene"]], of="save map")
        elif is_first and self._scene.path is None:
            self._scene.proposed = path.stem
            text = f"Saved {path}. Save the scene as {path.stem}.toml to open both together."
            self._notifier.say(text, remedies=[self._context.actions["save_scene"]], of="save map")
        else:
            self._notifier.succeed("save map")
            also = "" if scene is None else f" and {scene.name if scene.parent == path.parent else scene}"
            self._notifier.say(f"Saved {path}{also}", of="save scene" if also else "save map")
        self._context.settings.add_recent(str(path))
        self.changed.emit()
        return True

    def choose_export(self) -> None:
        """Ask for a file and export the map for other programs."""
        prepared = self._session.prepared
        if prepared is None:
            return
        unsuitable = unsuitable_formats(prepared.skin)
        kinds = {ending: f"{title} (*{ending})" for ending, title in TITLES.items()}
        kinds.update({ending: f"{TITLES[ending]}: {reason} ()" for ending, reason in unsuitable.items()})
        path = self._context.dialogs.save_file("Export map", prepared.robot.name, ";;".join(kinds.values()))
        if path:
            self.export(path)

    def export(self, path: str) -> None:
        """Write the map in the format of the file name."""
        document = self._editor.document
        prepared = self._session.prepared
        if document is None or prepared is None:
            return
        with self._notifier.errors_shown("export map"):
            if Path(path).suffix.lower() not in TITLES:
                raise unknown_format(Path(path), TITLES, MapError)
            if Path(path).suffix.lower() == SENSORS_ENDING:
                frames = taxel_frames(document.map)
                write_touch_sensors(document.map.skin, prepared.robot, path, frames=frames)
            else:
                write_map(document.map, path)
            self._notifier.say(f"Exported {path}")

    # Opening.

    def choose_open(self) -> None:
        """Ask for a saved map."""
        path = self._context.dialogs.open_file("Open map", _OPENED)
        if path:
            self.open(path)

    def open(self, path: str) -> bool:
        """Apply a saved map of this skin as one edit; the map is saved there from then on. Return whether it worked."""
        if self._file is None:
            self._notifier.say(f"{path}: open the robot of this map first.", fault=True, of="open map")
            return False
        if Path(path).suffix.lower() in (".obj", ".svg"):
            return self._open_exported(path)
        try:
            _check_map(path)
            other = load_document(path)
        except TactileMapsError as error:
            self._notifier.fault(str(error), of="open map")
            return False
        if not self._editor.do(f"Open {Path(path).name}", lambda document: adopt_document(document, other)):
            return False
        self._wait()
        self._file.drop_autosave()
        self._file = DocumentFile(Path(path), self._editor.document, folder=self._folder)
        self._context.settings.add_recent(path)
        self._context.dialogs.remember_opened(path)
        self._notifier.succeed("open map")
        self.changed.emit()
        return True

    def _open_exported(self, path: str) -> bool:
        """Apply an exported mesh or drawing of this skin as an edit; the file of the map stays the same."""
        document = self._editor.document
        assert document is not None
        name = f"Open {Path(path).name}"
        drawing: TaxelLayout | None = None
        try:
            if Path(path).suffix.lower() == ".obj":
                other = MapDocument.of(read_map_obj(path, document.skin))
                edit = partial(adopt_document, other=other)
            else:
                drawing, placed = read_svg_taxels(path)
                edit = partial(place_as_drawn, drawing=drawing, placed=placed)
                edit(document)  # raises before the edit begins
        except TactileMapsError as error:
            self._notifier.fault(str(error), of="open map")
            return False
        if not self._editor.do(name, edit):
            return False
        if drawing is not None and not is_drawn_so(document, drawing):
            self._editor.ask(partial(pin_as_drawn, drawing=drawing))
        self._context.settings.add_recent(path)
        self._context.dialogs.remember_opened(path)
        self._notifier.succeed("open map")
        return True

    # Autosave, and unsaved edits.

    def autosave(self) -> None:
        """Write unsaved edits to the autosave in another thread, after an autosave that is being written."""
        self._due = not self._written()
        document = self._editor.document
        if self._due or self._file is None or document is None or self._editor.gesture:
            return
        texts = {"scene": self._scene_text, "cover": self._cover_text, "unopened": self._unopened_text}
        texts["unchosen"] = "" if self._unopened is None else cover_to_toml(self._unopened.default)
        self._replaced = [*self._restored]
        self._writing = self._writer.submit(self._file.autosave, document, origin=self._origin, **texts)
        self._writing.add_done_callback(lambda _writing: self._autosave_ended.emit())

    def _on_autosave_ended(self) -> None:
        if self._written() and self._due:
            self.autosave()

    @property
    def _scene_text(self) -> str:
        """The scene that runs as text, if it has changes that are not saved; else empty."""
        scene = self._scene.to_write
        return scene_to_toml(scene) if scene is not None and {*self._changed} - {"map"} else ""

    @property
    def _origin(self) -> dict[str, str]:
        """Name of the document, and the scene that was opened for it, for the next start after a crash."""
        opened = "" if self._in_file is None else scene_to_toml(self._in_file)
        file = self._scene.path
        return {"name": self.name, "opened": opened, "opened_file": "" if file is None else str(file.absolute())}

    @property
    def _cover_text(self) -> str:
        """The chosen cover as text; empty without one."""
        return "" if self._choice is None else cover_to_toml(self._choice)

    @property
    def _unopened_text(self) -> str:
        """The scene that is not open, with its chosen skin, as text; empty without one."""
        return "" if self._unopened is None else scene_to_toml(self._unopened.scene)

    def _written(self) -> bool:
        """Whether the last autosave is complete; an error is reported once."""
        if self._writing is None:
            return True
        if not self._writing.done():
            return False
        writing = self._writing
        self._writing = None
        error = writing.exception()
        if error is None:
            self._delete(self._replaced)
            return True
        self._due = False
        if not isinstance(error, TactileMapsError):
            self._notifier.unexpected(error)
        elif not self._reported_unwritable:
            self._reported_unwritable = True
            self._notifier.fault(str(error), of="autosave")
        self._timer.stop()
        return True

    def _wait(self) -> None:
        if self._writing is not None:
            self._writing.exception()
            self._written()

    def leave(
        self, then: Callable[[], None], *, after: RuntimeSettings | None = None, opens_choice: bool = False
    ) -> None:
        """Call ``then``, which may replace the document, after unsaved changes are saved or the user discards them.

        The document stays until another one replaces it or the window closes: a scene may fail to open.

        Args:
            then: Called unless the user cancels.
            after: Settings of the session that ``then`` starts; parts that it continues are not asked about.
            opens_choice: Whether ``then`` opens the robot whose skin is chosen, so that the choice is kept.
        """
        unsaved = self.unsaved
        kept = {*self._unopened_names} if opens_choice else set()
        if after is not None:
            kept |= {*self._scene.unsaved} - {*self._scene.lost(after)}
        unsaved = tuple(name for name in unsaved if name not in kept)

        def go(discarding: bool) -> None:
            choice = self._choice
            self._session.cancel_loading()  # may note a skin that was being prepared as a choice again
            if discarding:
                self.note_choice(choice)
            self._go(then, discarding)

        self._ask(unsaved, go, lambda: None)

    def leave_again(self, then: Callable[[], None], otherwise: Callable[[], None]) -> None:
        """Do the same as ``leave``, but only ask about changes made since the user discarded the others.

        Args:
            then: Called unless the user cancels.
            otherwise: Called if the user cancels.
        """
        unsaved = self.unsaved
        left = self._left
        if left is not None:
            same = left.document is self._editor.document
            kept = {"map": same, "skin": same, _CHOSEN: left.choice == self._choice}
            kept |= dict.fromkeys(self._unopened_names, left.unopened == self._unopened)
            lost = () if left.settings is None else self._scene.lost(left.settings)
            unsaved = tuple(name for name in unsaved if not kept.get(name, name not in lost))
        if self.opening_chosen:
            unsaved = tuple(name for name in unsaved if name not in self._unopened_names)

        def go(discarding: bool) -> None:
            if self._session.opening:  # otherwise it was cancelled meanwhile
                self._go(then, discarding)

        self._ask(unsaved, go, otherwise)

    def stay(self) -> None:
        """Keep the document: nothing replaces it."""
        self._discarded = False
        self._left = None
        self._chosen = None

    def _go(self, then: Callable[[], None], discarding: bool) -> None:
        self._discarded = True
        self._left = None
        if discarding:
            self._left = _Discarded(self._editor.document, self._scene.made, self._choice, self._unopened)
        then()

    def _ask(self, unsaved: tuple[str, ...], go: Callable[[bool], None], otherwise: Callable[[], None]) -> None:
        """Call ``go`` with whether the user discards unsaved parts, after saving them if not.

        A chosen skin is applied first, and a skin that is being prepared is saved once it is shown. Save is offered
        only if it can save something.
        """
        if not unsaved:
            go(False)
            return
        choice = self._choice
        refused = self._refused(unsaved)
        savable = [name for name in unsaved if name not in refused]
        applies = _CHOSEN in savable

        def save() -> None:
            if not self.save_all():
                otherwise()
            elif self._choice in (None, choice):
                go(bool(refused))
            else:
                self._ask((_CHOSEN,), go, otherwise)

        def answered(answer: Button) -> None:
            if answer == Button.Discard:
                go(True)
                return
            if answer == Button.Save and applies:
                self.apply_requested.emit()
            if answer != Button.Save or (applies and self._choice is not None):
                otherwise()
            elif self._preparing_skin:
                self._saves_next = save
            else:
                save()

        more = [*refused.values()]
        if refused and savable:
            more.append("Save saves the other changes, and the chosen skin is lost.")
        if applies:
            more.append("Save applies the chosen skin first.")
        elif savable and self._preparing_skin:
            more.append("Save waits until the new skin is prepared.")
        text = " ".join((f"These parts have changes that are not saved: {', '.join(unsaved)}.", *more))
        buttons = Button.Discard | Button.Cancel
        if savable:
            buttons |= Button.Save
        default = Button.Save if savable else Button.Cancel
        self._context.dialogs.ask("leave", "Save the changes?", text, buttons, answered, default=default)

    def _refused(self, unsaved: Collection[str]) -> dict[str, str]:
        """Return why unsaved parts cannot be saved now, by the names of these parts."""
        reasons = {_CHOSEN: self.choice_refusal()}
        if self._unopened is not None:
            robot = self._unopened.robot
            reasons[self._unopened.name] = f"{robot} is not open yet: Open in the panel Skin opens it with this skin."
        words = "The chosen skin cannot be saved now."
        return {name: f"{words} {reason}" for name, reason in reasons.items() if reason and name in unsaved}

    def give_up(self) -> None:
        """Discard unsaved edits."""
        self._discarded = True
        self.end()

    def close(self) -> None:
        """Complete the autosave, or delete it if the edits were saved or discarded."""
        self._timer.stop()
        self._discarded = self._discarded or not self.unsaved
        self.end()
        self._writer.shutdown()


def autosave_folder(robot: str) -> Path:
    """Return the folder for autosaves of the maps of a robot, with a subfolder for each window."""
    return user_state_path("tactile-maps", appauthor=False) / "autosave" / "".join(c for c in robot if c.isalnum())


def _check_map(path: str) -> None:
    """Raise an error that names the menu entry for a file of another kind."""
    kind = kind_of(path)
    if kind in _ENTRIES:
        raise MapError(f"this is a {kind.value}, not a map", file=path, remedy=f"Open it with File > {_ENTRIES[kind]}")
    if kind is not FileKind.MAP and Path(path).exists():
        raise MapError(
            "this type of file is not a map",
            file=path,
            value=Path(path).suffix or "no file extension",
            remedy="Choose one of: .npz, .obj, .svg",
        )


def _same_robot(text: str, scene: Scene) -> bool:
    """Whether ``text`` is a scene with the robot and the taxel files of ``scene``."""
    try:
        other = scene_from_toml(text, name="restored") if text else None
    except TactileMapsError:
        return False
    return other is not None and (other.robot, other.taxel_files) == (scene.robot, scene.taxel_files)
