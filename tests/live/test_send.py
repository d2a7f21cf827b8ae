"""The sample sender sends what a receiver takes."""

from __future__ import annotations

import socket
import threading

import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.sources.network import UdpSource
from tactile_maps.live.sources.send import made_up, main, sender


@pytest.mark.parametrize("options", [[], ["--axes", "3"], ["--json", "--axes", "3", "--token", "a secret of ours"]])
def test_sent_readings_arrive(options, capsys):
    before = set(threading.enumerate())
    source = UdpSource("127.0.0.1", 0, token=options[-1] if "--token" in options else None)
    connection = Connection(source)
    connection.open()
    connection.start()
    assert main([f"udp://127.0.0.1:{source.port}", "--count", "20", "--rate", "1000", "--taxels", "50", *options]) == 0
    found = []
    while len(found) < 20:
        assert connection.wait(5.0)
        while (item := connection.take()) is not None:
            found.append(item.reading)
    connection.close()
    assert [reading.sequence for reading in found] == list(range(20))
    assert len(found[0].values) == 50
    assert [found[0].shear is not None] == ["--axes" in options]
    assert "sent 20 packets" in capsys.readouterr().out
    assert set(threading.enumerate()) <= before


def test_file_is_sent_row_by_row(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text("time,5,6\n0,1,2\n0.001,3,4\n0.002,x,4\n")
    source = UdpSource("127.0.0.1", 0)
    source.open()
    assert main([f"udp://127.0.0.1:{source.port}", "--file", str(path)]) == 0
    assert [source.receive(1.0).values.tolist() for _ in range(2)] == [[1.0, 2.0], [3.0, 4.0]]
    source.close()


def test_invalid_usage_is_reported(capsys, tmp_path):
    assert main(["http://127.0.0.1:1"]) == 2
    assert main(["udp://127.0.0.1:9", "--file", str(tmp_path / "none.csv")]) == 1
    assert "cannot be sent to this address" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--taxels", "0"], ["--taxels", "100001"], ["--count", "0"], ["--count", "9" * 30]])
def test_numbers_out_of_range_are_rejected(capsys, words):
    with pytest.raises(SystemExit, match="2"):
        main(["udp://127.0.0.1:9", *words])
    assert f"argument {words[0]}: must be 1 to " in capsys.readouterr().err


def test_generated_readings_move_over_the_skin():
    stream = made_up(100, 100.0)
    first, *_, last = (next(stream) for _ in range(200))
    assert first.values.argmax() != last.values.argmax()


def test_packet_that_cannot_be_published_raises_a_clear_error():
    pytest.importorskip("zmq", reason="pyzmq is not installed (extra zmq)")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with sender(f"zmq://127.0.0.1:{port}") as publish:
        pass
    with pytest.raises(LiveError, match="cannot be published"):
        publish(b"too late")


@pytest.mark.parametrize("address", ["udp://127.0.0.1:0", "udp://127.0.0.1:99999"])
def test_address_without_a_port_is_rejected(address, capsys):
    assert main([address, "--count", "1"]) == 2
    assert address in capsys.readouterr().err
