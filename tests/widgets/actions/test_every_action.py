"""Every action of the table, triggered once in a window, has an effect.

``EFFECTS`` gives for each action the state in which it is triggered and what it must change. A new action of the table
without a line here fails the test. A single window runs through all of them in the order of the lines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, get_args

import pytest
from PySide6.QtCore import QEvent
from PySide6.QtGui import QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QApplication, QMenu

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_maps.editing.arrange import EDGES, move, scale
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import DocumentFile
from tactile_maps.editing.reflatten import set_method
from tactile_maps.maps.paths import PathKind
from tactile_maps.scene.scene import with_override
from tactile_maps.scene.scene_file import scene_to_toml
from tactile_widgets.actions.registry import specs_in
from tactile_widgets.actions.table import REMEDIES, menu_bar
from tactile_widgets.common.controller_settings import SETTING_CHOICES
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tactile_widgets.tools.registry import TOOLS
from tactile_widgets.views.layers import LAYERS
from tests.widgets.support.mouse import left_release
from tests.widgets.support.window_driver import blow_up, press_map, replay_run, run

TICK = 0.005
"""Control period of the session [s]."""


class Bench:
    """A window, what files it is given, and what it asked."""

    def __init__(self, window, prepared, folder, patching) -> None:
        self.window = window
        self.prepared = prepared
        self.folder = folder
        self.patching = patching
        self.asked: list[str] = []
        self.opened: list[str] = []
        self.prepares = 0
        patching.setattr(FileDialog, "open_file", self._answer_none)
        patching.setattr(FileDialog, "open_files", lambda *asked: [*self._answer_none(*asked)])
        patching.setattr(FileDialog, "choose_folder", self._answer_none)
        patching.setattr(FileDialog, "save_file", self._answer_save)
        patching.setattr(QDesktopServices, "openUrl", self.opened.append)
        patching.setattr("tactile_widgets.jobs.scene_jobs.prepare_cached", self._prepare)

    def _answer_none(self, _parent, title, *_more):
        self.asked.append(title)
        return ""

    def _answer_save(self, _parent, title, start, *_more):
        self.asked.append(title)
        endings = {"Export map": ".svg", "Save map": ".npz", "Save map as": ".npz"}
        name = f"{title.lower()}{Path(start).suffix or endings.get(title, '.toml')}"
        return str(self.folder / name)

    def _prepare(self, *_args, **_kwargs):
        self.prepares += 1
        return self.prepared

    @property
    def state(self):
        return self.window.presenters.state.state

    @property
    def files(self):
        return sorted(path.name for path in self.folder.rglob("*") if path.is_file())

    @property
    def windows(self):
        """The dialogs and windows that are open."""
        return sorted(type(top).__name__ for top in QApplication.topLevelWidgets() if top.isVisible())

    @property
    def document(self):
        return self.window.editor.document

    @property
    def settings(self):
        """Settings of the controller."""
        return self.window.live.runner.session.settings

    def ask(self, *names: str) -> None:
        """Ask for actions, as a menu would."""
        for name in names:
            action = self.window.action(name)
            assert action.isEnabled(), name
            action.trigger()
            run(self.window, TICK)

    def tidy(self) -> None:
        """Close what an action opened, and have the views again."""
        for top in QApplication.topLevelWidgets():
            if top.isVisible() and top is not self.window and not isinstance(top, QMenu):
                top.close()
        self.window.context.notifier.withdraw()
        self.window.notification_bar.clear()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)

    # States in which actions can be triggered.

    def live(self) -> None:
        """A session runs."""
        live = self.window.live
        if live.recording.recorder is not None:
            live.recording.stop()
        if live.mode is Mode.REPLAYING:
            live.replay.leave()
        live.set_paused(paused=False)

    def paused(self) -> None:
        self.live()
        self.window.live.set_paused(paused=True)

    def recorded(self) -> None:
        """A recording is shown, from within."""
        if self.window.live.mode is not Mode.REPLAYING:
            self.live()
            path = self.folder / f"recording-{len(self.files)}.mcap"
            replay_run(self.window, path, 0.1)
        self.window.timeline.go_to(0.05)

    def marked(self) -> None:
        """It has marks at its moment and on either side."""
        self.recorded()
        for time in (0.02, 0.08, 0.05):
            self.window.timeline.go_to(time)
            self.window.presenters.notes.mark()

    def ranged(self) -> None:
        self.recorded()
        self.window.timeline.set_range(Span(0.02, 0.08))

    def in_episode(self) -> None:
        self.marked()
        self.ask("split_episodes")

    def overlaid(self) -> None:
        """Show a recording with an overlay of itself at a later time."""
        self.recorded()
        overlay = self.window.presenters.overlay
        overlay.open(self.window.live.replay.player.path)
        overlay.set_offset(0.02)

    def touched(self) -> None:
        """A recording of a press is shown."""
        held(self)
        self.recorded()

    def patches(self) -> None:
        """The patches are selected, and each has a size and a place of its own."""
        self.live()
        self.ask("arrange")
        numbers = range(len(self.window.editor.document.patches))

        def spread(document):
            for number in numbers:
                document = move(document, [number], (0.01 * number, 0.02 * number))
                document = scale(document, [number], 1.1 + 0.1 * number)
            return document

        self.window.editor.do("Spread", spread)
        self.window.editor.select(numbers)

    def taxel(self) -> None:
        self.live()
        self.ask("poke")
        self.window.views.select_taxel(3)

    def pinned(self) -> None:
        """A pin is there, and chosen."""
        self.taxel()
        self.ask("add_pin", "pins", "select_pins")

    def unchosen(self) -> None:
        """A pin is there, and not chosen."""
        self.pinned()
        self.window.presenters.tools.get(PinTool)._choose(())

    def tasked(self) -> None:
        """Choose a controller with tasks."""
        self.live()
        self.ask("controller_hybrid")


class Effect(NamedTuple):
    """Required effect of an action.

    Attributes:
        state: Brings the window into a state in which the action is enabled.
        of: Returns the value that the action must change.
    """

    state: Callable[[Bench], object]
    of: Callable[[Bench], object]


def asked(bench):
    return len(bench.asked)


def windows(bench):
    return bench.windows


def document(bench):
    return id(bench.document)


def files(bench):
    return bench.files


def status(bench):
    return bench.window.status_line.currentMessage()


def selected(bench):
    return bench.window.views.selection.taxels.tolist()


def overlays(bench):
    return bench.window.views.overlays


def of_state(name):
    return lambda bench: getattr(bench.state, name)


def mode(bench):
    return bench.window.live.mode


def opening(bench):
    """Return the scenes in preparation, and the question about unsaved edits."""
    return bench.prepares, bench.windows


def notes(bench):
    return bench.window.context.notes.value


def offset(bench):
    return bench.window.presenters.overlay.offset


def position(bench):
    return bench.window.timeline.playhead.time


def after(*names):
    """Return the state after these actions in a running session."""

    def reach(bench):
        bench.live()
        bench.ask(*names)

    return reach


def undone(bench):
    bench.patches()
    bench.ask("undo")


def aimed(bench):
    """A target was set with the mouse."""
    bench.tasked()
    bench.ask("set_target")
    view = bench.window.map_view
    pixel = press_map(bench.window, 5)
    left_release(view.viewport(), pixel)
    run(bench.window, TICK)


def measuring(bench):
    bench.live()
    bench.window.live.connection.open(LiveInputSettings("udp://127.0.0.1:0"))


def crashed(bench):
    """Edits of this robot's map were left by a window that ended without closing."""
    bench.patches()
    files = bench.window.presenters.map_files
    files.autosave()
    files._wait()
    prepared = bench.prepared
    skin = replace(prepared.map.skin)
    bench.window.live.show_prepared(replace(prepared, map=replace(prepared.map, skin=skin)))


