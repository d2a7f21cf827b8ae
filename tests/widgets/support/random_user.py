"""A person who does anything at all: seeded acts through real events on the whole window.

An act is drawn by ``seed`` and its number alone, from what the window then shows: an action by its key, by the menu
or by triggering it; any visible button, slider, combo box, number, text, list or plot; mouse, wheel and keys on both
views with any tool; right clicks and their menus; fingers that stay; panels undocked, layouts kept and taken; the
palette; keys changed; recordings replayed, marked and taken over; files that are dropped or answered to a dialog,
good and bad, tables of studies among them; and time that passes. What is modal is answered as the next act, and a
menu that runs its own loop from within that loop.
"""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import shiboken6
from PySide6.QtCore import QEvent, QMimeData, QModelIndex, QPoint, QPointF, Qt, QTimer, QUrl
from PySide6.QtGui import (
    QAction,
    QContextMenuEvent,
    QDesktopServices,
    QDropEvent,
    QKeySequence,
    QMouseEvent,
)
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QGraphicsView,
    QHeaderView,
    QInputDialog,
    QLineEdit,
    QMenu,
    QMessageBox,
    QScrollArea,
    QSlider,
    QTableView,
    QWidget,
)

from tactile_maps.editing.arrange import rotate
from tactile_widgets.actions.keys_sheet import KeysSheet
from tactile_widgets.actions.registry import specs_in
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.palette import CommandPalette
from tactile_widgets.panels.model.skin_panel import SkinPanel
from tactile_widgets.plots.study_plot import StudyPlot
from tactile_widgets.plots.timeline.recording_plots import RecordingPlots
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tactile_widgets.presenters.files import recordings_presenter
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.tools.registry import TOOLS
from tactile_widgets.views.colour_bar import ColourBar
from tests.widgets.support.mouse import turn_wheel
from tests.widgets.support.window_checks import WindowChecks

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton
BUTTONS = (LEFT, LEFT, LEFT, Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton)
MODIFIERS = [
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.AltModifier,
]
VIEW_KEYS = [
    KEY.Key_Escape,
    KEY.Key_Return,
    KEY.Key_Delete,
    KEY.Key_Backspace,
    KEY.Key_Left,
    KEY.Key_Right,
    KEY.Key_Up,
    KEY.Key_Down,
    KEY.Key_Space,
    KEY.Key_PageUp,
    KEY.Key_PageDown,
    KEY.Key_Tab,
]
CONTROL_KEYS = [
    KEY.Key_Up,
    KEY.Key_Down,
    KEY.Key_Left,
    KEY.Key_Right,
    KEY.Key_Home,
    KEY.Key_End,
    KEY.Key_PageUp,
    KEY.Key_PageDown,
    KEY.Key_Delete,
    KEY.Key_Return,
    KEY.Key_Tab,
    KEY.Key_Space,
]
CHANGED_KEYS = [
    KEY.Key_T,
    KEY.Key_G,
    KEY.Key_U,
    KEY.Key_Space,
    KEY.Key_Escape,
    KEY.Key_Tab,
    KEY.Key_F7,
    KEY.Key_Question,
    KEY.Key_Z,
]
OPERATED = (
    QAbstractButton,
    QSlider,
    QComboBox,
    QAbstractSpinBox,
    QLineEdit,
    QAbstractItemView,
    ColourBar,
    ScrubBar,
    RecordingPlots,
    StudyPlot,
)
LEAVES = frozenset({"quit"})
"""Actions that end the window: what a run ends with."""
DEAR_ACTIONS = frozenset(
    {
        "weigh",
        "open_robot",
        "open_scene",
        "open_recording",
        "open_study",
        "import_taxels",
        "play_script",
        "package_root",
    }
)
"""Actions that simulate or open for seconds."""
DEAR_BUTTONS = frozenset({"comparison-run", "accuracy-measure", "budget-propose"})
"""The same, of the panels."""
BROKEN = ("broken.mcap", "broken.npz", "broken.toml", "broken.txt", "broken.urdf", "letter.docx")
FINDINGS = Path(__file__).resolve().parents[3] / "assets/findings"
LAST = 20


