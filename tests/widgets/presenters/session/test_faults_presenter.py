"""Broken taxels in the real window: marked on map and body and named while there are any; of a real skin too."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QLabel

from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.recording.player import open_recording
from tactile_widgets.overlays.taxel_faults import Fault
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.support.window_driver import choose_effect, run


@pytest.fixture
def window(window_again):
    """Effects begin again with the scene, and what was connected is disconnected."""
    return window_again


def shown(window):
    """Faults on the map, taxels marked on the body, and the panel's words."""
    label = window.column.get(ContactsPanel).findChild(QLabel, "contacts-faults")
    body = [mark.actor for mark in window.robot_view.display.actors._fault_marks._marks]
    words = "" if label.isHidden() else label.text()  # its tab is hidden while a real skin is connected
    return dict(window.map_view.marks.faults), any(actor.visibility for actor in body), words


@pytest.mark.long
def test_simulated_dead_taxels_are_marked(window):
    assert shown(window) == ({}, False, "")
    choose_effect(window, "dead_taxels", "on")
    run(window, 0.02)
    on_map, on_body, words = shown(window)
    assert Fault.DEAD in on_map
    assert on_body
    broken = int(np.count_nonzero(window.views.faults.broken))
    assert words.startswith(f"{broken} broken taxel")
    assert "estimated from neighbours" in words
    choose_effect(window, "dead_taxels", "auto")
    run(window, 0.02)
    assert shown(window) == ({}, False, "")


def silent_table(window, taxels):
    """Readings in counts that all change but for these ``taxels``, the last of which is stuck, for eight seconds."""
    count = len(window.live.prepared.skin)
    rows = [f"time,sequence,{','.join(map(str, range(count)))}"]
    noise = np.random.default_rng(1).integers(0, 40, (80, count))
    noise[:, taxels] = 7
    noise[:, taxels[-1]] = 60
    rows += [f"{0.1 * k:.1f},{k},{','.join(map(str, row))}" for k, row in enumerate(noise.tolist())]
    return "\n".join(rows) + "\n"


def test_broken_channels_of_a_real_skin_are_marked_live_and_in_a_recording(window, tmp_path, qtbot):
    silent = np.array([20, 40, 60])
    path = tmp_path / "readings.csv"
    path.write_text(silent_table(window, silent))
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    window.live.recording.start(tmp_path / "silent.mcap")

    def marked():
        run(window, 0.2)
        return window.views.faults.broken[silent].all() if len(window.views.faults.broken) else False

    qtbot.waitUntil(lambda: bool(marked()), timeout=60_000)
    live = shown(window)
    on_map = {Fault.DEAD: "2 taxels dead", Fault.STUCK: "1 taxel stuck"}
    assert live == (on_map, True, "3 broken taxels: 3 estimated from neighbours")
    window.live.recording.stop()
    window.live.show_player(open_recording(tmp_path / "silent.mcap"))
    assert shown(window)[0] == {}
    window.live.replay.seek(window.live.replay.player.duration)
    assert shown(window) == live
    window.live.replay.leave()
    window.live.connection.close()
    run(window, 0.1)
    assert shown(window) == ({}, False, "")
