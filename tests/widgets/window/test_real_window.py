"""The window as a person has it: the session on its thread, scenes, edits, qualities and recordings in processes."""

from __future__ import annotations

import multiprocessing as mp
import threading
from dataclasses import replace

import pytest

from tactile_maps.editing.reflatten import set_method
from tactile_widgets.common.mode import Mode
from tactile_widgets.presenters.touch_presenter import MOUSE_FINGER
from tactile_widgets.session.backends import BACKGROUND
from tests.widgets.support.mouse import left_release
from tests.widgets.support.samples import coarse
from tests.widgets.support.window_driver import press_map

pytestmark = pytest.mark.long

LONG = 120_000


@pytest.fixture
def backends():
    """The backends of the program."""
    return BACKGROUND


def pressed(frame):
    """Whether a person's finger presses, not the scene's own."""
    return any(poke.id == MOUSE_FINGER and poke.force > 0 for poke in frame.pokes)


def threads():
    """Names of those of ours that run."""
    return sorted(thread.name for thread in threading.enumerate() if thread.name in ("session", "recording"))


def test_press_edit_record_and_replay(window, qtbot, tmp_path):
    live = window.live
    frames = []
    live.frame_ready.connect(frames.append)
    with qtbot.waitSignal(live.measurements.measured, timeout=LONG):
        pass
    window.action("record").trigger()
    assert threads() == ["recording", "session"]
    press_map(window, 70)
    qtbot.waitUntil(lambda: pressed(frames[-1]) and bool(frames[-1].regions), timeout=LONG)
    tick = frames[-1].tick
    left_release(window.map_view.viewport())
    with qtbot.waitSignal(live.recording.saved, timeout=LONG):
        window.action("record").trigger()
    assert threads() == ["session"]
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    window.presenters.files.open_path(str(file))
    qtbot.waitUntil(lambda: live.mode is Mode.REPLAYING, timeout=LONG)
    live.replay.seek((tick - frames[-1].tick) * live.prepared.scene.tick)
    assert (frames[-1].tick, pressed(frames[-1])) == (tick, True)
    assert frames[-1].regions
    live.replay.leave()
    ticks = len(frames)
    qtbot.waitUntil(lambda: len(frames) > ticks + 2, timeout=LONG)
    with qtbot.waitSignals([window.editor.settled, live.measurements.measured], timeout=LONG):
        window.editor.ask(lambda document: set_method(document, [0], "lscm"))
    edited = window.editor.document
    assert edited.charts[0].method == "lscm"
    qtbot.waitUntil(lambda: live.runner.session.map is edited.map, timeout=LONG)
    window.presenters.map_files.give_up()
    window.close()
    assert threads() == []
    assert not mp.active_children()


@pytest.mark.long
def test_failed_scene_keeps_the_running_one(window, qtbot):
    live = window.live
    first = window.live.prepared
    arm = coarse(60)
    with qtbot.waitSignal(live.failed, timeout=LONG) as failure:
        window.presenters.files.open_scene(replace(arm, robot="no-such-robot"))
    assert "no-such-robot" in failure.args[0]
    assert live.prepared is first
    tick = live.runner.session.frame.tick
    with qtbot.waitSignal(live.prepared_changed, timeout=LONG):
        window.presenters.files.open_scene(arm)
    assert len(live.prepared.skin) == 60
    assert tick > 0
    qtbot.waitUntil(lambda: live.runner.session.frame.tick > 5, timeout=LONG)
    assert live.mode is Mode.RUNNING
