"""A second recording over the first: its outline on the map, its dashed curve, aligned by the first touch; repeats."""

from __future__ import annotations

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QInputDialog

from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.mode import Mode
from tactile_widgets.presenters.session.overlay_presenter import first_touch
from tests.support.recordings import record, small_arm
from tests.widgets.support.window_driver import run

ALT_SHIFT = Qt.KeyboardModifier.AltModifier | Qt.KeyboardModifier.ShiftModifier
TAXEL = 20


@pytest.fixture(scope="module")
def two(prepared, tmp_path_factory):
    """The same press at 0.1 s, and at 0.25 s."""
    folder = tmp_path_factory.mktemp("two")
    for name, press in (("first", 20), ("second", 50)):
        session = Session(prepared, scripted=False)
        with Recorder(prepared, folder / f"{name}.mcap", viewers=False) as recorder:
            for tick in range(140):
                if tick == press:
                    session.submit(PokePressed(5, prepared.skin.taxel_point(TAXEL)))
                recorder.write(session.tick(), session.inputs)
    return folder / "first.mcap", folder / "second.mcap"


@pytest.fixture
def window(window_again, two, choose_file):
    """It shows the first, and the second over it."""
    window_again.live.open_recording(two[0])
    choose_file("open_file", two[1])
    window_again.action("overlay_recording").trigger()
    yield window_again
    window_again.live.replay.leave()


def outlined(window):
    return window.map_view.marks.overlaid


@pytest.mark.long
def test_overlay_outlines_contacts_with_a_time_offset(window, prepared):
    window.timeline.go_to(0.3)
    assert window.live.shown.regions
    assert not outlined(window), "the second is not pressed yet"
    QTest.keyClick(window, Qt.Key.Key_Left, ALT_SHIFT)
    QTest.keyClick(window, Qt.Key.Key_Left, ALT_SHIFT)
    assert window.presenters.overlay.offset == pytest.approx(-0.1)
    assert window.recording_plots._other.times()[0] == pytest.approx(-0.1)
    window.action("overlay_align").trigger()
    assert window.presenters.overlay.offset == pytest.approx(-0.15, abs=0.01)
    ((centre, axes),) = outlined(window)
    touched = window.map_view.picture.mark_of(prepared.skin.taxel_point(TAXEL))
    scale = window.map_view.picture.shapes.frame.scale
    assert (centre - touched).manhattanLength() < 0.02 * scale
    assert axes.shape == (2, 2)
    own = window.recording_plots
    other = window.recording_plots._other
    assert first_touch(own.times, own.values) == pytest.approx(
        first_touch(other.times(), other.curves.values), abs=0.006
    )
    window.action("overlay_offset").trigger()
    box = window.findChild(QInputDialog)
    box.setTextValue("0,5")
    box.accept()
    assert window.presenters.overlay.offset == 0.5
    window.action("overlay_remove").trigger()
    assert not outlined(window)
    assert window.recording_plots._other is None
    assert not window.action("overlay_align").isEnabled()


def test_touches_are_repeated_in_the_scene_behind_the_recording(window):
    assert window.action("repeat_touches").isEnabled()
    shown = []
    window.live.prepared_changed.connect(shown.append)
    window.action("repeat_touches").trigger()
    assert window.live.mode is Mode.RUNNING
    assert len(shown) == 1, "all that is drawn is made once"
    assert not outlined(window), "it went with the recording it lay over"
    assert len(window.live.prepared.scene.stimuli) == 1
    run(window, 0.4)
    assert [region.link for region in window.live.shown.regions] == [
        window.live.prepared.skin.link(window.live.prepared.skin.taxel_point(TAXEL))
    ]


def test_repeated_touches_use_the_chosen_controller(window, two):
    window.live.replay.leave()
    path = ((0.01, 0.02), (0.03, 0.02))
    settings = replace(ControlSettings(), controller="hybrid", task="follow_path", path_kind="polyline", path=path)
    window.live.set_settings(settings)
    window.live.open_recording(two[0])
    window.action("repeat_touches").trigger()
    assert window.live.run.settings.settings == settings
    assert settings_from(window.live.run.prepared.scene.control) == settings
    window.live.reset()
    run(window, 0.1)
    assert window.live.runner.session.runtime_settings.settings == settings


@pytest.mark.long
def test_overlay_of_another_skin_is_rejected(window, tmp_path, choose_file):
    record(small_arm(), tmp_path / "other.mcap", ticks=5)
    choose_file("open_file", tmp_path / "other.mcap")
    window.action("overlay_recording").trigger()
    assert "has another skin than" in window.notification_bar.text
    assert window.presenters.overlay.other is None
