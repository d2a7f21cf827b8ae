"""What a person may do is exactly what a recording can hold."""

from __future__ import annotations

from typing import get_args

from app.control.command import ControlSettings
from app.recording.codec import decode_input, encode_input
from app.session.inputs import ControlChanged, PokeMoved, PokePressed, PokeReleased, SessionInput
from tests.touch import bar_skin


def test_every_input_can_be_recorded():
    at = bar_skin().taxel_point(3)
    acts = [PokePressed(1, at), PokeMoved(1, at), PokeReleased(1), ControlChanged(ControlSettings())]
    assert {type(act) for act in acts} == set(get_args(SessionInput))
    assert [decode_input(encode_input(5, act)) for act in acts] == [(5, act) for act in acts]
