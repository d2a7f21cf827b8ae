"""A seeded fuzzer of amounts: valid files of every format in which something is stated or repeated far too often.

``damaged_files`` changes bytes and words; these files stay well-formed and grow instead, to a few megabytes at most:
numbers become huge, elements and lines are repeated, names are nested, chunks are copied.
"""

from __future__ import annotations

import io
import json
import re
import resource
import struct
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from tests.files.damaged_files import seeds
from tests.files.hostile_files import read
from tests.files.small_bombs import MEMORY, archive

MOST_BYTES = 4_000_000
_NUMBER = re.compile(rb"(?<![\w.])\d+(?![\w.])")
_HUGE = (b"100000", b"10000000", b"1000000000", b"4294967295", b"999999999999")
_ELEMENT = re.compile(rb"<(\w+)\b[^<>]*/>|<(\w+)\b[^<>]*>[^<>]*</\2>")
_NAME = re.compile(rb"(?m)^[ \t]*\[?\[?([A-Za-z_]+)")


def try_case(number):
    """Read the amplified file of that number within ``MEMORY``; the same number gives the same file."""
    name, (opener, ending, _) = list(seeds().items())[number % len(seeds())]
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / f"amplified{ending}"
        path.write_bytes(amplified(name, number))
        try:
            read(opener, str(path))
        finally:
            peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            assert peak < MEMORY, f"{peak / 1e6:.0f} MB"


def amplified(name, number):
    """The seed of that name with one or two of its amounts changed."""
    random = np.random.default_rng([number, 23])
    _, ending, data = seeds()[name]
    for _ in range(int(random.integers(1, 3))):
        if ending == ".glb":
            data = _in_glb(data, random)
        elif ending == ".gltf":
            data = json.dumps(_in_tree(json.loads(data), random)).encode()
        elif ending == ".npz":
            data = _in_archive(data, random)
        elif ending == ".mcap":
            data = _in_recording(data, random)
        elif b"\x00" in data[:400]:
            data = _count(data, random)
        else:
            data = _in_text(data, random)
    return data[: 2 * MOST_BYTES]


def _times(size, random):
    """A number of copies of so many bytes."""
    return max(1, min(int(10 ** random.uniform(1, 6)), MOST_BYTES // max(size, 1)))


def _pick(found, random):
    return found[int(random.integers(len(found)))]


def _in_text(data, random):
    way = int(random.integers(5))
    if way == 0 and (numbers := list(_NUMBER.finditer(data))):
        found = _pick(numbers, random)
        return data[: found.start()] + _pick(list(_HUGE), random) + data[found.end() :]
    if way == 1 and (elements := list(_ELEMENT.finditer(data))):
        found = _pick(elements, random)
        return data[: found.start()] + found[0] * _times(len(found[0]), random) + data[found.end() :]
    if way == 2 and (names := list(_NAME.finditer(data))):  # a dotted key of TOML, a long word of others
        found = _pick(names, random)
        long = b".".join([found[1]] * _times(len(found[1]) + 1, random))
        return data[: found.start(1)] + long + data[found.end(1) :]
    if way == 3:  # one line becomes wide
        lines = data.split(b"\n")
        at = int(random.integers(len(lines)))
        lines[at] = b" ".join([lines[at]] * _times(len(lines[at]) + 1, random))
        return b"\n".join(lines)
    lines = data.split(b"\n")
    at, end = sorted(int(place) for place in random.integers(0, len(lines) + 1, 2))
    block = lines[at : min(end, at + 8)] or lines[:1]
    lines[at:at] = block * _times(sum(map(len, block)) + len(block), random)
    return b"\n".join(lines)


def _count(data, random):
    """A count at the beginning of a binary file, or a number in its header, becomes huge."""
    header = data.find(b"end_header")
    if header > 0:
        return _in_text(data[:header], random) + data[header:]
    at = _pick([0, 4, 8, 12, 80], random)
    huge = struct.pack("<I", int(_pick([10**5, 10**7, 2**31 - 1, 2**32 - 1], random)))
    return data[:at] + huge + data[at + 4 :]


def _in_glb(data, random):
    (length,) = struct.unpack_from("<I", data, 12)
    text = json.dumps(_in_tree(json.loads(data[20 : 20 + length]), random)).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return head + text + rest


def _in_tree(tree, random):
    """A number of a JSON tree becomes huge, or the elements of a list are repeated."""
    places = [(None, None, tree)]
    for _, _, value in places:
        if isinstance(value, dict | list):
            places += [
                (value, key, inner) for key, inner in (value.items() if isinstance(value, dict) else enumerate(value))
            ]
    numbers = [place for place in places if type(place[2]) is int]
    lists = [place for place in places if isinstance(place[2], list) and place[2]]
    if lists and random.random() < 0.6:
        _, _, value = _pick(lists, random)
        value += value * _times(len(json.dumps(value)), random)
    elif numbers:
        holder, key, _ = _pick(numbers, random)
        holder[key] = int(_pick(list(_HUGE), random))
    return tree


def _in_archive(data, random):
    """An array states another shape or is followed by zeros, or an archive has many members."""
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        members = {name: packed.read(name) for name in packed.namelist()}
    name = _pick(list(members), random)
    way = int(random.integers(3))
    if way == 0:
        members |= {f"{name}{number}": b"" for number in range(min(_times(100, random), 20_000))}
    elif way == 1:
        members[name] = (
            _NUMBER.sub(lambda _: _pick(list(_HUGE), random), members[name][:128], count=2) + members[name][128:]
        )
    else:
        zeros = int(10 ** random.uniform(5, 7.5)) // 24 * 24
        shape = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({zeros // 24}, 3), }}".ljust(117) + "\n"
        members[name] = b"\x93NUMPY\x01\x00\x76\x00" + shape.encode() + bytes(zeros)
    return archive(members)


def _in_recording(data, random):
    """A record is repeated, or one of its numbers becomes huge."""
    at = 8
    records = []
    while at + 9 <= len(data) - 8:
        end = at + 9 + struct.unpack_from("<Q", data, at + 1)[0]
        records.append((at, end))
        at = end
    start, end = _pick(records, random)
    record = data[start:end]
    if random.random() < 0.6:
        return data[:start] + record * _times(len(record), random) + data[end:]
    place = start + 1 + 4 * int(random.integers(0, max(min(len(record), 80) // 4 - 1, 1)))
    huge = struct.pack("<I", int(_pick([10**5, 10**7, 2**31 - 1, 2**32 - 1], random)))
    return data[:place] + huge + data[place + 4 :]
