"""A short recording with hardware ids, and a copy of it that lost frames."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from mcap.reader import make_reader

from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import TaxelIdentity
from tests.support.recordings import record, small_arm


@cache
def named_arm() -> PreparedScene:
    """The small arm, whose taxels have the ids 1000, 1003, 1006, ..."""
    arm = small_arm()
    patches = []
    start = 0
    for patch in arm.skin.patches:
        ids = 1000 + 3 * np.arange(start, start + len(patch.taxels))
        identity = TaxelIdentity(ids=ids, modules=ids // 12, channels=ids % 12)
        patches.append(replace(patch, taxels=replace(patch.taxels, identity=identity)))
        start += len(patch.taxels)
    skin = replace(arm.skin, patches=tuple(patches))
    return replace(arm, skin=skin, map=replace(arm.map, skin=skin))


@pytest.fixture(scope="package")
def path(tmp_path_factory):
    """200 ticks with a poke, a stroke and an edit."""
    path = tmp_path_factory.mktemp("export") / "demo.mcap"
    record(named_arm(), path, ticks=200)
    return path


@pytest.fixture(scope="package")
def player(path):
    return RecordingPlayer(path)


@pytest.fixture(scope="package")
def frames(player):
    return list(player)


@pytest.fixture(scope="package")
def damaged(path, tmp_path_factory):
    """The same with a chunk of frames in its middle broken."""
    data = bytearray(path.read_bytes())
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    (topic,) = [channel.id for channel in summary.channels.values() if channel.topic == "/frame"]
    chunks = [chunk for chunk in summary.chunk_indexes if topic in chunk.message_index_offsets]
    chunk = chunks[len(chunks) // 2]
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 1
    target = tmp_path_factory.mktemp("export") / "damaged.mcap"
    target.write_bytes(data)
    return target
