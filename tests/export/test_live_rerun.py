"""A running session in a Rerun viewer: addresses, a viewer that is not there, and one that is closed meanwhile."""

from __future__ import annotations

import socket
import time

import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.export.live_rerun import VIEWER, LiveRerun
from tactile_maps.session.session import Session
from tests.support.touch import prepared_bar

BAD = (
    "http://127.0.0.1:9876/proxy",
    "rerun+http://127.0.0.1:9876",
    "rerun+http:",
    "x:y:z",
    "rerun+http://127.0.0.1:0/proxy",
    "rerun+http://[/proxy",
)


@pytest.mark.parametrize("address", BAD)
def test_invalid_viewer_address_is_rejected(address):
    with pytest.raises(ExportError, match="invalid address of a Rerun viewer"):
        LiveRerun(prepared_bar(), address=address)


def test_missing_package_error_names_the_extra():
    try:
        import rerun  # noqa: F401
    except ImportError:
        with pytest.raises(ExportError, match=r"-m pip install 'rerun-sdk"):
            LiveRerun(prepared_bar())
    else:
        pytest.skip("rerun-sdk is installed")


@pytest.fixture
def viewer():
    """A server as a viewer has it; its address, and the stream that keeps it open."""
    rerun = pytest.importorskip("rerun", reason="rerun-sdk is not installed (extra rerun)")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    stream = rerun.RecordingStream("viewer")
    stream.serve_grpc(grpc_port=port)
    yield VIEWER.replace("9876", str(port)), stream
    stream.disconnect()


def test_missing_viewer_is_reported():
    pytest.importorskip("rerun", reason="rerun-sdk is not installed (extra rerun)")
    with pytest.raises(ExportError, match="no Rerun viewer listens"):
        LiveRerun(prepared_bar(), address="rerun+http://127.0.0.1:1/proxy")


def test_frames_reach_a_viewer(viewer):
    address, _stream = viewer
    session = Session(prepared_bar())
    with LiveRerun(session.prepared, address=address) as live:
        sent = []
        log = live._log.add
        live._log.add = lambda frame: (sent.append(frame.tick), log(frame))
        for _ in range(100):
            live.offer(session.tick(), session.map)
            _until(lambda: live._waiting is None)
        assert 5 <= len(sent) <= 13  # 0.5 s of session, 25 a second at most
        live._stream.flush(timeout_sec=10)
        assert not live.gone


def test_closed_viewer_is_ignored_and_closing_does_not_block():
    pytest.importorskip("rerun", reason="rerun-sdk is not installed (extra rerun)")
    session = Session(prepared_bar())
    with socket.create_server(("127.0.0.1", 0)) as viewer:
        live = LiveRerun(session.prepared, address=VIEWER.replace("9876", str(viewer.getsockname()[1])))
        live.offer(session.tick(), session.map)
        _until(lambda: live._waiting is None)
    with live:
        for _ in range(1000):
            live.offer(session.tick(), session.map)
            _until(lambda: live._waiting is None or live.gone)
            if live.gone:
                break
        assert live.gone
        began = time.monotonic()
    assert time.monotonic() - began < 10


def _until(true):
    deadline = time.monotonic() + 60
    while not true():
        assert time.monotonic() < deadline
