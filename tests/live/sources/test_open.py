"""A source is chosen by its address; what is not safe or not known is refused."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from tactile_maps.core.errors import LiveError, TactileMapsError, UsageError
from tactile_maps.live.sources.open import SourceOptions, is_live, open_source


@pytest.mark.parametrize(
    ("address", "kind", "full_address"),
    [
        ("udp:", "UdpSource", "udp://127.0.0.1:9870"),
        ("udp://localhost:99", "UdpSource", "udp://localhost:99"),
        ("udp://127.0.0.1:0", "UdpSource", "udp://127.0.0.1:0"),
        ("udp://127.0.0.1:", "UdpSource", "udp://127.0.0.1:9870"),
        ("zmq://10.0.0.7", "ZmqSource", "zmq://10.0.0.7:9870"),
        ("serial:///dev/ttyACM0?baud=9600", "SerialSource", "serial:///dev/ttyACM0?baud=9600"),
        ("serial://COM3", "SerialSource", "serial://COM3?baud=115200"),
        ("yarp://robot:10000/skin/torso", "YarpSource", "yarp://robot:10000/skin/torso"),
        ("readings.csv", "FileSource", "readings.csv"),
    ],
)
def test_address_selects_the_source(address, kind, full_address):
    source = open_source(address)
    assert (type(source).__name__, source.address) == (kind, full_address)
    assert source.finite is not is_live(address)


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("", "no source is named"),
        ("http://localhost", "unknown kind of source"),
        ("readings.docx", "unknown kind of source"),
        (str(Path(__file__).parent), "this folder is not a source of readings.*Name a file in it"),
        ("udp://127.0.0.1:99999", "invalid port number"),
        ("zmq://127.0.0.1:http", "invalid port number.*http"),
        ("udp://239.1.1.1:9870", "multicast or broadcast"),
        ("udp://[ff02::1]:9870", "multicast or broadcast"),
        ("udp://255.255.255.255:9870", "multicast or broadcast"),
        ("zmq://239.1.1.1:9870", "multicast or broadcast"),
        ("udp://300.1.1.1:5000", "invalid IP address.*300.1.1.1.*0 to 255"),
        ("udp:abc", "no // before the host.*udp:abc.*udp://abc"),
        ("zmq:localhost:5000", "no // before the host.*zmq://localhost:5000"),
        ("zmq://192.168.1:5000", "invalid IP address.*192.168.1[)]"),
        ("yarp://10.0.0.256:10000/skin", "invalid IP address.*10.0.0.256"),
        ("udp://[", "invalid address"),
        ("zmq://127.0.0.1:0", "no program can be reached at port 0"),
        ("yarp://robot:0/skin", "no program can be reached at port 0"),
        ("serial:///dev/ttyACM0?baud=fast", "invalid baud rate"),
        ("serial:///dev/ttyACM0?baud=", "invalid baud rate"),
        ("serial:///dev/ttyACM0?baud=0", "invalid baud rate"),
        ("serial:///dev/ttyACM0?baud=" + "9" * 5000, "invalid baud rate"),
        ("serial://[", "invalid address"),
        ("udp://0.0.0.0:9870", "open to other machines"),
        ("ros2:", "need a mapping"),
    ],
)
def test_invalid_address_is_rejected_with_a_remedy(address, said):
    with pytest.raises(TactileMapsError, match=said) as caught:
        open_source(address)
    assert caught.value.remedy


def test_port_0_listens_on_a_free_port_stated_in_the_address():
    first = open_source("udp://127.0.0.1:0")
    second = open_source("udp://127.0.0.1:0")
    first.open()
    second.open()
    ports = {urlsplit(source.address).port for source in (first, second)}
    first.close()
    second.close()
    assert len(ports - {0, 9870}) == 2


def test_other_machines_require_a_long_token():
    with pytest.raises(UsageError, match="open to other machines"):
        open_source("udp://0.0.0.0:9870", SourceOptions(remote=True))
    with pytest.raises(UsageError, match="too short"):
        open_source("udp://0.0.0.0:9870", SourceOptions(remote=True, token="abc"))
    open_source("udp://0.0.0.0:9870", SourceOptions(remote=True, token="long enough"))


@pytest.mark.parametrize(
    ("address", "known"),
    [
        ("udp://127.0.0.1:9870?foo=1", "Remove the question mark"),
        ("zmq://127.0.0.1:9870?foo", "Remove the question mark"),
        ("yarp://127.0.0.1:10000/skin?foo=1", "Choose link"),
        ("serial:///dev/ttyUSB0?foo=115200", "Choose baud"),
    ],
)
def test_unknown_address_parameters_are_rejected_with_the_known_ones(address, known):
    with pytest.raises(UsageError, match=rf"the address has an unknown parameter \(found: foo\)\. {known}") as refusal:
        open_source(address)
    assert refusal.value.place == address


@pytest.mark.parametrize("name", ["readings.csv", "readings.mcap", "zero"])
def test_pipe_is_rejected_without_blocking(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(LiveError, match="this is not a file .found: a pipe"):
        open_source(str(tmp_path / name))


def test_device_is_rejected():
    with pytest.raises(LiveError, match="this is not a file .found: a device"):
        open_source("/dev/zero")
