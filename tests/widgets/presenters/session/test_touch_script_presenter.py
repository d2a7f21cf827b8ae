"""The Touch menu in the real window: a hand becomes a script, a script touches, a load is weighed; a stop is kept."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QToolButton

from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.stimuli.stimulus_file import load_stimuli
from tactile_widgets.common.mode import Mode
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import blow_up, cancel, press_map, replay_run, run

pytestmark = pytest.mark.long


@pytest.fixture
def window(window_again):
    """Window without pokes."""
    return window_again


@pytest.fixture
def script(tmp_path, choose_file):
    """The file that both dialogs return."""
    path = tmp_path / "mine.toml"
    for name in ("save_file", "open_file"):
        choose_file(name, path)
    return path


def poke(window, taxel, seconds):
    """Press, hold, lift."""
    pixel = press_map(window, taxel)
    run(window, seconds)
    left_release(window.map_view.viewport(), pixel)
    run(window, 0.1)


def test_saved_pokes_play_as_a_script(window, script):
    run(window, 0.1)
    poke(window, 70, 0.4)
    felt = window.live.runner.session.prepared.skin.taxel_point(70).patch
    window.action("save_script").trigger()
    assert "1 touch" in window.notification_bar.text
    assert len(load_stimuli(script)) == 1
    window.column["effects"].override_requested.emit("friction", "on")
    run(window, 0.02)
    window.action("play_script").trigger()
    session = window.live.runner.session
    assert session.frame.tick == 0
    assert session.scripted
    assert session.effects.friction, "the scene restarts with the chosen effects"
    run(window, 0.3)
    (played,) = session.frame.pokes
    assert played.at.patch == felt
    point = session.prepared.skin.taxel_point(70)
    away = session.prepared.skin.position(played.at) - session.prepared.skin.position(point)
    assert np.linalg.norm(away) < 0.01


def test_script_is_played_once_or_repeatedly(window, script):
    assert not window.action("script_once").isEnabled() or window.live.prepared.scene.stimuli
    run(window, 0.1)
    poke(window, 70, 0.2)
    window.action("save_script").trigger()
    window.action("play_script").trigger()
    assert window.action("script_repeated").isChecked()
    window.action("script_once").trigger()
    assert window.live.runner.session.frame.tick == 0
    assert window.action("script_once").isChecked()

    def touched(seconds):
        times = []
        for _ in range(round(seconds / 0.05)):
            run(window, 0.05)
            if window.live.runner.session.frame.pokes:
                times.append(window.live.runner.session.frame.time)
        return times

    once = touched(2.0)
    assert once
    assert max(once) < 0.6, "the script touches once"
    window.action("reset").trigger()
    assert touched(0.6), "Reset plays it again"
    window.action("script_repeated").trigger()
    assert max(touched(2.0)) > 1.5


def test_two_touches_make_two_script_entries(window, script):
    run(window, 0.1)
    poke(window, 70, 0.2)
    poke(window, 20, 0.2)
    window.action("save_script").trigger()
    assert "2 touches" in window.notification_bar.text
    assert len(load_stimuli(script)) == 2


def test_script_without_touches_is_not_saved(window, script):
    run(window, 0.2)
    window.action("save_script").trigger()
    assert "press the skin" in window.notification_bar.text
    assert not script.exists()
    run(window, 0.1)
    poke(window, 70, 0.2)
    window.action("reset").trigger()
    window.action("save_script").trigger()
    assert not script.exists(), "what was before the reset is gone"


def test_invalid_script_shows_a_message(window, script):
    run(window, 0.2)
    session = window.live.runner.session
    script.write_text('[[stimuli]]\nkind = "pok"\n')
    window.action("play_script").trigger()
    assert "poke" in window.notification_bar.text
    assert window.live.runner.session is session
    script.write_text('[[stimuli]]\nkind = "poke"\npatch = "no such patch"\n')
    window.action("play_script").trigger()
    assert "no such patch" in window.notification_bar.text
    assert window.live.runner.session is session


def test_known_load_reads_its_weight(window):
    window.action("weigh").trigger()
    words = window.notification_bar.text
    assert words.startswith("0.1\u202fkg reads 0.9")
    assert "(expected 0.981\u202fN)" in words
    assert not window.loading_bar.busy


def test_weighing_shows_progress_and_can_be_cancelled(window, monkeypatch):
    monkeypatch.setattr(window.live.measurements.cost_executor, "hold", True)  # as in a process
    window.action("weigh").trigger()
    assert window.loading_bar.busy
    cancel(window)
    assert not window.loading_bar.busy


def test_script_actions_are_disabled_during_a_replay(window, tmp_path):
    replay_run(window, tmp_path / "short.mcap", 0.1)
    for name in ("save_script", "play_script", "weigh"):
        assert not window.action(name).isEnabled()
    window.live.replay.leave()
    assert window.action("weigh").isEnabled()


def test_stop_is_saved_as_a_report(window, tmp_path):
    run(window, 0.2)
    blow_up(window.live)
    button = window.notification_bar.findChild(QToolButton, "message-second-remedy")
    assert button.text() == "Save report"
    left_click(button)
    (path,) = (tmp_path / "recordings").glob("stopped*.mcap")
    assert str(path) in window.notification_bar.text, "the reply to the press remains visible"
    player = RecordingPlayer(path)
    assert player.failure is not None
    assert "diverged" in str(player.failure[1])
    window.action("reset").trigger()
    assert window.live.mode is Mode.RUNNING
    assert not window.live.recording.can_report
