"""Salvages a damaged recording: everything whole is written to a new file, which says what its source had lost."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from mcap.writer import CompressionType, Writer

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import open_atomically
from tactile_maps.recording.encoding.viewer_messages import viewer_schemas
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.file.damage import DamageKind, RecordingDamage
from tactile_maps.recording.file.messages import damage_entry, read_messages
from tactile_maps.session.bundle import unpack_scene
from tactile_maps.session.prepare import PreparedScene


@dataclass(frozen=True)
class RecoveryResult:
    """What was saved.

    Attributes:
        frames: Frames in the new file.
        lost_frames: Frames known to be missing; how many followed a cut nobody knows.
        damage: What the source had lost; the new file says the same.
        tick: Of the scene [s].
        file: The new file.
    """

    frames: int
    lost_frames: int
    damage: tuple[RecordingDamage, ...]
    tick: float
    file: str


def recover(source: str | Path, target: str | Path, *, overwrite: bool = False) -> RecoveryResult:
    """Copy what is whole in ``source`` to a recording ``target`` that is readable to its end.

    Raises:
        RecordingError: The source is no recording or holds no frame; the target exists or cannot be written.
    """
    source = Path(source)
    target = Path(target)
    if source.resolve() == target.resolve():
        raise RecordingError("a recording cannot be recovered into itself", file=target, remedy="Name another file")
    contents = mcap_file.read_recording(source)
    prepared = unpack_scene(contents.attachments, file=str(source))
    messages = read_messages(contents, prepared, file=str(source))
    if not len(messages.frames):
        raise contents.no_frame()
    with open_atomically(target, error=RecordingError, overwrite=overwrite) as stream:
        writer = Writer(stream, chunk_size=1_000_000, compression=CompressionType.ZSTD, enable_data_crcs=True)
        _write(writer, contents, messages.damage, prepared)
    lost = sum(one.count or 0 for one in messages.damage if one.kind == DamageKind.FRAMES_MISSING)
    return RecoveryResult(len(messages.frames), lost, messages.damage, prepared.scene.tick, str(target))


def _write(
    writer: Writer, contents: mcap_file.RecordingContents, damage: tuple[RecordingDamage, ...], prepared: PreparedScene
) -> None:
    metadata = contents.metadata | damage_entry(damage)
    channels = mcap_file.begin_recording(writer, metadata, contents.attachments)
    shown = viewer_schemas(prepared)
    if not shown.keys().isdisjoint(contents.channels.values()):
        channels = {**channels, **mcap_file.add_viewer_channels(writer, shown)}
    for topic, message in chain.from_iterable(filter(None, contents.all_messages())):
        if topic in channels:
            writer.add_message(channels[topic], message.log_time, message.data, message.publish_time, message.sequence)
    writer.finish()
