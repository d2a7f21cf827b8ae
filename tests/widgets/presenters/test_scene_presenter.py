"""Another scene reaches what shows it in one order, whoever was made first."""

from __future__ import annotations

import pytest

from tests.widgets.support.window_driver import run

ORDER = ["effects", "views", "panels", "map"]


@pytest.fixture
def trace(window, monkeypatch):
    """Who is told of a scene, in order; each still does what it does."""
    told = []

    def listen(name, shows):
        show = shows.show_prepared

        def tell(prepared):
            told.append(name)
            show(prepared)

        monkeypatch.setattr(shows, "show_prepared", tell)

    presenters = window.presenters
    for name, shows in zip(ORDER, (presenters.effects, window.views, window.column, presenters.map_edit), strict=True):
        listen(name, shows)
    return told


def test_a_scene_is_shown_in_one_order(window, prepared, trace):
    window.live.show_prepared(prepared)
    assert trace == ORDER


def test_a_recording_and_the_way_back_are_too(window, trace, qtbot, tmp_path):
    window.live.start_recording(tmp_path / "a.mcap")
    run(window, 0.2)
    window.live.stop_recording()
    with qtbot.waitSignal(window.live.player_changed, timeout=60_000):
        window.live.open_recording(tmp_path / "a.mcap")
    assert trace == ORDER
    window.live.back_to_live()
    assert trace == ORDER * 2
    assert window.map_view.display.picture.document is window.editor.document, "the map that is edited is back"
