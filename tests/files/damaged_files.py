"""Damaged files: valid ones of every format, as our own writers make them, changed at random in bytes or in words.

Archives are also changed inside and closed again, so that the damage is not stopped by a checksum.
"""

from __future__ import annotations

import io
import json
import os
import re
import tempfile
import zipfile
from base64 import b64encode
from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from mcap.writer import CompressionType, Writer

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import save_document
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.maps.formats.obj import write_map_obj
from tactile_maps.recording.encoding.message_codecs import TOPICS
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.player import open_recording
from tactile_maps.recording.recorder import Recorder
from tactile_maps.robots.files.mesh_files import to_msh
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.scene.scene_file import load_scene, scene_to_toml
from tactile_maps.session import bundle
from tactile_maps.session.session import Session
from tactile_maps.skin.formats.taxel_files import WRITTEN_ENDINGS, write_taxels
from tactile_maps.skin.model.skin_file import save_skin
from tactile_maps.stimuli.stimulus_file import save_stimuli
from tactile_maps.stimuli.stimulus_kinds import FingerPath, Poke, Roll, Stroke, Tap
from tactile_maps.tactile.poke import PokePressed, PokeReleased
from tests.files.hostile_files import BODY, mjcf, read, urdf_chain
from tests.support.example_taxels import dome, strip, write_icub_layout
from tests.support.surfaces import frustum, sheet, skin_of
from tests.support.touch import prepared_bar

NUMBERS = (
    b"0",
    b"-1",
    b"1e999",
    b"-1e300",
    b"1e-320",
    b"nan",
    b"inf",
    b"9223372036854775808",
    b"4294967295",
    b"2.5",
    b"true",
    b"null",
    b'""',
    b"[]",
    b"{}",
    b"1" * 400,
    b"[" * 300,
    b"\xff",
    b"\x00",
    b"1,5",
    b"0x10",
    b"..",
    b"/etc/passwd",
)
"""Replacements of words."""
PLAIN = (
    b"0",
    b"-1",
    b"1",
    b"2",
    b"3",
    b"7",
    b"0.5",
    b"-0.0",
    b"1e999",
    b"-1e300",
    b"1e300",
    b"1e9",
    b"nan",
    b"inf",
    b"-inf",
    b"9223372036854775808",
    b"4294967295",
    b"1000000",
    b"100000000",
    b"2.5",
    b"true",
    b"null",
    b"x",
    b"world",
)
"""The same, where the text is to stay what it is."""
_BINARY = (
    *(np.array(value, "<f8").tobytes() for value in (np.nan, np.inf, 1e300, -1.0, 0.0, 1e-320)),
    *(np.array(value, "<f4").tobytes() for value in (np.nan, np.inf, 1e30, -1.0)),
    *(np.array(value, "<i4").tobytes() for value in (0, 1, -1, 2**31 - 1, 2**24, 1000)),
    *(np.array(value, "<i8").tobytes() for value in (0, 1, -1, 2**62, 10**9)),
)
_WORDS = re.compile(rb"[\w.+-]+|\s+|[^\w\s]")


