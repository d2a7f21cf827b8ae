"""Playhead: position as a function of elapsed time."""

from __future__ import annotations

import pytest

from tactile_widgets.plots.timeline.playhead import Playhead, clock_text, nice_step


def test_playhead_advances_by_elapsed_time_and_speed():
    head = Playhead(10.0, speed=2.0).toggled()
    assert head.playing
    assert head.advanced(1.5).time == pytest.approx(3.0)


def test_paused_playhead_does_not_move():
    assert Playhead(10.0, time=4.0).advanced(100.0).time == 4.0


def test_playhead_stops_at_the_end_and_restarts_from_there():
    head = Playhead(10.0, time=9.9).toggled().advanced(1.0)
    assert (head.time, head.playing, head.at_end) == (10.0, False, True)
    again = head.toggled()
    assert (again.time, again.playing) == (0.0, True)


def test_pausing_keeps_the_position():
    head = Playhead(10.0).toggled().advanced(2.0).toggled()
    assert (head.time, head.playing) == (2.0, False)


@pytest.mark.parametrize(("time", "expected"), [(-1.0, 0.0), (4.0, 4.0), (99.0, 10.0)])
def test_seeking_is_clamped_to_the_recording(time, expected):
    assert Playhead(10.0).at(time).time == expected


def test_step_moves_by_frames_and_pauses():
    head = Playhead(10.0, frame_seconds=0.005, time=1.0, playing=True)
    assert head.stepped(10).time == pytest.approx(1.05)
    assert not head.stepped(10).playing
    assert head.stepped(-10_000).time == 0.0


def test_empty_recording_does_not_play():
    assert not Playhead(0.0).toggled().playing


@pytest.mark.parametrize(
    ("seconds", "decimals", "text"),
    [
        (0, 1, "0:00.0"),
        (64.25, 1, "1:04.2"),
        (59.999, 1, "0:59.9"),
        (60, 0, "1:00"),
        (0.3, 2, "0:00.30"),
        (-1, 0, "0:00"),
    ],
)
def test_clock_text_rounds_down(seconds, decimals, text):
    assert clock_text(seconds, decimals=decimals) == text


@pytest.mark.parametrize(("duration", "most"), [(0.5, 8), (64.2, 10), (7000, 6), (1e6, 5)])
def test_marks_are_round_and_few(duration, most):
    step = nice_step(duration, most)
    assert duration / step <= most
