"""A recording as a Rerun file (.rrd): the robot and its taxels in 3-D, the tactile image, contacts, joints, events."""

from __future__ import annotations

from pathlib import Path

from tactile_maps.core.errors import packages_of
from tactile_maps.core.progress import Progress, part_of_progress
from tactile_maps.export.rerun_log import RerunLog
from tactile_maps.export.tables import LOOKING, highest_reading, paced_frames
from tactile_maps.maps.pressure_colours import rounded_scale
from tactile_maps.recording.player import RecordingPlayer


def write_rerun(player: RecordingPlayer, path: Path, *, rate: float, progress: Progress) -> None:
    """Write the file.

    Raises:
        ExportError: The package is not installed.
    """
    with packages_of("rerun"):
        import rerun
    stream = rerun.RecordingStream("tactile-maps", recording_id=player.path.stem)
    stream.save(path)
    try:
        highest = highest_reading(player, part_of_progress(progress, 0.0, LOOKING))
        log = RerunLog(player.prepared, rerun, stream, scale=rounded_scale(1e-3 * highest))
        log.open()
        for frame, due, events in paced_frames(player, rate, part_of_progress(progress, LOOKING, 1.0)):
            stream.set_time("time", duration=frame.time)
            if due:
                log.add(frame)
            for event in events:
                stream.log("events", rerun.TextLog(event.words, level="INFO"))
    finally:
        stream.disconnect()
