"""Packets read back equal, and what is damaged, foreign or without its token is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.core.errors import LiveError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit
from tactile_maps.live.readings.wire_format import HEADER, decode, encode_binary, encode_json, is_plausible

READINGS = {
    "bare": Reading(1.25, [1.0, 2.5, -3.0]),
    "ids": Reading(2.0, [1.0, 2.0], Unit.KILOPASCAL, ids=[87012, 5], sequence=2**32 - 1),
    "channels": Reading(3.0, [4.0, 5.0], Unit.PASCAL, channels=[[14, 3], [14, 4]], joints={"Ellbögen": 0.5, "b": -1.0}),
    "missing": Reading(3.0, [4.0, np.nan]),
    "sheared": Reading(3.0, [4.0, np.nan, 2.0], ids=[7, 8, 9], shear=[[1.0, -2.0], [0.5, np.nan], [np.nan, np.nan]]),
    "empty": Reading(0.0, [], joints={"only": 1.0}, sequence=0),
}


@pytest.mark.parametrize("name", READINGS)
@pytest.mark.parametrize("encode", [encode_json, encode_binary])
@pytest.mark.parametrize("token", [None, "a secret of ours"])
def test_reading_is_restored_from_its_packet(name, encode, token):
    given_ = READINGS[name]
    back = decode(encode(READINGS[name], token=token), token=token)
    assert (back.time, back.unit, dict(back.joints)) == (given_.time, given_.unit, dict(given_.joints))
    assert back.sequence == (given_.sequence if encode is encode_json else given_.sequence or 0)
    for field in ("values", "ids", "channels", "shear"):
        one = getattr(back, field)
        other = getattr(given_, field)
        assert (one is None) == (other is None)
        assert one is None or np.array_equal(one, other, equal_nan=field in ("values", "shear"))


def test_null_is_the_value_of_a_taxel_that_did_not_report():
    packet = b'{"v":1,"t":0.0,"values":[1,null]}'
    assert np.array_equal(decode(packet).values, [1.0, np.nan], equal_nan=True)
    assert b"[1.0,null]" in encode_json(decode(packet))


def test_three_values_of_a_taxel_are_pressure_and_shear():
    reading = decode(b'{"v":1,"t":0,"unit":"kPa","ids":[12,13],"values":[[8,1,-0.5],2]}')
    assert reading.values.tolist() == [8.0, 2.0]
    assert np.array_equal(reading.shear, [[1.0, -0.5], [np.nan, np.nan]], equal_nan=True)
    binary = encode_binary(reading)
    assert binary[5] == 5
    assert binary[-24:].hex() == "00000041 0000803f 000000bf 00000040 0000c07f 0000c07f".replace(" ", "")


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([[1, 2, 3], [1, 2]], "values, id 13: wrong number of channels .found: 2.*t1, t2"),
        ([[1, 2], [1, 2]], "values, id 12: wrong number of channels .found: 2"),
        ([[1, 2, 3], [1, "2", 3]], "values, id 13: expected a number"),
        ([[1, 2, 3], [1, 2, [3]]], "values, id 13: expected a number"),
    ],
)
def test_wrong_channels_of_a_taxel_are_named(values, found):
    packet = {"v": 1, "t": 0.0, "ids": [12, 13], "values": values}
    with pytest.raises(MalformedReadingError, match=found):
        decode(json.dumps(packet).encode())


def test_infinite_shear_is_named():
    with pytest.raises(MalformedReadingError, match="id 13: a value is infinite"):
        Reading(0.0, [1.0, 1.0], ids=[12, 13], shear=[[0.0, 1.0], [np.inf, 0.0]])


def test_ids_with_links_are_restored_from_json_but_not_from_binary():
    reading = Reading(0.0, [1.0, 2.0], ids=[16, 16], links=("left_plate", "a:b"))
    packet = encode_json(reading)
    assert json.loads(packet)["ids"] == ["left_plate:16", "a:b:16"]
    assert (decode(packet).ids.tolist(), decode(packet).links) == ([16, 16], ("left_plate", "a:b"))
    with pytest.raises(LiveError, match="cannot state the links"):
        encode_binary(reading)


@pytest.mark.parametrize("ids", [["l:1", "2"], ["l:x"], [":1"], ["l:"], ["1.5"], ["l:1", 2], [f"l:{9**40}"]])
def test_invalid_ids_are_rejected(ids):
    packet = {"v": 1, "t": 0.0, "unit": "counts", "values": [1.0] * len(ids), "ids": ids}
    with pytest.raises(MalformedReadingError):
        decode(json.dumps(packet).encode())


def test_binary_packet_matches_the_guide():
    packet = encode_binary(READINGS["ids"])
    assert packet.hex() == (
        "544d4c52 01 01 02 00 ffffffff 0000000000000040 02000000 0000 e4530100 05000000 0000803f 00000040"
    ).replace(" ", "")
    assert HEADER.size == 26


@pytest.mark.parametrize("encode", [encode_json, encode_binary])
@pytest.mark.parametrize("token", [None, "another secret"])
def test_packet_without_the_token_is_rejected(encode, token):
    with pytest.raises(MalformedReadingError, match="token"):
        decode(encode(READINGS["ids"], token=token), token="a secret of ours")


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"v": 2}, "v"),
        ({"v": True}, "v"),
        ({"values": ["1"]}, "values"),
        ({"values": [True]}, "values"),
        ({"values": None}, "values"),
        ({"ids": [1.5]}, "ids"),
        ({"ids": [10**30]}, "ids"),
        ({"unit": "psi"}, "unit"),
        ({"seq": -1}, "seq"),
        ({"t": "now"}, "t"),
        ({"joints": [1]}, "joints"),
        ({"extra": 1}, "extra"),
    ],
)
def test_invalid_json_field_is_named(change, place):
    packet = {"v": 1, "t": 0.0, "unit": "counts", "values": [1.0], **change}
    with pytest.raises(MalformedReadingError) as caught:
        decode(json.dumps(packet).encode())
    assert caught.value.place == place


@given(st.binary(max_size=200))
def test_any_bytes_are_a_reading_or_rejected(data):
    for packet in (data, encode_binary(READINGS["channels"])[: len(data)] + data):
        try:
            decode(packet)
        except MalformedReadingError:
            continue
        assert is_plausible(packet)


@pytest.mark.parametrize("packet", [b"garbage" * 10, b"TMLR", b"TMLR\x02" + bytes(60), b"", b"[1]"])
def test_packets_with_another_prefix_are_not_plausible(packet):
    assert not is_plausible(packet)
    assert is_plausible(b" " + encode_json(READINGS["channels"]))
    assert is_plausible(encode_binary(READINGS["channels"]))


@given(st.integers(0, 70), st.integers(0, 255))
def test_packet_with_any_changed_byte_is_a_reading_or_rejected(place, byte):
    packet = bytearray(encode_binary(READINGS["channels"]))
    packet[place % len(packet)] = byte
    try:
        decode(bytes(packet))
    except MalformedReadingError:
        return


def test_truncated_or_extended_packet_is_rejected():
    for whole in (encode_binary(READINGS["channels"]), encode_json(READINGS["channels"])):
        with pytest.raises(MalformedReadingError):
            decode(whole + b"\0")
        for length in range(len(whole)):
            with pytest.raises(MalformedReadingError):
                decode(whole[:length])
