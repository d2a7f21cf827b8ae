"""No plot loses what the views had no time for, and a jump in a recording fills them with what was before it."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.recording.player import open_recording
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.inputs import PokePressed, PokeReleased
from tactile_maps.session.session import Session

pytestmark = pytest.mark.long


def drawn_forces(window):
    """Ages [s] and forces [N] of all contacts together, as drawn."""
    return [np.zeros(0) if part is None else part for part in window.plots._force._line.getData()]


def test_short_push_between_two_drawings_is_plotted(window_again, prepared):
    """The window looks once in two seconds; each tick in between is in the plot."""
    window = window_again
    runner = window_again.live.runner
    forces = []
    each = runner._each
    runner._each = lambda frame: (forces.append(sum(r.force for r in frame.regions)), each(frame))
    runner.submit(PokePressed(0, prepared.skin.taxel_point(20)))
    runner.run_for(0.5)
    runner.submit(PokeReleased(0))
    runner.run_for(1.5)
    assert max(forces) > 1 > forces[-1]
    window.live.pump()
    window.plots._redraw()
    assert drawn_forces(window)[1].max() == pytest.approx(max(forces))


def test_plots_show_the_preceding_seconds_after_a_jump(window_again, prepared, tmp_path, qtbot):
    window = window_again
    path = tmp_path / "push.mcap"
    session = Session(prepared, scripted=False)
    forces = []
    with Recorder(prepared, path) as recorder:
        session.submit(PokePressed(0, prepared.skin.taxel_point(20)))
        for k in range(200):
            if k == 80:
                session.submit(PokeReleased(0))
            recorder.write(session.tick(), session.inputs)
            forces.append(sum(region.force for region in session.frame.regions))
    window.live.show_player(open_recording(path))
    window.action("whole_recording").trigger()  # to the last seconds
    window.live.replay.seek(0.9)
    qtbot.waitUntil(lambda: len(drawn_forces(window)[0]) > 10)
    ages, shown = drawn_forces(window)
    assert ages.min() == pytest.approx(-0.9, abs=0.02)
    assert shown.max() == pytest.approx(max(forces[:181]))
    window.set_theme("light")
    assert len(drawn_forces(window)[0]) == len(ages), "another theme keeps them"
    window.action("whole_recording").trigger()
    window.live.replay.leave()