def crashed_elsewhere(bench):
    """Edits of another document were left."""
    folder = bench.folder / "state" / "autosave" / "other" / "1"
    folder.mkdir(parents=True)
    origin = {"name": "Other", "opened": scene_to_toml(bench.prepared.scene)}
    DocumentFile(None, None, folder=folder).autosave(MapDocument.of(bench.prepared.map), origin=origin)
    bench.window.presenters.unsaved.search()


def failed(bench):
    bench.live()
    blow_up(bench.window.live)


def unsteady(bench):
    """Request an effect that leads to a warning."""
    bench.live()
    effects = bench.window.presenters.effects
    effects._unconfirmed = with_override(effects.scene, "gravity", "off")


def without_fingers(bench):
    bench.live()
    bench.window.presenters.effects.choose("fingers", "off")
    run(bench.window, TICK)


def scene(bench):
    return bench.window.presenters.effects.scene


def editing(bench):
    """Start an edit in the background that never finishes."""
    bench.patches()
    bench.patching.setattr(bench.window.editor._jobs, "reflatten", lambda *_args: None)
    bench.window.editor.ask(partial(set_method, numbers=[0], method="tutte"))


def restartable(bench):
    bench.tasked()
    bench.ask("task_keep_force", "task_hold_point")


def turned(bench):
    """A gain is another one than the scene's."""
    bench.tasked()
    panel = bench.window.column["controller"]
    panel.take(replace(bench.settings, stiffness=2 * bench.settings.stiffness))
    run(bench.window, TICK)