class RandomUser:
    """Acts on a window at random and checks it after each act; a context manager that replaces file dialogs.

    Args:
        window: Window that shows a scene.
        seed: Seed of all acts.
        folder: Folder for saving and finding files.
        pass_time: Advances the simulation and the window by about this time [s].
        scenes: Opens a scene by number; None for a user who opens no scenes and starts no long measurements.
        before: Called with a description of each act before it is done.
        works: Whether it mostly edits map, path and skin, and does acts that could lose them; needs ``scenes``.

    Attributes:
        done: Acts done.
        last: The last of them in words, with their numbers.
    """

    def __init__(
        self,
        window,
        seed: int,
        folder: Path,
        pass_time: Callable[[float], None],
        *,
        scenes: Callable[[int], str] | None = None,
        before: Callable[[str], None] = lambda _words: None,
        works: bool = False,
    ) -> None:
        self.window = window
        self.seed = seed
        self.folder = folder
        self._pass_time = pass_time
        self._scenes = scenes
        self._before = before
        self.done = 0
        self.last: deque[str] = deque(maxlen=LAST)
        self._rng = np.random.default_rng([seed, 0])
        self._checks = WindowChecks(window)
        self._answerer = QTimer()
        self._answerer.setInterval(5)
        self._answerer.timeout.connect(self._answer_popup)
        self._acting = False
        self._kinds = (
            (self._asks_an_action, 20),
            (self._operates, 30),
            (self._on_map, 18),
            (self._on_body, 14),
            (self._waits, 8),
            (self._records, 3),
            (self._drops_a_file, 2),
            (self._resizes, 1),
            (self._gesture_cut_short, 4),
            (self._right_clicks, 3),
            (self._latches, 3),
            (self._undocks, 2),
            (self._arranges, 1),
            (self._changes_a_key, 2),
            (self._replays, 3),
            (self._connects, 2),
            *(((self._opens, 1), (self._changes_the_skin, 1)) if scenes is not None else ()),
        )
        self._take_overs = 0.8 if works else 0.2
        self._choices = 0.6 if works else 0.0
        if works:
            self._kinds = (
                (self._works, 30),
                (self._replays, 20),
                (self._records, 12),
                (self._connects, 12),
                (self._opens, 6),
                (self._changes_the_skin, 6),
                (self._waits, 6),
                (self._asks_an_action, 8),
            )

    def __enter__(self) -> RandomUser:
        for name in BROKEN:
            (self.folder / name).write_bytes(b"\x89not what the name says\n" * 9)
        shutil.copy(FINDINGS / "loop-laws.csv", self.folder / "study.csv")
        asked = ("open_file", "save_file", "open_files", "choose_folder")
        self._kept = {name: getattr(FileDialog, name) for name in asked}
        FileDialog.open_file = lambda _parent, _title, _name, kinds="": self._file_to_open(kinds)
        FileDialog.open_files = lambda _parent, _title, _name, kinds="": (
            [path] if (path := self._file_to_open(kinds)) else []
        )
        FileDialog.save_file = lambda _parent, _title, name, _kinds="": self._file_to_save(name)
        FileDialog.choose_folder = lambda _parent, _title, _folder="": str(self.folder)
        self._opened, QDesktopServices.openUrl = QDesktopServices.openUrl, lambda _url: True
        self._trashed = recordings_presenter._to_trash
        recordings_presenter._to_trash = _away
        self._checks.__enter__()
        self._answerer.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._answerer.stop()
        self._checks.__exit__(*error)
        QDesktopServices.openUrl = self._opened
        recordings_presenter._to_trash = self._trashed
        for name, kept in self._kept.items():
            setattr(FileDialog, name, kept)

    def run(self, acts: int) -> None:
        """Do this number of acts.

        Raises:
            AssertionError: An invariant of the window failed; the message states how to repeat the acts.
        """
        for _ in range(acts):
            self.act()

    def act(self) -> None:
        """Do one, and look."""
        self._rng = np.random.default_rng([self.seed, self.done])
        self._say("nothing")
        try:
            self._acting = True
            modal = QApplication.activeModalWidget()
            popup = QApplication.activePopupWidget()
            if popup is not None:
                self._choose_in(popup)
            elif modal is not None:
                self._answer(modal)
            else:
                kinds, weights = zip(*self._kinds, strict=True)
                kinds[self._rng.choice(len(kinds), p=np.array(weights) / sum(weights))]()
            self._acting = False
            self._pass_time(0.02)
            QApplication.processEvents()
            # An event loop that turns would delete what was to be deleted; without one it stays for good.
            QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
            self._checks.check()
        except Exception as error:
            raise AssertionError(self._report(error)) from error
        finally:
            self._acting = False
        self.done += 1

    def _report(self, error: Exception) -> str:
        acts = "\n  ".join(self.last)
        return f"seed {self.seed}, act {self.done}: {type(error).__name__}: {error}\nthe last acts:\n  {acts}"

    def _say(self, words: str) -> None:
        line = f"{self.done}: {words}"
        if self.last and self.last[-1].split(":")[0] == str(self.done):
            self.last.pop()
        self.last.append(line)
        self._before(line)

    # Drawing.

    def _one_of(self, things):
        return things[int(self._rng.integers(len(things)))]

    def _chance(self, share: float) -> bool:
        return bool(self._rng.random() < share)

    # Actions.

    def _asks_an_action(self) -> None:
        left_out = LEAVES | (frozenset() if self._scenes else DEAR_ACTIONS)
        specs = [spec for spec in self.window.context.actions.specs if spec.name not in left_out]
        spec = self._one_of(specs)
        keys = self.window.context.actions.keys(spec.name)
        how = self._one_of(["trigger", "trigger", "key", "menu"] if keys else ["trigger"])
        self._say(f"action {spec.name} by {how}")
        if how == "trigger":
            self.window.action(spec.name).trigger()
        elif how == "key":
            focus = QApplication.focusWidget() or self.window.map_view
            QTest.keySequence(focus, QKeySequence(self._one_of(keys)))
        else:
            self._open_menu()

    def _open_menu(self) -> None:
        bar = self.window.menuBar()
        entry = self._one_of(bar.actions())
        self._say(f"menu {entry.text()}")
        _click(bar, bar.actionGeometry(entry).center())

    def _choose_in(self, popup: QWidget) -> None:
        """Take an entry of a menu or of a combo box's list, or leave it."""
        view = popup if isinstance(popup, QMenu) else popup.findChild(QAbstractItemView) or popup
        if isinstance(view, QMenu):
            entries = [one for one in view.actions() if self._may_choose(one)]
            if entries and self._chance(0.7):
                entry = self._one_of(entries)
                self._say(f"entry {entry.text()}")
                if entry.menu() is None:
                    view.close()
                    if bar_menu := QApplication.activePopupWidget():
                        bar_menu.close()
                    entry.trigger()
                else:
                    view.setActiveAction(entry)
                    QTest.keyClick(view, KEY.Key_Right)
                return
        elif self._chance(0.7):
            self._say(f"list entry of {_name(popup)}")
            for _ in range(int(self._rng.integers(6))):
                QTest.keyClick(view, self._one_of([KEY.Key_Up, KEY.Key_Down, KEY.Key_Home, KEY.Key_End]))
            QTest.keyClick(view, KEY.Key_Return)
            return
        self._say(f"Escape from {_name(popup)}")
        QTest.keyClick(view, KEY.Key_Escape)
        if shiboken6.isValid(popup) and popup.isVisible():
            popup.close()

    def _may_choose(self, entry: QAction) -> bool:
        if entry.isSeparator() or not entry.isEnabled():
            return False
        name = entry.objectName()
        if name.removeprefix("action-") in LEAVES:
            return False
        if name.startswith(("scene-", "robot-")) or _is_file(entry.text()):
            return False  # opened by other acts, with few taxels
        return self._scenes is not None or name.removeprefix("action-") not in DEAR_ACTIONS

    def _answer_popup(self) -> None:
        """A menu that a button shows runs its own loop until something is chosen: from within that loop."""
        popup = QApplication.activePopupWidget()
        if self._acting and popup is not None:
            self._choose_in(popup)

    def _answer(self, modal: QWidget) -> None:
        if isinstance(modal, QMessageBox):
            button = self._one_of(modal.buttons())
            self._say(f"closes {modal.objectName()} with {button.text()}")
            _click(button)
        elif isinstance(modal, CommandPalette):
            self._finds(modal)
        elif isinstance(modal, QInputDialog) and self._chance(0.6):
            self._say(f"closes {modal.objectName()}")
            if (field := modal.findChild(QLineEdit)) is not None and field.isVisible():
                QTest.keyClicks(field, self._one_of(["left", "1", "  ", "<b>&", "x" * 80]))
            QTest.keyClick(modal, KEY.Key_Return)
        elif self._chance(0.5) and (inside := [one for one in self._operated(modal) if _can_be_used(one)]):
            self._uses(self._one_of(inside))
        else:
            self._say(f"Escape from {_name(modal)}")
            QTest.keyClick(modal, KEY.Key_Escape)

    def _finds(self, palette: CommandPalette) -> None:
        """Types a few letters of the command palette, and takes what is found first, or gives up."""
        letters = self._one_of(["layout", "fold", "pla", "mark", "ctrl", "sett", "zz", ""])
        QTest.keyClicks(palette.field, letters)
        for _ in range(int(self._rng.integers(4))):
            QTest.keyClick(palette.field, self._one_of([KEY.Key_Down, KEY.Key_Up, KEY.Key_PageDown]))
        found = palette.found[max(palette.list.currentRow(), 0)].text if palette.found else "nothing"
        harmless = found.startswith(("View", "Select", "Edit", "Session > P", "Setting", "Help"))
        take = harmless and self._chance(0.7)
        self._say(f"palette: {letters!r} finds {found}, {'taken' if take else 'Escape'}")
        QTest.keyClick(palette.field, KEY.Key_Return if take else KEY.Key_Escape)

    # Panels, bars and dialogs.

    def _operates(self) -> None:
        if (board := self.window.presenters.comparison.board) is not None:
            board.stimulus.seconds.setMaximum(0.5)  # simulated: Return runs a comparison
        self._uses(self._one_of([one for one in self._operated() if _can_be_used(one)]))

    def _uses(self, widget: QWidget) -> None:
        for area in _scroll_areas(widget):
            area.ensureWidgetVisible(widget)
        self._say(f"{_name(widget)}")
        if isinstance(widget, QComboBox):
            self._keys(widget, CONTROL_KEYS[:8]) if self._chance(0.7) else _click(widget)
        elif isinstance(widget, QAbstractButton):
            self._presses(widget)
        elif isinstance(widget, QLineEdit | QAbstractSpinBox):
            self._types(widget)
        elif isinstance(widget, QAbstractItemView):
            self._picks_in(widget)
        elif isinstance(widget, RecordingPlots | StudyPlot):
            self._points_in(
                widget if isinstance(widget, RecordingPlots) else widget.findChild(QGraphicsView).viewport()
            )
        elif self._chance(0.5):
            self._keys(widget, CONTROL_KEYS)
        else:
            self._drags_on(widget, self._anywhere(widget), self._anywhere(widget), LEFT, MODIFIERS[0])

    def _points_in(self, plot: QWidget) -> None:
        """Zooms, clicks or drags."""
        how = self._one_of([self._wheel, lambda plot, at, _: _click(plot, at), self._drags_away])
        how(plot, self._anywhere(plot), MODIFIERS[0])

    def _drags_away(self, plot: QWidget, at: QPoint, modifier) -> None:
        self._drags_on(plot, at, self._anywhere(plot), LEFT, modifier)

    def _operated(self, within: QWidget | None = None) -> list[QWidget]:
        found = [
            child
            for top in (QApplication.topLevelWidgets() if within is None else [within])
            if top.isVisible()
            for kind in OPERATED
            for child in top.findChildren(kind)
        ]
        found = [child for child in found if not isinstance(child, QHeaderView)]
        if self._scenes is None:
            found = [child for child in found if child.objectName() not in DEAR_BUTTONS]
        return found

    def _presses(self, button: QAbstractButton) -> None:
        if self._chance(0.8):
            _click(button, modifier=self._one_of(MODIFIERS))
        else:
            button.setFocus()
            QTest.keyClick(button, KEY.Key_Space)

    def _keys(self, widget: QWidget, keys) -> None:
        widget.setFocus()
        for _ in range(int(self._rng.integers(1, 5))):
            if shiboken6.isValid(widget) and widget.isVisible():
                QTest.keyClick(widget, self._one_of(keys))

    def _types(self, field: QWidget) -> None:
        field.setFocus()
        if self._chance(0.5):
            QTest.keyClick(field, KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
        QTest.keyClicks(field, self._one_of(["0", "-1", "2.5", "1e9", "hand", "  ", "<b>&", "x" * 80, ""]))
        if self._chance(0.7) and shiboken6.isValid(field):
            QTest.keyClick(field, self._one_of([KEY.Key_Return, KEY.Key_Escape, KEY.Key_Tab, KEY.Key_Up]))

    def _picks_in(self, view: QAbstractItemView) -> None:
        model = view.model()
        if model is None or not model.rowCount(QModelIndex()):
            return
        columns = view.horizontalHeader().count() if isinstance(view, QTableView) else 1
        index = model.index(int(self._rng.integers(model.rowCount(QModelIndex()))), int(self._rng.integers(columns)))
        view.scrollTo(index, QAbstractItemView.ScrollHint.EnsureVisible)
        at = view.visualRect(index).center()
        twice = self._chance(0.2)
        modifier = self._one_of(MODIFIERS)
        _click(view.viewport(), at, modifier=modifier, twice=twice)
        if self._chance(0.3) and shiboken6.isValid(view):
            self._keys(view, CONTROL_KEYS)

    # Views.

    def _on_map(self) -> None:
        view = self.window.map_view
        self._on_view("map", view, view.viewport(), view)

    def _on_body(self) -> None:
        view = self.window.robot_view
        self._on_view("body", view, view.display.canvas.widget, view)

    def _on_view(self, name: str, view, target: QWidget, keyed: QWidget) -> None:
        if self._chance(0.4):
            self.window.action(self._one_of(TOOLS).kind.name).trigger()
        tool = self.window.views.tool.name
        start = self._place(view, target)
        end = self._place(view, target)
        button = self._one_of(BUTTONS)
        modifier = self._one_of(MODIFIERS)
        how = self._one_of(["drag", "drag", "drag", "click", "double", "wheel", "hover", "keys"])
        self._say(f"{how} on {name} with {tool}, {button.name} {modifier.name}, {_at(start)} to {_at(end)}")
        if how == "drag":
            self._drags_on(target, start, end, button, modifier)
        elif how == "click":
            _click(target, start, button, modifier)
        elif how == "double":
            _click(target, start, button, modifier, twice=True)
        elif how == "wheel":
            self._wheel(target, start, modifier)
        elif how == "hover":
            _move(target, start)
            _move(target, end)
        else:
            keyed.setFocus()
            _move(target, start)
            for _ in range(int(self._rng.integers(1, 4))):
                QTest.keyClick(keyed, self._one_of(VIEW_KEYS), modifier)

    def _drags_on(self, target: QWidget, start: QPoint, end: QPoint, button, modifier) -> None:
        """Press, move, maybe hold while time passes, maybe give up by Escape, lift."""
        _mouse(target, QEvent.Type.MouseButtonPress, start, button, modifier)
        for share in (0.3, 0.7, 1.0):
            if shiboken6.isValid(target):
                _move(target, start + (end - start) * share, button, modifier)
        if self._chance(0.4):
            self._pass_time(0.06)
        if self._chance(0.15) and shiboken6.isValid(target):
            QTest.keyClick(target, KEY.Key_Escape)
        if shiboken6.isValid(target):
            _mouse(target, QEvent.Type.MouseButtonRelease, end, button, modifier)

    def _wheel(self, target: QWidget, at: QPoint, modifier) -> None:
        turn_wheel(target, at, int(self._rng.choice([-3, -1, 1, 3])), modifier)

    def _gesture_cut_short(self) -> None:
        """An action is triggered while a button is held on a view."""
        view = self._one_of([self.window.map_view, self.window.robot_view])
        target = view.viewport() if view is self.window.map_view else view.display.canvas.widget
        self.window.action(self._one_of(TOOLS).kind.name).trigger()
        tool = self.window.views.tool.name
        start = self._place(view, target)
        end = self._place(view, target)
        _mouse(target, QEvent.Type.MouseButtonPress, start)
        _move(target, (start + end) / 2, LEFT)
        self._pass_time(0.04)
        other = self._one_of([self._asks_an_action, self._operates, self._records, self._drops_a_file])
        other()
        self._say(f"{self.last[-1].split(': ', 1)[1]}, while {tool} is held on the {_name(view)}")
        self._pass_time(0.02)
        _move(target, end, LEFT)
        _mouse(target, QEvent.Type.MouseButtonRelease, end)

    def _right_clicks(self) -> None:
        """Right-click on a view; the next act chooses from the menu."""
        view, target = self._view()
        at = self._place(view, target)
        self._say(f"right-click on the {_name(view)} at {_at(at)}")
        _click(target, at, Qt.MouseButton.RightButton)

    def _latches(self) -> None:
        """Leaves a finger on the skin."""
        view, target = self._view()
        self.window.action("poke").trigger()
        at = self._place(view, target)
        self._say(f"Shift-click on the {_name(view)} at {_at(at)}")
        _click(target, at, modifier=Qt.KeyboardModifier.ShiftModifier)

    def _view(self) -> tuple[QWidget, QWidget]:
        view = self._one_of([self.window.map_view, self.window.robot_view])
        return view, view.viewport() if view is self.window.map_view else view.display.canvas.widget

    def _undocks(self) -> None:
        """Gives a panel a window of its own, or puts it back, or folds it there."""
        panel = self._one_of(list(self.window.column))
        self._say(f"undocks {panel.objectName()}, or puts it back")
        self.window.panel_docks.toggle(panel)

    def _arranges(self) -> None:
        """Saves a layout, or takes one that was saved."""
        layouts = self.window.settings.layouts
        docks = self.window.panel_docks
        if layouts and self._chance(0.6):
            name = self._one_of(sorted(layouts))
            self._say(f"takes the layout {name}")
            docks.arrange(layouts[name])
        else:
            name = self._one_of(["left", "right"])
            self._say(f"saves the layout {name}")
            self.window.settings.save_layout(name, docks.layout)

    def _changes_a_key(self) -> None:
        """Change a key on the sheet of keys: press another key for an action, then swap, keep or cancel."""
        self.window.action("keys").trigger()
        sheet = self.window.findChild(KeysSheet)
        spec = self._one_of(list(specs_in(self.window.context.actions.menus)))
        key = self._one_of(CHANGED_KEYS)
        modifier = self._one_of(MODIFIERS)
        self._say(f"gives {spec.name} the key {modifier.name} {key.name}")
        sheet.choose(spec.name)
        editor = sheet.editor
        _click(editor.change)
        QTest.keyClick(editor.field, key, modifier)
        button = self._one_of([editor.swap, editor.keep, editor.reset, editor.remove, editor.reset_all])
        if button.isVisible() and button.isEnabled():
            _click(button)
        if self._chance(0.8):
            sheet.close()

    def _replays(self) -> None:
        """Shows what was recorded last, or takes over from it, or goes back to the session."""
        live = self.window.live
        files = sorted(self.folder.rglob("recordings/*.mcap"))
        if live.mode is Mode.REPLAYING:
            others = ["mark", "range_start", "range_end", "split_episodes"]
            name = "take_over" if self._chance(self._take_overs) else self._one_of(others)
            self._say(f"{name} in a replay")
            self.window.action(name).trigger()
        elif files:
            self._say(f"replays {files[-1].name}")
            live.open_recording(files[-1])

    def _works(self) -> None:
        """Edits the map, sets a path or target, chooses a controller, undoes, resets or saves."""
        document = self.window.editor.document
        number = int(self._rng.integers(len(document.patches)))
        what = self._one_of(["rotate", "path", "controller", "undo", "reset", "save", "save_scene"])
        self._say(f"works: {what}")
        if what == "rotate":
            angle = float(self._rng.uniform(0.1, 1.0))
            self.window.editor.do("Rotate", lambda document: rotate(document, [number], angle))
        elif what == "path":
            points = document.map.taxel_points[self._rng.integers(len(document.skin), size=3)]
            path = tuple((float(x), float(y)) for x, y in points)
            self.window.presenters.tools.control.do("draw", path=path, task="follow_path", controller="hybrid")
        elif what == "controller":
            self.window.action(f"controller_{self._one_of(['impedance', 'hold_force', 'parallel'])}").trigger()
        else:
            self.window.action(what).trigger()

    def _connects(self) -> None:
        """Shows readings from a file instead of the simulation, or disconnects."""
        live = self.window.live
        if live.live_input is not None:
            self._say("disconnects")
            self.window.action("disconnect").trigger()
        elif live.mode is Mode.REPLAYING:
            self._say("connects from a recording")
            self.window.action("connect").trigger()
        else:
            self._say("connects")
            path = self.folder / "readings.csv"
            path.write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
            live.connection.open(LiveInputSettings(str(path)))

    def _changes_the_skin(self) -> None:
        """Covers the robot with fewer taxels, as one step, or chooses in the Skin panel what may not be applied."""
        live = self.window.live
        self._say("changes the skin")
        if live.mode.takes_input and live.live_input is None and not live.prepared.scene.taxel_files:
            scene = live.prepared.scene
            cover = replace(scene.cover, taxels=int(self._rng.integers(30, 60)))
            if self._chance(self._choices):
                self._chooses_a_skin(cover.taxels)
                return
            self.window.presenters.tools.skin_steps.push("Cover", scene, replace(scene, cover=cover))

    def _chooses_a_skin(self, taxels: int) -> None:
        """Check a link or type a number of taxels in the Skin panel, or apply or revert what was chosen there."""
        self.window.action("choose_skin").trigger()
        panel = self.window.column.get(SkinPanel)
        what = self._one_of(["link", "taxels", "taxels", "apply", "revert"])
        self._say(f"chooses a skin: {what}")
        if what == "link" and panel.tree.isEnabled():
            panel.tree.setFocus()
            panel.tree.setCurrentItem(self._one_of(list(panel.tree.rows.values())))
            QTest.keyClick(panel.tree, KEY.Key_Space)
        elif what == "taxels" and _can_be_used(panel.taxels):
            panel.taxels.setFocus()
            QTest.keyClick(panel.taxels, KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
            QTest.keyClicks(panel.taxels, str(taxels))
            QTest.keyClick(panel.taxels, KEY.Key_Return)
        elif what in ("apply", "revert"):
            _click(getattr(panel, what))

    def _place(self, view, target: QWidget) -> QPoint:
        pixels = view.taxel_pixels()
        pixels = pixels[np.isfinite(pixels).all(axis=1)] if len(pixels) else pixels
        if len(pixels) and self._chance(0.75):
            inside = QPoint(*np.round(self._one_of(pixels) + self._rng.normal(0, 4, 2)).astype(int).tolist())
            if target.rect().contains(inside):
                return inside
        return self._anywhere(target)

    def _anywhere(self, widget: QWidget) -> QPoint:
        return QPoint(int(self._rng.integers(max(widget.width(), 1))), int(self._rng.integers(max(widget.height(), 1))))

    # Time, files, the window.

    def _waits(self) -> None:
        seconds = float(self._one_of([0.05, 0.1, 0.2]))
        self._say(f"waits {seconds} s")
        self._pass_time(seconds)

    def _records(self) -> None:
        self._say("records, or stops")
        self.window.action("record").trigger()

    def _resizes(self) -> None:
        width = int(self._rng.integers(700, 1700))
        height = int(self._rng.integers(450, 1000))
        self._say(f"resizes to {width} x {height}")
        self.window.resize(width, height)

    def _opens(self) -> None:
        self._say("opens a scene")
        self._say(f"opens {self._scenes(int(self._rng.integers(1 << 30)))}")

    def _drops_a_file(self) -> None:
        path = self._file_to_open("")
        self._say(f"drops {Path(path).name or 'nothing'}")
        mime = QMimeData()
        mime.setUrls([QUrl.fromLocalFile(path)] if path else [])
        event = QDropEvent(QPointF(200, 200), Qt.DropAction.CopyAction, mime, LEFT, Qt.KeyboardModifier.NoModifier)
        QApplication.sendEvent(self.window, event)

    def _file_to_open(self, kinds: str) -> str:
        """Return a saved or recorded file of the requested kind or another, a broken file, or a missing one."""
        if self._chance(0.15):
            return ""
        files = [path for path in sorted(self.folder.rglob("*")) if path.suffix in (".mcap", ".npz", ".toml", ".csv")]
        if self._scenes is None:  # of a robot's file too, the robot is prepared
            files = [path for path in files if path.suffix != ".toml" or path.name.startswith("broken")]
        asked = [path for path in files if f"*{path.suffix}" in kinds and not path.name.startswith("broken")]
        return str(self._one_of(asked if asked and self._chance(0.7) else [*files, self.folder / "gone.mcap"]))

    def _file_to_save(self, name: str) -> str:
        if self._chance(0.2):
            return ""
        if self._chance(0.2):
            return str(self.folder / "no such folder" / name)
        stem = f"{Path(name).stem}-{int(self._rng.integers(4))}"
        ending = Path(name).suffix or self._one_of([".npz", ".svg", ".png", ".csv", ".obj", ".xyz"])
        return str(self.folder / f"{stem}{ending}")


def _mouse(target: QWidget, kind: QEvent.Type, at: QPoint, button=LEFT, modifier=MODIFIERS[0]) -> None:
    """Send a mouse event without ``QTest``, where an exception in a handler ends the process (PySide6 6.11)."""
    if not shiboken6.isValid(target):
        return
    none = Qt.MouseButton.NoButton
    changed = none if kind == QEvent.Type.MouseMove else button
    held = none if kind == QEvent.Type.MouseButtonRelease else button
    there = QPointF(target.mapToGlobal(at))
    QApplication.sendEvent(target, QMouseEvent(kind, QPointF(at), there, changed, held, modifier))


def _move(target: QWidget, at: QPoint, button=Qt.MouseButton.NoButton, modifier=MODIFIERS[0]) -> None:
    _mouse(target, QEvent.Type.MouseMove, at, button, modifier)


def _click(target: QWidget, at: QPoint | None = None, button=LEFT, modifier=MODIFIERS[0], *, twice=False) -> None:
    """Press and lift, as one act of the hand; a right click asks for a menu too, as the desktop has it."""
    at = target.rect().center() if at is None else at
    kinds = [QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonRelease]
    if twice:
        kinds += [QEvent.Type.MouseButtonDblClick, QEvent.Type.MouseButtonRelease]
    for kind in kinds:
        _mouse(target, kind, at, button, modifier)
    if button == Qt.MouseButton.RightButton and shiboken6.isValid(target):
        reason = QContextMenuEvent.Reason.Mouse
        QApplication.sendEvent(target, QContextMenuEvent(reason, at, target.mapToGlobal(at), modifier))


def _away(path: Path) -> recordings_presenter.TrashedFile:
    """Delete a file instead of moving it to the trash of the user."""
    path.unlink(missing_ok=True)
    return recordings_presenter.TrashedFile(path, None)


def _can_be_used(widget: QWidget) -> bool:
    return widget.isVisible() and widget.isEnabled()


def _scroll_areas(widget: QWidget) -> list[QScrollArea]:
    above = widget.parentWidget()
    found = []
    while above is not None:
        if isinstance(above, QScrollArea):
            found.append(above)
        above = above.parentWidget()
    return found


def _name(widget: QWidget) -> str:
    name = widget.objectName() or widget.accessibleName()
    text = widget.text() if isinstance(widget, QAbstractButton) else ""
    return f"{type(widget).__name__} {name} {text}".strip()


def _at(place: QPoint) -> str:
    return f"({place.x()}, {place.y()})"


def _is_file(text: str) -> bool:
    return "/" in text
