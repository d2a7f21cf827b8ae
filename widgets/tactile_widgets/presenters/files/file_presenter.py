"""Opening of robots, scenes, recordings and taxel files, by dialogs, menus and drops.

The File menu lists the robots and scenes of the program and recent files.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtGui import QAction, QGuiApplication
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.core.errors import SkinError, TactileMapsError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.maps.formats.export import is_exported_map
from tactile_maps.robots.library import list_robots
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene, with_package_roots
from tactile_maps.scene.scene_file import (
    file_names,
    load_scene,
    scene_for,
    scene_for_taxels,
    scene_names,
    with_grid,
    with_taxels,
)
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.fitting.grid import GridSpec, is_grid_patch
from tactile_maps.skin.formats.identify import identify, is_robot_with_taxels, kind_of
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_widgets.common.file_dialogs import (
    OPENED,
    RECORDING_FILTER,
    ROBOT_FILTER,
    SCENE_FILTER,
    taxel_filter,
)
from tactile_widgets.common.make import add_entry
from tactile_widgets.common.settings import Question
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.document.skin_steps import have_same_skin
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.history_panel import HistoryPanel
from tactile_widgets.presenters.files.study_presenter import StudyPresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.presenters.maps.scene_file_presenter import SceneFilePresenter
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter
from tactile_widgets.tools.map_editing.grid_tool import GridTool
from tactile_widgets.tools.registry import Tools

_READ_AT_ONCE_BYTES = 2_000_000
_DROPS = {
    FileKind.RECORDING: "Replay the recording {}",
    FileKind.STUDY_TABLE: "Plot the study table {}",
    FileKind.MAP: "Open the map {}",
    FileKind.TAXELS: "Place the taxels of {}",
    FileKind.SKIN: "Place the taxels of {}",
    FileKind.LAYOUT: "Open the flat skin {}",
    FileKind.SCENE: "Open the scene {}",
    FileKind.MESH: "Open the mesh {}",
}
"""Effect of dropping a file by kind; other files open as a robot."""
"""Largest taxel file that is read at once, in 0.2 s."""


class FilePresenter(Presenter):
    """Opens files.

    Args:
        context: Session, views, panels and services of the window.
        effects: Scene with the chosen effects.
        map_files: Asks about unsaved changes before another scene is opened.
        scene_file: File of the scene.
        studies: Shows tables of studies.
        tools: Tools, of which one places taxel grids; each makes another scene.
        parent: Window over which dialogs open.
    """

    def __init__(
        self,
        context: AppContext,
        effects: EffectsPresenter,
        map_files: MapFilePresenter,
        scene_file: SceneFilePresenter,
        studies: StudyPresenter,
        tools: Tools,
        parent: QWidget,
    ) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self._map_files = map_files
        self._scene_file = scene_file
        self._skin_steps = tools.skin_steps
        self._control = tools.control
        self._studies = studies
        tools.get(GridTool).placed.connect(self._on_grid_placed)
        tools.skin_steps.scene_requested.connect(self._show_skin_scene)
        tools.skin_steps.cancel_requested.connect(self._on_skin_cancel_requested)
        map_files.skin_restored.connect(self._on_skin_restored)
        context.session.prepared_changed.connect(self._on_prepared_changed)
        context.panels.get(HistoryPanel).follow_skin(tools.skin_steps)
        context.panels.get(ControllerPanel).scene_requested.connect(self.open_shipped)
        self._open_again: Callable[[], None] | None = None
        self._begun: tuple[str, Callable[[], None]] = "", lambda: None  # name of the opened scene; opens it again
        self._reopen = QAction("Open again", self)
        self._reopen.triggered.connect(lambda: self._stopped())
        self._stopped: Callable[[], None] = lambda: None  # opens again what a change of the skin stopped
        self._opening: str | None = None
        self._imported: str | None = None  # file of the step that is pushed
        context.session.opening_stopped.connect(self._on_opening_stopped)
        context.actions.bind(
            open_robot=partial(self._choose, "Open robot", ROBOT_FILTER),
            open_recording=partial(self._choose, "Open recording", RECORDING_FILTER),
            import_taxels=self.choose_taxels,
            open_scene=partial(self._choose, "Open scene", SCENE_FILTER),
            package_root=self.choose_package_root,
            copy_command=self.copy_command,
            open_path_scene=partial(self.open_shipped, "follow_path"),
        )

    # Opening.

    def open_path(self, path: str) -> None:
        """Open a file of any kind; report an error if it cannot be opened."""
        with self._notifier.errors_shown("open file", finishes=False):
            if is_exported_map(path):
                self._map_files.open(path)
                return
            match identify(path, expected=OPENED):
                case FileKind.RECORDING:
                    self._session.cancel_loading()
                    self._opening = path
                    self._session.open_recording(path)
                case FileKind.STUDY_TABLE:
                    self._studies.open(path)
                case FileKind.MAP:
                    self._map_files.open(path)
                case FileKind.TAXELS | FileKind.SKIN:
                    self.import_taxels(path)
                case FileKind.LAYOUT:  # a flat skin, which no robot can carry
                    self.open_scene(scene_for_taxels(path), recent=path)
                case FileKind.SCENE:
                    self.open_scene(load_scene(path), file=Path(path), recent=path)
                case _:
                    self.open_scene(scene_for(path), recent=path)

    def open_paths(self, paths: Sequence[str]) -> None:
        """Open files that were dropped together: all of them if they are files of taxels, otherwise the first."""
        if len(paths) > 1 and all(kind_of(path) in (FileKind.TAXELS, FileKind.SKIN) for path in paths):
            with self._notifier.errors_shown("open file", finishes=False):
                self.import_taxels(*paths)
        elif paths:
            self.open_path(paths[0])

    def drop_text(self, paths: Sequence[str]) -> str:
        """Return what ``open_paths`` will do."""
        if not paths:
            return "Only files of this computer can be opened"
        kinds = {kind_of(path) for path in paths}
        taxels = kinds <= {FileKind.TAXELS, FileKind.SKIN}
        name = f"{len(paths)} files" if taxels and len(paths) > 1 else Path(paths[0]).name
        first = f" (the first of {len(paths)} files)" if len(paths) > 1 and not taxels else ""
        try:
            kind = FileKind.MAP if is_exported_map(paths[0]) else identify(paths[0], expected=OPENED)
        except TactileMapsError:
            return f"{name} cannot be opened"
        return f"{_DROPS.get(kind, 'Open the robot {}').format(name)}{first}"

    def choose_taxels(self) -> None:
        """Ask for taxel files; a single robot file that defines taxels is opened with them."""
        paths = self._context.dialogs.open_files("Import taxels", taxel_filter())
        if len(paths) == 1 and is_robot_with_taxels(paths[0], kind_of(paths[0])):
            self.open_scene(scene_for_taxels(*paths), recent=paths[0])
        elif len(paths) == 1:
            self.open_path(paths[0])
        elif paths:
            with self._notifier.errors_shown("open file", finishes=False):
                for path in paths:
                    identify(path, expected=(FileKind.TAXELS, FileKind.SKIN, FileKind.MAP))
                self.import_taxels(*paths)

    def open_robot(self, name: str) -> None:
        """Open a robot by name."""
        self.open_scene(scene_for(name))

    def open_shipped(self, name: str) -> None:
        """Open a scene of the program by name."""
        self.open_scene(load_scene(name))

    def import_taxels(self, *paths: str) -> None:
        """Place the taxels of files on the current robot; ask for the link where the robot lacks that of a file.

        If the skin is from files already, ask whether the new files replace them or are added.

        Raises:
            SkinError: A file cannot be read.
        """
        scene = self._effects.scene
        before = () if scene is None else scene.taxel_files
        asks = self._context.settings.preferences.asks(Question.IMPORT)
        if not before or not asks or set(before) <= set(paths):
            self._import(paths, ())
            return
        choices = ["Replace", "Add"]
        text = f"The skin is from {file_names(before)}. Add the taxels of {file_names(paths)}, or replace the skin?"
        if set(paths) <= set(before):
            choices = ["Replace"]
            text = f"The skin is from {file_names(before)}. Replace it by the taxels of {file_names(paths)} alone?"

        def answered(answer: str) -> None:
            with self._notifier.errors_shown("open file", finishes=False):
                self._import(paths, before if answer == "Add" else ())

        self._context.dialogs.ask_button("taxels-again", "Import taxels", text, choices, answered)

    def _import(self, paths: Sequence[str], before: Sequence[str]) -> None:
        """Place the taxels of ``paths``, and of the files ``before``, which the scene has."""
        prepared = self._session.prepared
        scene = self._effects.scene
        paths = tuple(dict.fromkeys((*before, *paths)))
        if prepared is None or scene is None or (scene.robot == NO_ROBOT and not before):
            self.open_scene(scene_for_taxels(*paths), recent=paths[-1])
            return
        if scene.robot == NO_ROBOT:
            self._put_on(scene, paths, ())
            return
        known = scene.cover.links if before else ()
        self._ask_links(replace(scene, cover=replace(scene.cover, links=())), prepared.robot, paths, known)

    def _ask_links(self, scene: Scene, robot: Robot, paths: Sequence[str], known: tuple[str, ...]) -> None:
        """Ask in turn which link carries the taxels of each file that names none of the robot's.

        Args:
            scene: The scene.
            robot: Its robot.
            paths: The files.
            known: Links of the first ones of these files.
        """
        try:
            size = sum(Path(path).stat().st_size for path in paths)
        except OSError as error:
            raise SkinError("the file cannot be read", file=error.filename, value=error.strerror) from error
        files = TaxelFiles(paths)
        at_once = size <= _READ_AT_ONCE_BYTES  # larger files are read only in the background
        lacking = files.without_link(robot) if at_once else ()
        if len(lacking) <= len(known):
            if at_once:
                files.check_links(robot, known)
            self._put_on(scene, paths, known)
            return
        file = lacking[len(known)]
        alone = "No robot: the skin alone"
        choices = [link.name for link in robot.links if link.mesh is not None and len(link.mesh.faces)]
        if file.kind in (FileKind.SKIN, FileKind.MAP):
            choices = []  # it states its surface, which is that of its own link
        if len(paths) == 1:
            choices.append(alone)
        if not choices:
            files.check_links(robot)
        stated = ", ".join(name or "none" for name in file.links)
        text = f"{file.path.name} names no link of {robot.name} (link: {stated}). Which link carries its taxels?"

        def chosen(answer: str) -> None:
            if answer == alone:
                self.open_scene(with_taxels(replace(scene_for(NO_ROBOT), title=""), paths), recent=paths[-1])
            else:
                with self._notifier.errors_shown("open file", finishes=False):
                    self._ask_links(scene, robot, paths, (*known, answer))

        likely = likely_link(file.path.stem, [choice for choice in choices if choice != alone])
        self._context.dialogs.ask_choice("taxel-link", "Which link?", text, choices, chosen, proposed=likely)

    def _put_on(self, scene: Scene, paths: Sequence[str], links: tuple[str, ...]) -> None:
        """Show the scene with the taxels of files, as one step where it runs."""
        session = self._session
        placed = with_taxels(scene, paths, links=links)
        running = session.run if session.replay.player is None and session.live_input is None else None
        if running is None or have_same_skin(placed, running.prepared.scene):  # the content of a file may have changed
            self.open_scene(placed, recent=paths[-1])
        else:
            self._imported = paths[-1]
            self._skin_steps.push("Import taxels", running.prepared.scene, placed)

    def open_given(self, scene: Scene, file: Path | None) -> None:
        """Open the scene of a command line, which may differ from its file by other options."""
        self.open_scene(scene, file=file, recent=None if file is None else str(file), read=True)

    def open_scene(
        self,
        scene: Scene,
        *,
        file: Path | None = None,
        recent: str | None = None,
        read: bool = False,
        chosen: bool = False,
    ) -> None:
        """Open a scene, read from ``file`` or made here, after the question about unsaved changes.

        Args:
            scene: Scene to open.
            file: File of the scene.
            recent: File that the user chose; added to the recent files once the scene is open.
            read: Whether the file was read with all checks just now, so that it is not read again.
            chosen: Whether the user chose its skin in the panel, so that no file contains it.
        """
        again = partial(self.open_scene, scene, file=file, recent=recent, read=read, chosen=chosen)
        self._open_again = again

        def start() -> None:
            self._opening = recent
            self._begun = scene.title or scene.name, again
            self._scene_file.expect(file)
            self._map_files.expect_chosen(scene if chosen else None)
            rooted = with_package_roots(scene, self._context.settings.package_roots)
            self._session.open_scene(rooted, file=None if read else file)

        self._map_files.leave(start, opens_choice=chosen)

    def choose_package_root(self) -> None:
        """Ask for a folder with packages and meshes for robot files; open the last scene again."""
        folder = self._context.dialogs.open_folder("Choose package root")
        if folder:
            self._context.settings.add_package_root(folder)
            self._context.dialogs.remember_opened(folder)
            self._notifier.say(f"Robot files may use the packages and meshes in {folder}")
            if self._open_again is not None:
                self._open_again()

    def _on_grid_placed(self, grid: GridSpec) -> None:
        session = self._session
        if session.live_input is not None:
            self._notifier.fault(
                "A grid changes the skin, which is connected to a source. Disconnect first.", of="change skin"
            )
            return
        if (prepared := session.prepared) is not None:
            covered = [patch.link for patch in prepared.skin.patches if not is_grid_patch(patch)]
            scene = prepared.scene if self._effects.scene is None else self._effects.scene
            placed = with_grid(scene, replace(grid, axes=scene.cover.axes), covered)
            self._skin_steps.push("Taxel grid", prepared.scene, placed)
            if grid.link in covered and not prepared.scene.taxel_files:
                self._notifier.say(f"The grid replaces the cover of {grid.link}; Undo brings it back", of="change skin")

    def _on_skin_restored(self, scene: Scene) -> None:
        """Change the skin to one that a crash left, as a step."""
        prepared = self._session.prepared
        if prepared is not None:
            self._skin_steps.push("Restore skin", prepared.scene, scene)

    def _show_skin_scene(self, scene: Scene) -> None:
        """Show the scene before or after a change of the skin; no question, because the current document is kept."""
        session = self._session
        if session.live_input is not None:
            self._skin_steps.stop()
            self._notifier.fault(
                "The skin cannot be changed while it is connected to a source. Disconnect first.", of="change skin"
            )
            return
        self._map_files.keep_document()
        self._opening = self._imported
        self._imported = None
        kept = self._skin_steps.after
        if kept is None:
            session.open_scene(with_package_roots(scene, self._context.settings.package_roots))
        else:
            settings = self._control.settings_on(kept.control, kept.settings.settings)
            if not session.show_prepared(kept.prepared, replace(kept.settings, settings=settings)):
                self._on_opening_stopped()

    def _on_skin_cancel_requested(self, name: str) -> None:
        """Stop opening the scene of a step, or another scene or a recording, which can be opened again."""
        session = self._session
        recording = session.opening_recording
        subject, again = self._begun
        if recording is not None:
            subject, again = recording.name, partial(self.open_path, str(recording))
        other = session.opening and not name and not session.replay.taking_over
        session.cancel_loading()
        if name:
            self._notifier.status(f"{name}: cancelled")
        elif other:
            self._stopped = again
            text = f"The opening of {subject} was cancelled, because the skin is being changed."
            self._notifier.say(text, remedies=[self._reopen], of="open again", lasting=True)

    def _on_prepared_changed(self, _prepared: PreparedScene) -> None:
        """Add the opened file to the recent files."""
        if self._session.opening:
            return  # what is shown was restarted meanwhile
        if self._opening is not None:
            self._context.settings.add_recent(self._opening)
            self._context.dialogs.remember_opened(self._opening)
        self._opening = None

    def _on_opening_stopped(self) -> None:
        self._opening = None
        self._scene_file.expect(None)
        self._map_files.stop_skin()

    def _choose(self, title: str, kinds: str) -> None:
        path = self._context.dialogs.open_file(title, kinds)
        if path:
            self.open_path(path)

    def copy_command(self) -> None:
        """Copy the command line that opens the current scene or recording to the clipboard."""
        session = self._session
        if session.replay.player is not None:
            words = ["replay", str(session.replay.player.path)]
            left_out = False
        elif session.prepared is None or session.live_input is not None:
            self._notifier.status("Only simulations and recordings can be opened by a command line")
            return
        else:
            words, left_out = scene_words(session.prepared.scene, self._scene_file.path)
            left_out = left_out or bool(self._map_files.unsaved)
        line = shlex.join(["tactile-maps", *words])
        QGuiApplication.clipboard().setText(line)
        more = "; later changes are left out, save the scene to keep them" if left_out else ""
        self._notifier.status(f"Copied: {line}{more}")

    # Menus.

    def list_robots(self, menu: QMenu) -> None:
        """List the known robots; tool tips of unavailable ones say how to get them."""
        if menu.isEmpty():
            for entry in list_robots():
                about = {"objectName": f"robot-{entry.name}", "enabled": entry.available, "toolTip": entry.remedy}
                add_entry(menu, entry.title, partial(self.open_robot, entry.name), **about)

    def list_scenes(self, menu: QMenu) -> None:
        """List the scenes of the program when the menu is opened: reading them takes 0.1 s."""
        if menu.isEmpty():
            menu.setToolTipsVisible(True)
            for name in scene_names():
                scene = load_scene(name)
                tip = f"{scene.description}\nTry: {scene.suggestion}"
                show = partial(self.open_shipped, name)
                add_entry(menu, scene.title or name, show, objectName=f"scene-{name}", toolTip=tip)

    def list_recent(self, menu: QMenu) -> None:
        """List the recent files."""
        menu.clear()
        for path in self._context.settings.recent:
            add_entry(menu, path, partial(self.open_path, path))
        if menu.isEmpty():
            menu.addAction("Nothing opened yet").setEnabled(False)


def scene_words(scene: Scene, file: Path | None) -> tuple[list[str], bool]:
    """Return the arguments of a command line that opens a scene, and whether they leave out changes.

    Args:
        scene: Current scene.
        file: File of the scene; None for a scene of the program, or of a robot or skin alone.
    """
    if file is not None:
        words = ["gui", "--scene", str(file)]
        left_out = False
        known_home = _home_in(file)
    elif scene.name in scene_names():
        known = load_scene(scene.name)
        words = ["gui", "--scene", scene.name]
        left_out = replace(scene, home=known.home) != known
        known_home = known.home
    else:
        words = ["gui", "--robot", scene.robot]
        for path in scene.taxel_files:
            words += ["--skin", path]
        known = scene_for_taxels(*scene.taxel_files) if scene.robot == NO_ROBOT else scene_for(scene.robot)
        same = replace(scene, taxel_files=known.taxel_files, cover=known.cover, home=known.home, package_roots=())
        left_out = same != known
        known_home = known.home
    stated = [f"{joint}={value!r}" for joint, value in scene.home.items() if known_home.get(joint) != value]
    return [*words, *([f"--home={','.join(stated)}"] if stated else [])], left_out


def _home_in(file: Path) -> Mapping[str, float]:
    """Return the home posture that a scene file states; empty if it cannot be read."""
    try:
        return load_scene(str(file)).home
    except TactileMapsError:
        return {}


_LONG_WORD = 3
"""Length from which a word of a link's name distinguishes it; letters for sides and numbers are in many names."""


def likely_link(name: str, links: Sequence[str]) -> str | None:
    """Return the link whose words are best contained in the name of a file; None without a match."""
    stated = set(_words(name))

    def score(link: str) -> tuple[int, int]:
        """Return the number of characters of the words that match, and minus that of the others."""
        matched = [len(word) for word in _words(link) if word in stated]
        missing = sum(map(len, _words(link))) - sum(matched)
        return (sum(matched), -missing) if not missing or max(matched, default=0) >= _LONG_WORD else (0, 0)

    best = max(links, key=score, default=None)
    return None if best is None or score(best)[0] == 0 else best


def _words(name: str) -> list[str]:
    """Return the words and numbers of a name in lower case."""
    return re.findall(r"[a-z]+|[0-9]+", name.lower())