@cache
def seeds():
    """Reader, ending and bytes of valid files, by name."""
    found = {}
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as made:
        folder = Path(made)

        def add(name, opener, ending, write):
            path = folder / f"seed{len(found)}{ending}"
            write(path)
            found[name] = (opener, ending, path.read_bytes())

        map_ = build_map(skin_of(sheet(6, 5), frustum(around=12, along=5), taxels=12))
        add("map", "map", ".npz", lambda path: save_map(map_, path))
        add("document", "document", ".npz", lambda path: save_document(MapDocument.of(map_), path))
        add("skin", "skin", ".npz", lambda path: save_skin(map_.skin, path))
        add("uv", "uv", ".obj", lambda path: write_map_obj(map_, path))
        for ending in WRITTEN_ENDINGS:
            add(f"taxels{ending}", "taxels", ending, lambda path: write_taxels(dome(), path))
        add("skin of taxels", "any skin", ".csv", lambda path: write_taxels(dome(), path))
        add("layout", "icub layout", ".ini", lambda path: write_icub_layout(strip()[1], path))
        script = (
            Poke(),
            Stroke(),
            Tap(taps=2),
            Roll(),
            FingerPath(points=((0.0, 0.1, 0.2, 0.3), (1.5, 0.1, 0.2, 0.2))),
        )
        add("stimuli", "stimuli", ".toml", lambda path: save_stimuli(script, path))
        add("scene", "scene", ".toml", lambda path: path.write_text(scene_to_toml(load_scene("full")), encoding="utf8"))
        add("urdf", "robot", ".urdf", lambda path: path.write_text(urdf_chain(3)))
        limb = '<body name="b" pos="0 0 1"><joint name="j" range="-1 1"/><geom type="mesh" mesh="m"/></body>'
        assets = '<compiler angle="radian"/><asset><mesh name="m" builtin="sphere" params="1"/></asset>'
        copies = f'<replicate count="2" offset="1 0 0">{BODY}</replicate>'
        add("mjcf", "robot", ".xml", lambda path: path.write_text(mjcf(limb + copies, assets)))
        box = trimesh.creation.icosphere(1)
        for ending in (".obj", ".stl", ".ply", ".off", ".gltf", ".glb", ".dae"):
            made_of = box.export(file_type=ending[1:])
            if isinstance(made_of, dict):  # of several files: one that holds the others
                made_of = _embedded(made_of)
            data = made_of.encode() if isinstance(made_of, str) else made_of
            add(f"mesh{ending}", "mesh", ending, lambda path, data=data: path.write_bytes(data))
        add("mesh.msh", "mesh", ".msh", lambda path: path.write_bytes(to_msh(Mesh(box.vertices, box.faces))))
        add("robot of a mesh", "robot", ".stl", lambda path: path.write_bytes(box.export(file_type="stl")))
        add("recording", "recording", ".mcap", _record)
        add("robot of a recording", "recording", ".mcap", _record)
    return found


def _embedded(files):
    """A glTF whose buffers are in its text."""
    text = json.loads(files["model.gltf"])
    for buffer in text["buffers"]:
        buffer["uri"] = "data:application/octet-stream;base64," + b64encode(files[buffer["uri"]]).decode()
    return json.dumps(text)


def _record(path):
    prepared = prepared_bar()
    session = Session(prepared)
    with Recorder(prepared, path) as recorder:
        session.submit(PokePressed(1, prepared.skin.taxel_point(0)))
        for tick in range(12):
            if tick == 8:
                session.submit(PokeReleased(1))
            recorder.write(session.tick(), session.inputs)


def try_case(number):
    """Read the damaged file of that number; the same number gives the same file."""
    name, (opener, ending, _) = list(seeds().items())[number % len(seeds())]
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / f"damaged{ending}"
        path.write_bytes(damaged(name, number))
        result = read(opener, str(path))
        if opener == "taxels":
            assert all(np.isfinite(taxels.positions).all() for taxels in result)
        if opener == "recording":  # reading it looks at its frames' headers alone
            player = open_recording(path)
            list(player)
            compile_spec(robot_spec(player.prepared.robot), source=str(path))


def misbehave(way):
    """Exceed a limit in some way."""
    if way == "hang":
        while True:
            pass
    if way == "grow":
        np.ones(2**29)
    if way == "leak":
        os.open("/dev/null", os.O_RDONLY)
    if way == "crash":
        os.abort()
    if way == "fail":
        raise KeyError(way)
    if way == "refuse":
        raise TactileMapsError(way)


def damaged(name, number):
    """The seed of that name, changed in one of the ways that fit it."""
    random = np.random.default_rng([number, 17])
    _, ending, data = seeds()[name]
    if ending in (".npz", ".mcap") and random.random() < 0.8:
        return _inside_zip(data, random) if ending == ".npz" else _inside_recording(name, data, random)
    return _changed(data, random)


def _changed(data, random):
    """Text mostly in its values, so that it stays of its format; anything else mostly without changing its length."""
    text = b"\x00" not in data[:400]
    gentle, coarse = (_value, _words) if text else (_overwritten, _bytes)
    way = random.random()
    for _ in range(int(random.integers(1, 4))):
        data = (gentle if way < 0.7 else coarse if way < 0.9 else _bytes)(data, random)
    return data


