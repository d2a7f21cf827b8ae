"""Recovery of a damaged recording: copies all intact messages to a new file, which states the losses."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import open_atomically
from tactile_maps.recording.encoding.viewer_messages import viewer_schemas
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.file.damage import DamageKind, RecordingDamage
from tactile_maps.recording.file.messages import damage_entry, read_messages
from tactile_maps.session.bundle import unpack_scene


@dataclass(frozen=True)
class RecoveryResult:
    """Result of a recovery.

    Attributes:
        frames: Number of frames in the new file.
        lost_frames: Number of frames known to be missing; the number after a cut is unknown.
        damage: Damage of the source; the new file states the same.
        tick: Time step of the scene [s].
        file: The new file.
    """

    frames: int
    lost_frames: int
    damage: tuple[RecordingDamage, ...]
    tick: float
    file: str


def recover(source: str | Path, target: str | Path, *, overwrite: bool = False) -> RecoveryResult:
    """Copy the intact messages of ``source`` to a complete recording ``target``.

    Raises:
        RecordingError: The source is not a recording or contains no frame; the target exists or cannot be written.
    """
    source = Path(source)
    target = Path(target)
    if source.resolve() == target.resolve():
        raise RecordingError("a recording cannot be recovered into itself", file=target, remedy="Give another file")
    contents = mcap_file.read_recording(source)
    prepared = unpack_scene(contents.attachments, file=str(source))
    messages = read_messages(contents, prepared, file=str(source))
    if not len(messages.frames):
        raise contents.no_frame()
    with open_atomically(target, error=RecordingError, overwrite=overwrite) as stream:
        metadata = contents.metadata | damage_entry(messages.damage)
        writer, channels = mcap_file.begin_copy(stream, contents, metadata, viewer_schemas(prepared))
        for topic, message in chain.from_iterable(filter(None, contents.all_messages())):
            if topic in channels:
                channel = channels[topic]
                writer.add_message(channel, message.log_time, message.data, message.publish_time, message.sequence)
        writer.finish()
    lost = sum(one.count or 0 for one in messages.damage if one.kind == DamageKind.FRAMES_MISSING)
    return RecoveryResult(len(messages.frames), lost, messages.damage, prepared.scene.tick, str(target))
