"""Lines of a serial port, here one end of a pseudo-terminal."""

from __future__ import annotations

import os

import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.wire_format import encode_json
from tactile_maps.live.sources.serial_port import SerialSource

pytest.importorskip("serial")
pty = pytest.importorskip("pty", reason="no pseudo-terminals on this system")


@pytest.fixture
def port():
    board, ours = pty.openpty()
    source = SerialSource(os.ttyname(ours))
    source.open()
    yield source, board
    source.close()
    for end in (board, ours):
        os.close(end)


def line(number):
    return encode_json(Reading(0.01 * number, [1.0, 2.0], sequence=number)) + b"\r\n"


def test_lines_split_into_any_chunks_are_read(port):
    source, board = port
    whole = line(1) + b"\n" + line(2)
    os.write(board, whole[:20])
    assert source.receive(0.05) is None
    os.write(board, whole[20:])
    assert [source.receive(0.5).sequence for _ in range(2)] == [1, 2]
    assert source.receive(0.0) is None


def test_only_the_first_line_may_be_incomplete(port):
    source, board = port
    os.write(board, line(1)[9:] + line(2) + line(3)[9:] + line(4))
    assert source.receive(0.5) is None
    assert source.receive(0.5).sequence == 2
    with pytest.raises(MalformedReadingError):
        source.receive(0.5)
    assert source.receive(0.5).sequence == 4


def test_disconnected_board_is_reported_as_lost():
    board, ours = pty.openpty()
    source = SerialSource(os.ttyname(ours))
    source.open()
    os.close(ours)
    os.close(board)
    with pytest.raises(LiveError, match="connection is lost"):
        source.receive(0.01)
    source.close()


def test_missing_port_is_reported(tmp_path):
    with pytest.raises(LiveError, match="connected"):
        SerialSource(str(tmp_path / "tty")).open()
