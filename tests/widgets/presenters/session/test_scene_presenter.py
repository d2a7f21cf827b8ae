"""Another scene reaches what shows it in one order, independent of which part was created first."""

from __future__ import annotations

import pytest
from PySide6.QtTest import QTest

from tactile_maps.editing.seams import propose_seam
from tactile_maps.flattening.methods import METHODS
from tactile_widgets.tools.registry import INTEREST, PINS, SEAMS
from tests.hard_cases.touch import dressed
from tests.support.touch import bar, bar_skin
from tests.widgets.support.window_driver import record_run, run

pytestmark = pytest.mark.long

ORDER = ["effects", "views", "panels", "map"]


@pytest.fixture
def trace(window, monkeypatch):
    """Names of the objects that show a scene, in the order of their calls."""
    names = []

    def listen(name, shows):
        show = shows.show_prepared

        def record(prepared):
            names.append(name)
            show(prepared)

        monkeypatch.setattr(shows, "show_prepared", record)

    presenters = window.presenters
    for name, shows in zip(ORDER, (presenters.effects, window.views, window.column, presenters.map_edit), strict=True):
        listen(name, shows)
    return names


def test_scene_is_shown_in_the_defined_order(window, prepared, trace):
    window.live.show_prepared(prepared)
    assert trace == ORDER


def test_recording_is_shown_in_the_defined_order(window, trace, qtbot, tmp_path):
    record_run(window, tmp_path / "a.mcap", 0.2)
    with qtbot.waitSignal(window.live.replay.player_changed, timeout=60_000):
        window.live.open_recording(tmp_path / "a.mcap")
    assert trace == ORDER
    assert "Try:" not in window.statusBar().currentMessage()
    window.live.replay.leave()
    assert trace == ORDER * 2
    assert "Try: Press the skin" in window.statusBar().currentMessage()
    assert window.map_view.picture.document is window.editor.document, "the map that is edited is back"


@pytest.mark.sampled(1)
@pytest.mark.parametrize("tool", [SEAMS, PINS, INTEREST], ids=lambda tool: tool.name)
def test_marks_of_a_tool_are_removed_with_their_skin(window_again, prepared, tool):
    """The other skin has fewer patches and vertices: no mark of the one before can be drawn on it."""
    window = window_again
    window.presenters.view.set_tool(tool)
    window.editor.ask(lambda document: propose_seam(document, 0))
    viewport = window.map_view.viewport()
    pixel_of = window.map_view.pixel_of
    QTest.mouseMove(viewport, pixel_of(prepared.skin.taxel_point(len(prepared.skin) - 1)).toPoint())
    assert window.robot_view.display._marks.lines
    window.live.show_prepared(dressed(bar(), bar_skin()))
    run(window, 0.05)
    assert window.robot_view.display._marks.skin is window.live.prepared.skin
    window.presenters.view.set_tool(tool)
    QTest.mouseMove(viewport, pixel_of(window.live.prepared.skin.taxel_point(0)).toPoint())
    run(window, 0.05)
    window.live.show_prepared(prepared)


def test_broken_plugins_are_reported_once(window, prepared, monkeypatch, tmp_path):
    info = tmp_path / "other-2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text("[tactile_maps.map_methods]\nflat = module_that_is_not_there:METHOD\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert "flat" not in METHODS
    messages = []
    monkeypatch.setattr(window.context.notifier, "fault", lambda text, **_operation: messages.append(text))
    window.live.show_prepared(prepared)
    window.live.show_prepared(prepared)
    (text,) = messages
    assert text.startswith("Plug-in other 2.0, map_methods, flat: left out: ModuleNotFoundError")
    assert text.endswith("pip uninstall other.")