def hidden_link(bench):
    bench.live()
    bench.window.robot_view.hide_bodies(frozenset({0}))


def zoomed(bench):
    bench.live()
    view = bench.window.map_view
    view.zoom(2.0, view.viewport().rect().center().toPointF())


def chosen_plots(bench):
    bench.live()
    bench.window.plots.keep_standard()


def first_tab(bench):
    bench.live()
    bench.window.column.show_tab(PanelTab.TOUCH)


def folded(bench):
    """Every panel shows its heading alone."""
    bench.live()
    bench.window.column.set_folded(tuple(panel.objectName() for panel in bench.window.column))


def held(bench):
    """A finger was pressed: there is something to save."""
    bench.live()
    bench.ask("poke")
    view = bench.window.map_view
    pixel = press_map(bench.window, 5)
    run(bench.window, 0.1)
    left_release(view.viewport(), pixel)
    run(bench.window, 0.05)


def _family(prefix, names, field, *first):
    """Exclusive actions: each is triggered while another one is checked."""
    names = list(names)
    return {
        f"{prefix}_{name}": Effect(after(*first, f"{prefix}_{names[number - 1]}"), of_state(field))
        for number, name in enumerate(names)
    }


LIVE = Bench.live
PAUSED = Bench.paused
RECORDED = Bench.recorded


def led(bench):
    """Set a target posture that differs from the scene's."""
    LIVE(bench)
    editor = bench.window.presenters.posture.editor
    editor.do("lead", editor.target + 0.05)


def copied_posture(bench):
    """The first joint's position is in the clipboard."""
    LIVE(bench)
    joint = bench.window.live.prepared.robot.joints[0]
    QGuiApplication.clipboard().setText(f"{joint.name} = 0.125")


def deleted(bench):
    """The recording that was shown is in the trash."""
    RECORDED(bench)
    path = bench.window.live.replay.player.path
    bench.window.presenters.recordings._on_delete_answered(path, Button.Yes)


def refused_posture(bench):
    """The robot was to be placed while a finger presses it."""
    LIVE(bench)
    bench.window.live.reset()
    bench.window.presenters.touch.hold(bench.window.live.prepared.skin.taxel_point(3))
    run(bench.window, 10 * TICK)
    bench.window.live.set_paused(paused=True)
    led_editor = bench.window.presenters.posture.editor
    led_editor.do("lead", led_editor.target + 0.05)


def target_posture(bench):
    return bench.window.presenters.posture.editor.target.tolist()


def clipboard(_bench):
    return QGuiApplication.clipboard().text()


