"""Values that fall under pressure: they are reported after the tare, and changing the sign makes them contacts."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.live.channels.falling_values import FallingValues
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.session.inputs import CalibrationUsed
from tactile_widgets.__main__ import main
from tests.support.touch import bar_map, bar_skin, prepared_bar

SKIN = bar_skin()
_AWAY = np.linalg.norm(SKIN.patches[0].taxels.positions - SKIN.patches[0].taxels.positions[30], axis=1)
PRESSED = np.round(400 * np.exp(-((_AWAY / 0.03) ** 2)))
"""Change of the values (60,) under a touch of about five taxels."""
REST = 2000.0


def values(number, pressed, sign=-1):
    """Counts (60,) with noise of 1 count, of a skin whose values change by ``sign`` under pressure."""
    return REST + np.random.default_rng(number).integers(-1, 2, 60) + sign * pressed


def session_of(touches, *, sign=-1, **options):
    """Session that was tared with 20 readings, followed by ``touches`` (pressures in each reading)."""
    session = MeasuredSession(as_measured(prepared_bar()), finite=True, **options)
    session.tare(20)
    for number, pressed in enumerate([0 * PRESSED] * 25 + touches):
        session.show(Arrived(Reading(0.01 * number, values(number, pressed, sign), Unit.COUNTS), 0.01 * number))
    return session


def test_falling_values_are_detected_and_become_contacts_after_changing_the_sign():
    session = session_of([PRESSED] * 10)
    assert session.facts.falling
    assert not session.facts.inverted
    assert not session.frame.regions
    session.readings.invert()
    assert not session.facts.falling
    frame = session.show(Arrived(Reading(1.0, values(99, PRESSED), Unit.COUNTS), 1.0))
    assert len(frame.regions) == 1
    assert session.facts.inverted
    for number in range(10):
        session.show(Arrived(Reading(1.1 + 0.01 * number, values(number, PRESSED), Unit.COUNTS), 1.1 + 0.01 * number))
    assert not session.facts.falling


@pytest.mark.parametrize(
    ("touches", "options"),
    [
        ([PRESSED] * 4, {}),
        ([PRESSED * (np.arange(60) == PRESSED.argmax())] * 20, {}),
        ([PRESSED] * 20, {"sign": 1}),
        ([PRESSED] * 20, {"inverted": True}),
        ([0.5 * np.roll(PRESSED, 20) - PRESSED] * 20, {}),
        ([0 * PRESSED] * 300, {}),
    ],
    ids=["four readings", "one taxel", "rising values", "inverted", "a deeper rise elsewhere", "noise"],
)
def test_other_readings_are_not_falling_values(touches, options):
    assert not session_of(touches, **options).facts.falling


def test_new_tare_resets_the_detection():
    session = session_of([PRESSED] * 10)
    session.tare(20)
    assert not session.facts.falling


def test_taxels_without_noise_are_detected_from_one_count():
    falling = FallingValues(SKIN)
    for _ in range(5):
        falling.add(-1e3 * PRESSED, None)
    assert falling.found


def test_sign_of_a_recording_is_used_in_replay():
    inputs = [one for _, one in session_of([PRESSED], inverted=True).inputs]
    used = [one for one in inputs if isinstance(one, CalibrationUsed)][-1]
    again = MeasuredSession(as_measured(prepared_bar()), finite=True)
    again.adopt(used)
    frame = again.show(Arrived(Reading(0.0, values(1, PRESSED), Unit.COUNTS), 0.0))
    assert again.readings.inverted
    assert len(frame.regions) == 1


def test_listen_warns_of_falling_values_and_names_the_option(tmp_path, capsys):
    rows = [0 * PRESSED] * 25 + [PRESSED] * 10
    lines = [",".join(map(str, [0.01 * n, *values(n, row)])) for n, row in enumerate(rows)]
    path = tmp_path / "falls.csv"
    path.write_text("\n".join(["time," + ",".join(map(str, range(60))), *lines, ""]))
    skin = tmp_path / "skin.npz"
    save_map(bar_map(), skin)
    target = str(tmp_path / "felt.mcap")
    arguments = ["listen", str(path), "--skin", str(skin), "--tare", "20", "--json"]
    assert main(arguments) == 0
    captured = capsys.readouterr()
    assert "add --inverted" in captured.err
    assert json.loads(captured.out)["contacts"] == 0
    assert main([*arguments, "--inverted", "-o", target]) == 0
    captured = capsys.readouterr()
    assert "--inverted" not in captured.err
    assert json.loads(captured.out)["contacts"] == 1
    assert main(["listen", target, "--skin", str(skin), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["contacts"] == 1, "with the sign of the recording"
