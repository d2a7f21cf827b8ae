"""A frame as one field of bytes in Protobuf: read back by Google's own library where it is installed."""

from __future__ import annotations

import pytest

from tactile_maps.recording.encoding.frame_schema import PREFIX_BYTES, descriptor, has_prefix, prefix


@pytest.mark.parametrize("length", [0, 1, 127, 128, 16_383, 300_000, 2**31 - 1])
def test_prefix_is_tag_and_length_with_constant_size(length):
    head = prefix(length)
    assert len(head) == PREFIX_BYTES
    assert head[0] == 0x0A, "field 1, bytes that follow"
    assert sum((byte & 0x7F) << 7 * place for place, byte in enumerate(head[1:])) == length
    assert [bool(byte & 0x80) for byte in head[1:]] == [True, True, True, True, False]


def test_prefix_is_recognized_only_for_a_complete_field():
    message = prefix(3) + b"abc"
    assert has_prefix(message)
    assert not any(has_prefix(other) for other in (b"", message[:-1], message + b"x", b"abc", message[1:]))


def test_protobuf_itself_reads_message_and_comment():
    pool = pytest.importorskip("google.protobuf.descriptor_pool")
    from google.protobuf import descriptor_pb2, message_factory

    said = descriptor_pb2.FileDescriptorSet.FromString(descriptor("robots", "Frame", "What it is."))
    (file,) = said.file
    assert (file.package, file.syntax) == ("robots", "proto3")
    assert file.source_code_info.location[0].leading_comments == "What it is."
    assert list(file.source_code_info.location[0].path) == [4, 0]
    known = pool.DescriptorPool()
    known.Add(file)
    kind = message_factory.GetMessageClass(known.FindMessageTypeByName("robots.Frame"))
    data = bytes(range(256)) * 5
    assert kind.FromString(prefix(len(data)) + data).data == data