EFFECTS: dict[str, Effect] = {
    # File.
    **dict.fromkeys(
        ("open_robot", "package_root", "open_scene", "import_taxels", "open_recording", "open_study", "open_map"),
        Effect(LIVE, asked),
    ),
    "connect": Effect(LIVE, windows),
    "disconnect": Effect(measuring, of_state("measured")),
    **dict.fromkeys(("save", "export_map", "save_scene", "save_picture"), Effect(LIVE, files)),
    **dict.fromkeys(("save_figure", "preferences"), Effect(LIVE, windows)),
    "film": Effect(LIVE, of_state("recording")),
    "film_file": Effect(LIVE, asked),
    "save_map_as": Effect(LIVE, asked),
    "restore_map": Effect(crashed, document),
    "discard_restore": Effect(crashed, windows),
    "open_unsaved": Effect(crashed_elsewhere, opening),
    "share_live": Effect(LIVE, of_state("shared_with")),
    "share_rerun": Effect(LIVE, lambda bench: bench.window.notification_bar.text),
    "copy_command": Effect(LIVE, clipboard),
    # Edit.
    **dict.fromkeys(("choose_skin", "choose_links"), Effect(first_tab, lambda bench: bench.window.column.tab)),
    "undo": Effect(Bench.patches, document),
    "redo": Effect(undone, document),
    **{spec.kind.name: Effect(after("select_box"), of_state("tool")) for spec in TOOLS},
    "select_box": Effect(after("poke"), of_state("tool")),
    "add_pin": Effect(Bench.taxel, document),
    "remove_pin": Effect(Bench.pinned, document),
    "select_pins": Effect(Bench.unchosen, lambda bench: bench.window.presenters.tools.get(PinTool).chosen),
    "mirror": Effect(Bench.patches, document),
    **{f"align_{edge}": Effect(Bench.patches, document) for edge in EDGES},
    "true_size": Effect(Bench.patches, document),
    "repack": Effect(Bench.patches, document),
    "hide_patches": Effect(Bench.patches, document),
    "show_patches": Effect(LIVE, document),
    "propose_seam": Effect(LIVE, of_state("tool")),
    "cancel_edit": Effect(editing, of_state("edit_busy")),
    # Session.
    "pause": Effect(LIVE, mode),
    "step": Effect(PAUSED, lambda bench: bench.window.live.runner.session.frame.tick),
    "reset": Effect(LIVE, lambda bench: bench.window.live.runner.session.frame.tick),
    "record": Effect(LIVE, of_state("recording")),
    "record_for_viewers": Effect(LIVE, of_state("recorded_for_viewers")),
    # Recording.
    "mark": Effect(RECORDED, notes),
    "name_mark": Effect(RECORDED, windows),
    "delete_mark": Effect(Bench.marked, notes),
    "previous_mark": Effect(Bench.marked, position),
    "next_mark": Effect(Bench.marked, position),
    "range_start": Effect(RECORDED, lambda bench: bench.window.timeline.range),
    "range_end": Effect(RECORDED, lambda bench: bench.window.timeline.range),
    "clear_range": Effect(Bench.ranged, of_state("has_range")),
    "loop": Effect(Bench.ranged, of_state("looping")),
    "whole_recording": Effect(RECORDED, lambda bench: bench.window.context.settings.whole_recording),
    "label_episode": Effect(Bench.ranged, windows),
    "split_episodes": Effect(Bench.marked, notes),
    "delete_episode": Effect(Bench.in_episode, notes),
    "trim_range": Effect(Bench.ranged, asked),
    "save_episodes": Effect(Bench.in_episode, asked),
    "export_recording": Effect(RECORDED, windows),
    "recordings": Effect(RECORDED, windows),
    "delete_recording": Effect(RECORDED, windows),
    "overlay_recording": Effect(RECORDED, asked),
    "overlay_align": Effect(Bench.overlaid, status),
    "overlay_earlier": Effect(Bench.overlaid, offset),
    "overlay_later": Effect(Bench.overlaid, offset),
    "overlay_offset": Effect(Bench.overlaid, windows),
    "overlay_remove": Effect(Bench.overlaid, of_state("overlaid")),
    "back_to_live": Effect(RECORDED, mode),
    "repeat_touches": Effect(Bench.touched, mode),
    "take_over": Effect(RECORDED, windows),
    "show_saved": Effect(LIVE, lambda bench: len(bench.opened)),
    "replay_saved": Effect(LIVE, mode),
    # Touch.
    "save_script": Effect(held, files),
    "play_script": Effect(LIVE, asked),
    "script_once": Effect(LIVE, of_state("script_repeats")),
    "script_repeated": Effect(after("script_once"), of_state("script_repeats")),
    "weigh": Effect(LIVE, lambda bench: bench.window.notification_bar.text),
    # Control.
    **_family("controller", CONTROLLERS, "controller"),
    **_family("task", SETTING_CHOICES["task"][1], "task", "controller_hybrid"),
    **_family("path", get_args(PathKind), "path_kind", "controller_hybrid"),
    "more_force": Effect(Bench.tasked, lambda bench: bench.settings.force_goal),
    "less_force": Effect(Bench.tasked, lambda bench: bench.settings.force_goal),
    "clear_path": Effect(aimed, of_state("has_path")),
    "start_again": Effect(restartable, lambda bench: len(bench.window.live.runner.session.inputs)),
    "scene_posture": Effect(led, target_posture),
    "undo_posture": Effect(led, target_posture),
    "copy_posture": Effect(LIVE, clipboard),
    "paste_posture": Effect(copied_posture, target_posture),
    "reset_gains": Effect(turned, lambda bench: bench.settings.stiffness),
    "compare_controllers": Effect(LIVE, windows),
    # Select.
    "smaller_brush": Effect(after("larger_brush"), lambda bench: bench.window.views.brush),
    "larger_brush": Effect(after("smaller_brush"), lambda bench: bench.window.views.brush),
    "select_all": Effect(Bench.taxel, selected),
    "select_none": Effect(Bench.taxel, selected),
    "select_inverse": Effect(Bench.taxel, selected),
    "find_taxel": Effect(LIVE, windows),
    # View.
    "frame": Effect(zoomed, lambda bench: bench.window.map_view.camera),
    "show_bodies": Effect(hidden_link, of_state("bodies_hidden")),
    "morph": Effect(LIVE, lambda bench: bench.window.robot_view.morph._ease.endValue()),
    "compare": Effect(LIVE, status),
    **{f"ground_{layer.value}": Effect(after("ground_checker"), overlays) for layer in BaseLayer},
    "ground_checker": Effect(after("ground_pressure"), overlays),
    **{f"mark_{layer.name}": Effect(LIVE, overlays) for layer in LAYERS},
    "second_view": Effect(LIVE, lambda bench: bench.window.more_views.second is None),
    "contact_inset": Effect(LIVE, lambda bench: bench.window.more_views.inset is None),
    "theme": Effect(LIVE, of_state("light")),
    "panels": Effect(LIVE, lambda bench: bench.window.panels.isVisible()),
    "plots": Effect(LIVE, lambda bench: bench.window.bottom.isVisible()),
    "choose_plots": Effect(LIVE, windows),
    "automatic_plots": Effect(chosen_plots, lambda bench: bench.window.plots.choice),
    "export_plots": Effect(LIVE, asked),
    "timing": Effect(folded, lambda bench: bench.window.column.folded),
    "effects": Effect(folded, lambda bench: bench.window.column.folded),
    "save_layout": Effect(LIVE, windows),
    "delete_layout": Effect(LIVE, lambda bench: bench.window.notification_bar.text),
    "reset_layout": Effect(after("panels"), lambda bench: bench.window.panels.isVisible()),
    "full_screen": Effect(LIVE, lambda bench: bench.window.isFullScreen()),
    # Help.
    "tour": Effect(LIVE, lambda bench: bench.window._commands.tour.step),
    "guide": Effect(LIVE, windows),
    "keys": Effect(LIVE, windows),
    "palette": Effect(LIVE, windows),
    "about": Effect(LIVE, windows),
    # Remedies.
    "save_report": Effect(failed, files),
    "open_path_scene": Effect(LIVE, opening),
    "simulate_fingers": Effect(without_fingers, scene),
    "restore_recording": Effect(deleted, files),
    "go_there": Effect(refused_posture, target_posture),
    "use_anyway": Effect(unsteady, scene),
    "tare_again": Effect(measuring, lambda bench: bench.window.live.live_input.session.facts.taring),
    "quit": Effect(LIVE, windows),
}


