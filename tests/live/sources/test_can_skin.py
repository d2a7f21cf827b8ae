"""The guide's example of a skin on a CAN bus, with the virtual bus of python-can."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError
from tactile_maps.live.sources.open import SourceOptions

EXAMPLE = runpy.run_path(str(Path(__file__).resolve().parents[3] / "assets" / "guide" / "can_skin.py"))


def build(address):
    return EXAMPLE["CAN"].build(address, SourceOptions())


def test_address_without_a_channel_is_rejected():
    with pytest.raises(UsageError, match="can:INTERFACE:CHANNEL"):
        build("can:socketcan")
    with pytest.raises(LiveError, match="not open"):
        build("can:virtual:skin").receive(0.0)


def test_messages_of_boards_become_readings_of_their_taxels():
    can = pytest.importorskip("can", reason="python-can is not installed: only this example needs it")
    source = build("can:virtual:skin")
    source.open()
    with can.Bus(interface="virtual", channel="skin") as boards:
        for identifier, data in ((0x102, bytes([0, 1, 0, 2, 0, 3, 1, 0])), (0x300, bytes(8)), (0x101, bytes(3))):
            boards.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False, timestamp=7.0))
        reading = source.receive(1.0)
        assert (reading.ids.tolist(), reading.values.tolist()) == ([8, 9, 10, 11], [1, 2, 3, 256])
        assert source.receive(1.0) is None
        with pytest.raises(MalformedReadingError, match="board 1"):
            source.receive(1.0)
        assert source.receive(0.0) is None
    source.close()
