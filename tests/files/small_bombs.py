"""Small files that a decoder would expand to gigabytes or to minutes of work, made in code.

Each is read in a process with limits, see ``LIMITS``: it is refused by name, or read within them.
"""

from __future__ import annotations

import base64
import io
import json
import math
import resource
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from tactile_maps.recording.file import mcap_file
from tactile_maps.session.bundle import pack_scene
from tests.files.hostile_files import BODY, mjcf
from tests.support.touch import prepared_bar

CPU_SECONDS = 10.0
MEMORY = 2**30
"""Limits for any file of a few megabytes."""
_FLOAT = 5126
_SHORT = 5123
_BYTE = 5121
_QUAD = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes() + np.arange(3, dtype="<u2").tobytes()


def glb(tree, binary=_QUAD):
    """A GLB file of that JSON and binary chunk."""
    binary += b"\0" * (-len(binary) % 4)
    text = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(binary)}], **tree}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


_VIEWS = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}]
_ACCESSORS = [
    {"bufferView": 0, "componentType": _FLOAT, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": _SHORT, "count": 3, "type": "SCALAR"},
]
_PRIMITIVE = {"attributes": {"POSITION": 0}, "indices": 1}


def _triangle(**changes):
    """The JSON of one triangle, with changes."""
    return {
        "bufferViews": _VIEWS,
        "accessors": _ACCESSORS,
        "meshes": [{"primitives": [_PRIMITIVE]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        **changes,
    }


def _accessor(**changes):
    return glb(_triangle(accessors=[{**_ACCESSORS[0], **changes}, _ACCESSORS[1]]))


def _without_view(count):
    """An accessor without a view is all zeros."""
    return glb(_triangle(accessors=[{"componentType": _FLOAT, "count": count, "type": "VEC3"}, _ACCESSORS[1]]))


def _sparse(count):
    values = {"indices": {"bufferView": 1, "componentType": _SHORT}, "values": {"bufferView": 0}, "count": 3}
    accessor = {"componentType": _FLOAT, "count": count, "type": "VEC3", "sparse": values}
    return glb(_triangle(accessors=[accessor, _ACCESSORS[1]]))


def _overlapping(primitives, vertices):
    """Many primitives that share the same numbers: each becomes vertices of its own."""
    binary = np.random.default_rng(0).random((vertices, 3)).astype("<f4").tobytes()
    views = [{"buffer": 0, "byteLength": len(binary)}]
    accessors = [{"bufferView": 0, "componentType": _FLOAT, "count": vertices, "type": "VEC3"}]
    tree = _triangle(bufferViews=views, accessors=accessors)
    tree["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}] * primitives}]
    return glb(tree, binary)


def _instances(nodes, vertices):
    """Many nodes that show the same mesh."""
    binary = np.random.default_rng(0).random((vertices, 3)).astype("<f4").tobytes()
    views = [{"buffer": 0, "byteLength": len(binary)}]
    accessors = [{"bufferView": 0, "componentType": _FLOAT, "count": vertices, "type": "VEC3"}]
    tree = _triangle(bufferViews=views, accessors=accessors, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    return glb({**tree, "nodes": [{"mesh": 0}] * nodes, "scenes": [{"nodes": list(range(nodes))}]}, binary)


def _doubling(levels):
    """Each node has the next one twice."""
    nodes = [{"children": [number + 1, number + 1]} for number in range(levels)]
    return glb(_triangle(nodes=[*nodes, {"mesh": 0}]))


def _loop():
    return glb(_triangle(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]))


def _chain(nodes):
    chain = [{"children": [number + 1]} for number in range(nodes)]
    return glb(_triangle(nodes=[*chain, {"mesh": 0}]))


def _names(count):
    """Meshes and nodes that all have the same name."""
    return glb(
        _triangle(
            meshes=[{"name": "m", "primitives": [_PRIMITIVE]}] * count,
            nodes=[{"mesh": number, "name": "n"} for number in range(count)],
            scenes=[{"nodes": list(range(count))}],
        )
    )


def png(width, height):
    """A black picture."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    row = b"\0" * (1 + 3 * width)
    packer = zlib.compressobj(9)
    body = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def _textured(width, height, images):
    picture = png(width, height)
    binary = _QUAD + b"\0\0" + np.zeros((3, 2), "<f4").tobytes() + picture
    views = [
        *_VIEWS,
        {"buffer": 0, "byteOffset": 44, "byteLength": 24},
        {"buffer": 0, "byteOffset": 68, "byteLength": len(picture)},
    ]
    accessors = [*_ACCESSORS, {"bufferView": 2, "componentType": _FLOAT, "count": 3, "type": "VEC2"}]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}
    tree = _triangle(bufferViews=views, accessors=accessors, meshes=[{"primitives": [primitive]}])
    tree |= {
        "images": [{"bufferView": 3, "mimeType": "image/png"}] * images,
        "textures": [{"source": number} for number in range(images)],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    return glb(tree, binary)


def _embedded(tree):
    """A glTF whose buffer is in its text."""
    address = "data:application/octet-stream;base64," + base64.b64encode(_QUAD).decode()
    buffers = [{"byteLength": len(_QUAD), "uri": address}]
    return json.dumps({"asset": {"version": "2.0"}, **tree, "buffers": buffers}).encode()


def dae(body, *, library=""):
    """A COLLADA file with a triangle, library nodes and a scene."""
    source = (
        '<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>'
        '<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>'
        '<param name="Z" type="float"/></accessor></technique_common></source>'
    )
    mesh = (
        f'<geometry id="g"><mesh>{source}<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        '<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh>'
        "</geometry>"
    )
    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit meter="1"/></asset><library_geometries>{mesh}</library_geometries>'
        f'<library_nodes>{library}</library_nodes><library_visual_scenes><visual_scene id="s">{body}</visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    ).encode()


def _doubling_dae(levels):
    """Library nodes each of which shows the next one twice."""
    nodes = [f'<node id="n{levels}"><instance_geometry url="#g"/></node>']
    nodes += [
        f'<node id="n{n}"><instance_node url="#n{n + 1}"/><instance_node url="#n{n + 1}"/></node>'
        for n in reversed(range(levels))
    ]
    return dae('<node><instance_node url="#n0"/></node>', library="".join(nodes))


def npy(shape, body=b"", descr="<f8"):
    """An npy file that states a shape."""
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode() + body


def archive(members):
    """A zip of these."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return packed.getvalue()


def of_zeros(names, megabytes, head=b""):
    """A zip whose members are that many zeros after ``head``; they are not made in memory."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for name in names:
            with file.open(name, "w") as member:
                member.write(head)
                for _ in range(megabytes):
                    member.write(bytes(2**20))
    return packed.getvalue()


def _zeros(megabytes, members=1):
    return of_zeros([f"a{number}.npy" for number in range(members)], megabytes, npy((megabytes * 2**17,)))


def scene(extra, robot="arm"):
    """A scene file with more in it."""
    return f'robot = "{robot}"\n{extra}\n'.encode()


def recording(write, **attachments):
    """A recording of the bar whose messages ``write`` adds."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=2**24, compression=CompressionType.ZSTD, enable_data_crcs=True)
    channels = mcap_file.begin_recording(writer, {}, pack_scene(prepared_bar()) | attachments)
    write(writer, channels)
    writer.finish()
    return stream.getvalue()


def _many_messages(topic, data, count):
    def write(writer, channels):
        for number in range(count):
            writer.add_message(channels[topic], number, data, number, number)

    return recording(write)


def _head():
    """The beginning of a recording, up to its messages."""
    data = recording(lambda _writer, _channels: None)
    at = len(b"\x89MCAP0\r\n")
    last = 0
    while data[at] != Opcode.DATA_END:
        (length,) = struct.unpack_from("<Q", data, at + 1)
        at += 9 + length
        last = at
    return data[:last]


def record(opcode, body):
    """Return an MCAP record."""
    return struct.pack("<BQ", opcode, len(body)) + body


def chunk(plain, packed=None, *, size=None, kind=b"zstd"):
    """A chunk record of these records."""
    packed = zstandard.compress(plain) if packed is None else packed
    stated = len(plain) if size is None else size
    head = struct.pack("<QQQI", 0, 0, stated, zlib.crc32(plain)) + struct.pack("<I", len(kind)) + kind
    return record(Opcode.CHUNK, head + struct.pack("<Q", len(packed)) + packed)


def _endless(megabytes):
    """Zeros, packed without their number."""
    packer = zstandard.ZstdCompressor(write_content_size=False).compressobj()
    return b"".join(packer.compress(bytes(2**20)) for _ in range(megabytes)) + packer.flush()


def message(channel, data, number=0):
    """Return a message record."""
    return record(Opcode.MESSAGE, struct.pack("<HIQQ", channel, number, 0, 0) + data)


def indexed(head, body, offsets):
    """A recording whose index lists chunks at these offsets."""
    entries = b"".join(
        record(Opcode.CHUNK_INDEX, struct.pack("<QQQQIQIQQ", 0, 0, offset, 9, 0, 0, 0, 0, 0)) for offset in offsets
    )
    start = len(head) + len(body)
    footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, 0)
    return head + body + entries + footer + struct.pack("<I", zlib.crc32(entries + footer)) + b"\x89MCAP0\r\n"


def broken_records(count):
    """Records of an impossible length, each with an entry in the index, so that reading continues at the next one."""
    head = _head()
    broken = struct.pack("<BQ", Opcode.CHUNK, 2**60)
    return indexed(head, broken * count, [len(head) + 9 * number for number in range(count)])


def _bad_chunks_between_frames(count):
    """Frames with gaps, and unreadable chunks between them."""
    frame = _frame()
    spoilt = record(Opcode.CHUNK, b"")
    parts = []
    for number in range(count):
        tick = struct.pack("<q", 2 * number)
        parts.append(chunk(message(1, frame[:5] + tick + frame[13:], 3 * number)) + spoilt)
    return _head() + b"".join(parts)


def _frame():
    from tactile_maps.recording.encoding.frame_codec import encode_frame
    from tactile_maps.session.session import Session

    return encode_frame(Session(prepared_bar()).tick())


def xacro(body):
    """A xacro document."""
    return f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>'.encode()


def _doubling_macros(levels):
    macros = [f'<xacro:macro name="m{levels}" params=""><link name="l"/></xacro:macro>']
    macros += [
        f'<xacro:macro name="m{n}" params=""><xacro:m{n + 1}/><xacro:m{n + 1}/></xacro:macro>' for n in range(levels)
    ]
    return xacro("".join(macros) + "<xacro:m0/>")


def _taxels(count):
    points = np.random.default_rng(0).random((count, 3))
    points[:, 2] = 0.0
    rows = "\n".join(f"{x:.4f},{y:.4f},{z:.4f},0,0,1" for x, y, z in points)
    return f"x,y,z,nx,ny,nz\n{rows}\n".encode()


def _tube_of_taxels(count):
    number = np.arange(count)
    angle = 2 * np.pi * (0.618034 * number % 1)
    columns = [0.05 * np.cos(angle), 0.05 * np.sin(angle), number / count, np.cos(angle), np.sin(angle), 0 * angle]
    rows = "\n".join(",".join(f"{value:.6f}" for value in row) for row in np.stack(columns, axis=1).tolist())
    return f"x,y,z,nx,ny,nz\n{rows}\n".encode()


def _ring(count):
    """Points on a circle and two on its axis: MuJoCo takes half a minute for the convex hull of 50,000."""
    angles = (2 * np.pi * np.arange(count) / count).tolist()
    ring = [(0.05 * math.cos(angle), 0.05 * math.sin(angle), 0.025) for angle in angles]
    return [(0.0, 0.0, 0.0), (0.0, 0.0, 0.05), *ring]


def _fan(count):
    """An OBJ file whose faces all share one edge."""
    vertices = "".join(f"v {x:.12f} {y:.12f} {z:.12f}\n" for x, y, z in _ring(count))
    return (vertices + "".join(f"f 1 2 {number + 3}\n" for number in range(count))).encode()


Bomb = tuple[str, str, Callable[[], bytes]]
"""Reader of ``hostile_files.OPENERS``, ending, and what makes the file."""
BOMBS = {
    "glb count": ("mesh", ".glb", lambda: _accessor(count=10**9)),
    "glb count without view": ("mesh", ".glb", lambda: _without_view(10**9)),
    "glb some count without view": ("mesh", ".glb", lambda: _without_view(100_000_000)),
    "glb negative count": ("mesh", ".glb", lambda: _accessor(count=-1)),
    "glb sparse": ("mesh", ".glb", lambda: _sparse(300_000_000)),
    "glb overlapping": ("mesh", ".glb", lambda: _overlapping(2000, 100_000)),
    "glb instances": ("mesh", ".glb", lambda: _instances(5000, 99_999)),
    "glb many instances": ("mesh", ".glb", lambda: _instances(100_000, 3)),
    "glb doubling": ("mesh", ".glb", lambda: _doubling(24)),
    "glb loop": ("mesh", ".glb", _loop),
    "glb chain": ("mesh", ".glb", lambda: _chain(20_000)),
    "glb names": ("mesh", ".glb", lambda: _names(20_000)),
    "glb texture": ("mesh", ".glb", lambda: _textured(12_000, 12_000, 1)),
    "glb textures": ("mesh", ".glb", lambda: _textured(4_000, 4_000, 100)),
    "gltf count without view": (
        "mesh",
        ".gltf",
        lambda: _embedded(
            _triangle(accessors=[{"componentType": _FLOAT, "count": 10**9, "type": "VEC3"}, _ACCESSORS[1]])
        ),
    ),
    "glb numbers in text": ("mesh", ".glb", lambda: glb(_triangle(extras=[[]] * 2_000_000))),
    "obj groups": (
        "mesh",
        ".obj",
        lambda: (
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"".join(b"o o%d\nusemtl m%d\nf 1 2 3\n" % (n, n) for n in range(60_000))
        ),
    ),
    "obj same groups": ("mesh", ".obj", lambda: b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"o a\nusemtl a\nf 1 2 3\n" * 100_000),
    "obj polygon": ("mesh", ".obj", lambda: b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + b"1 2 3 " * 500_000),
    "obj polygons": (
        "mesh",
        ".obj",
        lambda: (
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"".join(b"f " + b"1 2 3 " * (n % 50 + 1) + b"\n" for n in range(30_000))
        ),
    ),
    "obj shared": (
        "mesh",
        ".obj",
        lambda: (
            b"".join(b"v %d 0 0\n" % n for n in range(100_000))
            + b"".join(b"usemtl m%d\nf 1 %d 3\n" % (n, n + 4) for n in range(50_000))
        ),
    ),
    "obj lines": ("mesh", ".obj", lambda: b"v 0 0 0\n" * 10 + b"l 1 2\n" * 500_000),
    "obj edge fan": ("robot", ".obj", lambda: _fan(50_000)),
    "stl zeros": ("mesh", ".stl", lambda: bytes(8_000_000)),
    "stl count": ("mesh", ".stl", lambda: bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50)),
    "stl text": ("mesh", ".stl", lambda: b"solid a\n" + b"facet normal 0 0 1\n" * 200_000),
    "stl solids": (
        "mesh",
        ".stl",
        lambda: (
            b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
            b"vertex 0 1 0\nendloop\nendfacet\nendsolid a\n" * 30_000
        ),
    ),
    "ply count": (
        "mesh",
        ".ply",
        lambda: (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty "
            b"float x\nproperty float y\nproperty float z\nelement face 1000000000\nproperty list uchar int "
            b"vertex_indices\nend_header\n" + bytes(100)
        ),
    ),
    "ply list": (
        "mesh",
        ".ply",
        lambda: (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
            b"property float y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
            + bytes(36)
            + struct.pack("<I", 2**32 - 1)
            + bytes(100)
        ),
    ),
    "ply text": (
        "mesh",
        ".ply",
        lambda: (
            b"ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\n"
            b"property float y\nproperty float z\nelement face 1000000000\nproperty list uchar int vertex_indices\n"
            b"end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        ),
    ),
    "ply elements": (
        "mesh",
        ".ply",
        lambda: (
            b"ply\nformat ascii 1.0\n"
            + b"".join(b"element e%d 0\nproperty float x\n" % n for n in range(50_000))
            + b"end_header\n"
        ),
    ),
    "ply empty rows": (
        "mesh",
        ".ply",
        lambda: b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nend_header\n",
    ),
    "off count": ("mesh", ".off", lambda: b"OFF\n1000000000 1000000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "off polygon": ("mesh", ".off", lambda: b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000000 0 1 2\n"),
    "off wide": ("mesh", ".off", lambda: b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000" + b" 0 1 2" * 333_334),
    "dae doubling": ("mesh", ".dae", lambda: _doubling_dae(24)),
    "dae instances": ("mesh", ".dae", lambda: dae('<node><instance_geometry url="#g"/></node>' * 50_000)),
    "dae loop": (
        "mesh",
        ".dae",
        lambda: dae(
            '<node><instance_node url="#a"/></node>',
            library='<node id="a"><instance_node url="#b"/></node><node id="b"><instance_node url="#a"/></node>',
        ),
    ),
    "dae count": (
        "mesh",
        ".dae",
        lambda: dae('<node><instance_geometry url="#g"/></node>').replace(b'count="', b'count="1000000000'),
    ),
    "msh count": ("mesh", ".msh", lambda: struct.pack("<4i", 2**31 - 1, 0, 0, 2**31 - 1) + bytes(100)),
    "toml dots": ("scene", ".toml", lambda: scene(".".join("a" * 400_000) + " = 1")),
    "toml header dots": ("scene", ".toml", lambda: scene("[" + ".".join("a" * 400_000) + "]")),
    "toml many dots": (
        "scene",
        ".toml",
        lambda: scene("\n".join(".".join("a" * 90) + f".b{n} = 1" for n in range(4_000))),
    ),
    "toml keys below": (
        "scene",
        ".toml",
        lambda: scene("\n".join(f"[{'.'.join('a' * 400)}.b{n}]" for n in range(1_000))),
    ),
    "toml lists": ("scene", ".toml", lambda: scene("a = " + "[" * 300_000 + "]" * 300_000)),
    "toml tables": ("scene", ".toml", lambda: scene("a = " + "{a=" * 200_000 + "1" + "}" * 200_000)),
    "toml arrays of tables": ("scene", ".toml", lambda: scene("[[objects]]\n" * 80_000)),
    "toml stimuli": ("stimuli", ".toml", lambda: b'[[stimuli]]\nkind = "tap"\n' * 300_000),
    "toml stimuli dots": ("stimuli", ".toml", lambda: (".".join("a" * 4_000_000) + " = 1").encode()),
    "scene objects": (
        "checked scene",
        ".toml",
        lambda: scene(
            "".join(
                f'[[objects]]\nname = "o{n}"\nkind = "box"\nsize = [0.1, 0.1, 0.1]\nat = [1.0, 0.0, {n % 900}.0]\n'
                for n in range(10_000)
            )
        ),
    ),
    "json deep": ("taxels", ".json", lambda: b"[" * 4_000_000),
    "json digits": ("taxels", ".json", lambda: b'{"a": ' + b"9" * 4_000_000 + b"}"),
    "json wide": ("taxels", ".json", lambda: b"[" + b"[]," * 1_300_000 + b"[]]"),
    "json keys": ("taxels", ".json", lambda: b"{" + b",".join(b'"%d":{}' % n for n in range(400_000)) + b"}"),
    "csv wide": ("taxels", ".csv", lambda: b"x,y,z," + b"a," * 2_000_000 + b"b\n0,0,0\n"),
    "csv wide rows": ("taxels", ".csv", lambda: b"x,y,z\n" + b"0," * 2_500_000 + b"0\n"),
    "csv rows": ("taxels", ".csv", lambda: b"x,y,z\n" + b"0,0,0\n" * 900_000),
    "csv links": (
        "taxels",
        ".csv",
        lambda: b"x,y,z,link\n" + b"".join(b"%d,0,0,l%d\n" % (n, n) for n in range(99_000)),
    ),
    "csv quotes": ("taxels", ".csv", lambda: b'x,y,z\n"' + b"a" * 5_000_000),
    "taxels": ("taxels", ".csv", lambda: _taxels(99_000)),
    "skin of taxels": ("any skin", ".csv", lambda: _taxels(99_000)),
    "skin of a tube of taxels": ("any skin", ".csv", lambda: _tube_of_taxels(99_000)),
    "taxels on one place": ("any skin", ".csv", lambda: b"x,y,z,nx,ny,nz\n" + b"0,0,0,0,0,1\n" * 99_000),
    "npz zeros": ("any skin", ".npz", lambda: _zeros(900)),
    "npz many zeros": ("map", ".npz", lambda: _zeros(100, 10)),
    "npz taxels": ("taxels", ".npz", lambda: of_zeros(["positions.npy"], 480, npy((20 * 2**20, 3)))),
    "npz rows": ("taxels", ".npz", lambda: of_zeros(["positions.npy"], 288, npy((12 * 2**20, 3)))),
    "npz rows of a skin": ("skin", ".npz", lambda: of_zeros(["0_positions.npy"], 288, npy((12 * 2**20, 3)))),
    "npz shape": ("skin", ".npz", lambda: archive({"a.npy": npy((10**15,))})),
    "npz empty rows": ("taxels", ".npz", lambda: archive({"positions.npy": npy((10**15, 0))})),
    "npz members": ("skin", ".npz", lambda: archive({f"{n}.npy": npy((0,)) for n in range(9_999)})),
    "xml elements": ("robot", ".urdf", lambda: b'<robot name="r">' + b"<a/>" * 1_200_000 + b"</robot>"),
    "xml attributes": (
        "robot",
        ".urdf",
        lambda: b"<robot " + b" ".join(b'a%d="1"' % n for n in range(300_000)) + b"/>",
    ),
    "xml deep": ("robot", ".xml", lambda: b"<a>" * 1_000_000),
    "xml comments": ("robot", ".urdf", lambda: b'<robot name="r">' + b"<!--" * 1_000_000),
    "urdf meshes": (
        "robot",
        ".urdf",
        lambda: (
            '<robot name="r"><link name="a">'
            + "".join(f'<visual><geometry><mesh filename="m{n}.stl"/></geometry></visual>' for n in range(4_900))
            + "</link></robot>"
        ).encode(),
    ),
    "urdf scaled meshes": (
        "robot",
        ".urdf",
        lambda: (
            '<robot name="r"><link name="a">'
            + "".join(
                f'<visual><geometry><mesh filename="m.stl" scale="1 1 {n + 1}"/></geometry></visual>'
                for n in range(4_900)
            )
            + "</link></robot>"
        ).encode(),
    ),
    "mjcf mesh names": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY, "<asset>" + "".join(f'<mesh name="m{n}" file="m.stl"/>' for n in range(90_000)) + "</asset>"
        ).encode(),
    ),
    "mjcf other meshes": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY, "<asset>" + "".join(f'<mesh name="m{n}" file="m{n}.stl"/>' for n in range(90_000)) + "</asset>"
        ).encode(),
    ),
    "mjcf vertices": (
        "robot",
        ".xml",
        lambda: mjcf(
            '<body><joint/><geom type="mesh" mesh="m"/></body>',
            '<asset><mesh name="m" vertex="' + "0.1 0.7 0.3 " * 400_000 + '"/></asset>',
        ).encode(),
    ),
    "mjcf defaults": (
        "robot",
        ".xml",
        lambda: mjcf(BODY, "<default>" + '<default class="a">' * 150 + "</default>" * 150 + "</default>").encode(),
    ),
    "mjcf nested classes": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY,
            "<default>"
            + "".join(f'<default class="a{n}"><geom size="1"/>' for n in range(150))
            + "</default>" * 150
            + "</default>",
        ).encode(),
    ),
    "mjcf classes": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY,
            "<default>"
            + "".join(f'<default class="a{n}"><geom size="1"/></default>' for n in range(60_000))
            + "</default>",
        ).encode(),
    ),
    "mjcf 4900 classes": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY,
            "<default>"
            + "".join(f'<default class="a{n}"><geom size="1"/></default>' for n in range(4_900))
            + "</default>",
        ).encode(),
    ),
    "mjcf 499 classes": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY,
            "<default>"
            + "".join(f'<default class="a{n}"><geom size="1"/></default>' for n in range(499))
            + "</default>",
        ).encode(),
    ),
    "mjcf sites of a link": (
        "robot",
        ".xml",
        lambda: mjcf(BODY.replace("</body>", '<site pos="0 0 0.05"/>' * 49_000 + "</body>")).encode(),
    ),
    "mjcf sites with sensors": (
        "robot",
        ".xml",
        lambda: (
            mjcf(BODY.replace("</body>", "".join(f'<site name="s{n}"/>' for n in range(20_000)) + "</body>"))
            .replace(
                "</mujoco>", "<sensor>" + "".join(f'<touch site="s{n}"/>' for n in range(20_000)) + "</sensor></mujoco>"
            )
            .encode()
        ),
    ),
    "mjcf lights and keys": (
        "robot",
        ".xml",
        lambda: (
            mjcf(BODY + "<light/>" * 20_000)
            .replace("</mujoco>", "<keyframe>" + "<key/>" * 20_000 + "</keyframe></mujoco>")
            .encode()
        ),
    ),
    "mjcf scenery": (
        "robot",
        ".xml",
        lambda: mjcf(BODY + '<geom size="1"/>' * 2_400 + "<frame>" + '<geom size="1"/>' * 2_400 + "</frame>").encode(),
    ),
    "mjcf uses of a mesh": (
        "robot",
        ".xml",
        lambda: mjcf(
            '<body><joint/><inertial pos="0 0 0" mass="1" '
            'diaginertia="1 1 1"/>' + '<geom type="mesh" mesh="m" contype="0" conaffinity="0"/>' * 4_900 + "</body>",
            '<asset><mesh name="m" builtin="sphere" params="4"/></asset>',
        ).encode(),
    ),
    "mjcf ring of vertices": (
        "robot",
        ".xml",
        lambda: mjcf(
            '<body><joint/><geom type="mesh" mesh="m"/></body>',
            '<asset><mesh name="m" vertex="'
            + " ".join(f"{x:.12f} {y:.12f} {z:.12f}" for x, y, z in _ring(50_000))
            + '"/></asset>',
        ).encode(),
    ),
    "mjcf sites": ("robot", ".xml", lambda: mjcf(BODY + "<site/>" * 190_000).encode()),
    "mjcf copies of a mesh": (
        "robot",
        ".xml",
        lambda: mjcf(
            '<replicate count="4000"><body><joint/><geom type="mesh" mesh="m"/></body></replicate>',
            '<asset><mesh name="m" builtin="sphere" params="4"/></asset>',
        ).encode(),
    ),
    "mjcf materials": (
        "robot",
        ".xml",
        lambda: mjcf(
            BODY, "<asset>" + "".join(f'<material name="m{n}"/>' for n in range(90_000)) + "</asset>"
        ).encode(),
    ),
    "mjcf exclusions": (
        "robot",
        ".xml",
        lambda: (
            mjcf('<body name="a"><joint/><geom size="1"/></body>')
            .replace("</mujoco>", "<contact>" + '<exclude body1="a" body2="a"/>' * 150_000 + "</contact></mujoco>")
            .encode()
        ),
    ),
    "mjcf grid of touch": (
        "taxels",
        ".xml",
        lambda: (
            mjcf('<body name="a"><joint/><geom size="0.1"/><site name="s"/></body>')
            .replace(
                "</mujoco>",
                '<extension><plugin plugin="mujoco.sensor.touch_grid"><instance name="i"><config key="size" '
                'value="100000 100000"/></instance></plugin></extension><sensor><plugin name="t" plugin='
                '"mujoco.sensor.touch_grid" objtype="site" objname="s"><config key="size" '
                'value="100000 100000"/></plugin></sensor></mujoco>',
            )
            .encode()
        ),
    ),
    "xacro doubling": ("robot", ".xacro", lambda: _doubling_macros(24)),
    "xacro loop": (
        "robot",
        ".xacro",
        lambda: xacro('<xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/>'),
    ),
    "xacro power": ("robot", ".xacro", lambda: xacro('<link name="${9**9**9}"/>')),
    "xacro text": ("robot", ".xacro", lambda: xacro("<link name=\"${'a'*10**10}\"/>")),
    "xacro properties": (
        "robot",
        ".xacro",
        lambda: xacro(
            '<xacro:property name="p0" value="aaaaaaaaaa"/>'
            + "".join(f'<xacro:property name="p{n + 1}" value="{f"${{p{n}}}" * 10}"/>' for n in range(12))
            + '<link name="${p12}"/>'
        ),
    ),
    "xacro brackets": ("robot", ".xacro", lambda: xacro('<link name="${' + "(" * 300_000 + ')"/>')),
    "mcap broken records": ("recording", ".mcap", lambda: broken_records(60_000)),
    "mcap bad chunks between frames": ("recording", ".mcap", lambda: _bad_chunks_between_frames(6_000)),
    "mcap messages": ("recording", ".mcap", lambda: _head() + chunk(message(9, b"") * 3_000_000)),
    "mcap chunks of messages": ("recording", ".mcap", lambda: _head() + chunk(message(9, b"") * 150_000) * 200),
    "mcap zeros": ("recording", ".mcap", lambda: _head() + chunk(message(9, bytes(100_000_000))) * 400),
    "mcap unstated zeros": ("recording", ".mcap", lambda: _head() + chunk(b"", _endless(2_000), size=100)),
    "mcap stated size": ("recording", ".mcap", lambda: _head() + chunk(message(9, b""), size=2**62)),
    "mcap frames": ("recording", ".mcap", lambda: _many_messages("/frame", _frame(), 100_000)),
    "mcap marks": ("recording", ".mcap", lambda: _many_messages("/mark", b'{"tick":1,"name":"a"}', 100_000)),
    "mcap attachments": ("recording", ".mcap", lambda: _head() + record(Opcode.ATTACHMENT, bytes(36)) * 100_000),
    "mcap metadata": ("recording", ".mcap", lambda: _head() + record(Opcode.METADATA, struct.pack("<I", 2**32 - 1))),
    "mcap robot": (
        "recording",
        ".mcap",
        lambda: recording(lambda _w, _c: None, **{"robot.zip": of_zeros(["robot.xml"], 460)}),
    ),
    "mcap map": ("recording", ".mcap", lambda: recording(lambda _w, _c: None, **{"map.npz": _zeros(900)})),
}


LONG = frozenset(
    name
    for name in BOMBS
    if name.startswith(("taxels", "skin of", "npz", "mcap", "mjcf", "urdf", "xml", "xacro", "csv", "json"))
    or name
    in (
        "glb texture",
        "obj polygon",
        "obj polygons",
        "glb numbers in text",
        "toml arrays of tables",
        "obj edge fan",
        "scene objects",
        "glb chain",
        "dae instances",
        "obj same groups",
    )
) - {"xml comments", "csv wide", "npz shape"}
"""Files that take more than half a second to make or to read; the others are part of the default tests."""


def read_bomb(name):
    """Make the file of that name and read it."""
    from tests.files.hostile_files import read

    opener, ending, make = BOMBS[name]
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / f"small{ending}"
        path.write_bytes(make())
        assert path.stat().st_size < 9_000_000
        try:
            read(opener, str(path))
        finally:
            peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            assert peak < MEMORY, f"{peak / 1e6:.0f} MB"
