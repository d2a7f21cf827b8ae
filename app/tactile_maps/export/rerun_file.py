"""A recording as a Rerun file (.rrd): the robot and its taxels in 3-D, the tactile image, contacts, joints, events."""

from __future__ import annotations

from bisect import bisect_right
from pathlib import Path

from tactile_maps.core.progress import Progress, part_of_progress
from tactile_maps.export.optional import packages_of
from tactile_maps.export.rerun_log import RerunLog
from tactile_maps.export.tables import LOOKING, batches, highest_reading
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
        every = max(round(1.0 / (rate * player.prepared.scene.tick)), 1)
        told = 0
        due = -(-player.frame(0).tick // every) * every
        for frames in batches(player, part_of_progress(progress, LOOKING, 1.0)):
            for frame in frames:
                stream.set_time("time", duration=frame.time)
                if frame.tick >= due:  # readings of a real skin come at any ticks
                    log.add(frame)
                    due = (frame.tick // every + 1) * every
                now = bisect_right(player.events, frame.tick, key=lambda event: event.tick)
                for event in player.events[told:now]:
                    stream.log("events", rerun.TextLog(event.words, level="INFO"))
                told = now
    finally:
        stream.disconnect()