@pytest.fixture
def bench(new_window, prepared, tmp_path, monkeypatch):
    QGuiApplication.clipboard().clear()  # another test may have copied the same command
    new_window.resize(900, 600)
    new_window.robot_view.hide()  # it is most of what is drawn
    made = Bench(new_window, prepared, tmp_path, monkeypatch)
    yield made
    made.tidy()


def test_effects_list_every_action():
    """Tips, menus and entries of the palette are tested with the table and the palette."""
    assert EFFECTS.keys() == {spec.name for spec in (*specs_in(menu_bar()), *REMEDIES)}


def test_every_action_has_an_effect(bench, qtbot):
    idle = []
    for name, effect in EFFECTS.items():
        if name in bench.window.context.actions.install:
            continue
        effect.state(bench)
        bench.tidy()
        bench.window.presenters.state.update()
        assert bench.window.action(name).isEnabled(), f"{name} is disabled in the state of its line"
        before = effect.of(bench)
        bench.window.action(name).trigger()
        if effect.of(bench) == before:
            run(bench.window, TICK)
        try:  # some work in slices or in a thread, which take as long as the machine lets them
            qtbot.waitUntil(lambda effect=effect, before=before: effect.of(bench) != before, timeout=20_000)
        except qtbot.TimeoutError:
            idle.append(name)
        bench.tidy()
    assert not idle, "these changed nothing of what they are for"