def _value(data, random):
    """Replace a word or a number, or repeat, move or remove a line."""
    if random.random() < 0.2:
        lines = data.split(b"\n")
        at, other = (int(place) for place in random.integers(0, len(lines), 2))
        lines[at:at] = lines[other : other + 1] * int(random.integers(0, 3))
        del lines[other]
        return b"\n".join(lines)
    words = _WORDS.findall(data)
    places = [place for place, word in enumerate(words) if word[:1].isalnum() or word[:1] in b"-."]
    if random.random() < 0.7:
        places = [place for place in places if words[place][-1:].isdigit()] or places
    if not places:
        return data
    at, other = (places[int(place)] for place in random.integers(0, len(places), 2))
    words[at] = words[other] if random.random() < 0.3 else PLAIN[int(random.integers(len(PLAIN)))]
    return b"".join(words)


def _overwritten(data, random):
    """Replace an aligned number by an unlikely one."""
    value = _BINARY[int(random.integers(len(_BINARY)))]
    at = 4 * int(random.integers(0, max(len(data) // 4, 1)))
    return (data[:at] + value + data[at + len(value) :])[: len(data)]


def _bytes(data, random):
    at, end = sorted(int(place) for place in random.integers(0, len(data) + 1, 2))
    end = min(end, at + int(random.integers(1, 60)))
    filled = random.choice([b"\x00", b"\xff", b"\x7f"])
    ways = (
        lambda: data[:at],
        lambda: data[:at] + data[end:],
        lambda: data[:end] + data[at:],
        lambda: data[:at] + random.bytes(end - at) + data[end:],
        lambda: data[:at] + filled * (end - at) + data[end:],
        lambda: data[:at] + random.bytes(1) + data[at + 1 :],
    )
    return ways[int(random.integers(len(ways)))]()


def _words(data, random):
    words = _WORDS.findall(data)
    if not words:
        return data
    at, other = (int(place) for place in random.integers(0, len(words), 2))
    way = int(random.integers(5))
    if way == 0:
        words[at] = NUMBERS[int(random.integers(len(NUMBERS)))]
    elif way == 1:
        words[at], words[other] = words[other], words[at]
    elif way == 2:
        del words[at : at + int(random.integers(1, 9))]
    elif way == 3:
        words[at:at] = words[other : other + int(random.integers(1, 30))] * int(random.integers(1, 20))
    else:
        numbers = [place for place, word in enumerate(words) if word[:1].isdigit()] or [at]
        words[numbers[int(random.integers(len(numbers)))]] = NUMBERS[int(random.integers(len(NUMBERS)))]
    return b"".join(words)


def _inside_zip(data, random):
    """The archive with one member changed and every checksum right."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = list(members)[int(random.integers(len(members)))]
    kind = int(random.integers(6))
    if kind == 0:
        del members[name]
    elif name.startswith("header") and name.endswith(".npy") and kind > 1:  # our header, which is text in an array
        text = _changed(members[name][128:], random)
        shape = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({len(text)},), }}".ljust(117) + "\n"
        members[name] = b"\x93NUMPY\x01\x00\x76\x00" + shape.encode() + text
    elif name.endswith(".npy") and kind > 2:  # its numbers, not its form
        members[name] = members[name][:128] + _overwritten(members[name][128:], random)
    else:
        members[name] = _changed(members[name], random)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return packed.getvalue()


def _inside_recording(name, data, random):
    """The recording with one attachment or message changed and every checksum right."""
    with tempfile.NamedTemporaryFile(suffix=".mcap") as file:
        file.write(data)
        file.flush()
        contents = mcap_file.read_recording(file.name)
        read = [pair for messages in contents.all_messages() for pair in messages or ()]
    attachments = dict(contents.attachments)
    messages = [(topic, message) for topic, message in read if topic in TOPICS]  # of others nothing is ever read
    robot = name == "robot of a recording"
    if robot or random.random() < 0.6:
        name = bundle.ROBOT if robot else list(attachments)[int(random.integers(len(attachments)))]
        change = _inside_zip if attachments[name].startswith(b"PK") else _changed
        attachments[name] = change(attachments[name], random)
        spoilt = -1
    else:
        spoilt = int(random.integers(len(messages)))
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE)
    metadata = {key: value for key, value in contents.metadata.items() if key != "format"}
    channels = mcap_file.begin_recording(writer, metadata, attachments)
    for number, (topic, message) in enumerate(messages):
        content = _changed(message.data, random) if number == spoilt else message.data
        writer.add_message(channels[topic], message.log_time, content, message.publish_time, message.sequence)
    writer.finish()
    return stream.getvalue()
