"""``trim``: a part of a recording, or each of its episodes, as separate files."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.core.errors import RecordingError, UsageError, counted
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.trim import TrimResult, trim, trim_episodes


def execute(arguments: argparse.Namespace) -> int:
    """Write the part, or the episodes."""
    if arguments.end is not None and arguments.end < arguments.start:
        span = f"{arguments.start:g} to {arguments.end:g} s"
        raise UsageError("the part ends before it begins", value=span, remedy="Give --from before --to")
    report = progress_line()
    try:
        player = RecordingPlayer(arguments.input, progress=report)
        if arguments.episodes:
            folder = Path(arguments.output)
            written = trim_episodes(player, folder, overwrite=arguments.overwrite, progress=report)
        else:
            written = [_part(player, arguments)]
    finally:
        report("", 1.0)
    for one in written:
        for text in one.damage_texts:
            print_warning(f"{one.file}: {text}")
    rows = {one.file: f"{one.seconds:.2f} s, {counted(one.frames, 'frame')}" for one in written}
    print_result({"files": [_row(one) for one in written]}, rows, as_json=arguments.json)
    return 0


def _row(one: TrimResult) -> dict[str, object]:
    return {
        "file": one.file,
        "frames": one.frames,
        "seconds": one.seconds,
        "complete": not one.damage,
        "damage": list(one.damage),
    }


def _part(player: RecordingPlayer, arguments: argparse.Namespace) -> TrimResult:
    end = round(player.duration, 3)  # as stated in messages; a time that is given so is within the recording
    latest = max(end, player.duration)
    if arguments.start > latest:
        problem = f"--from is after the end of the recording, which is {end} s long"
        remedy = f"Give --from a time from 0 to {end}"
        raise RecordingError(problem, file=player.path, value=f"{arguments.start:g} s", remedy=remedy)
    if arguments.end is not None and arguments.end > latest:
        print_warning(f"--to is after the end of the recording, at which the part ends: {end} s")
    first = player.tick_at(arguments.start)
    last = None if arguments.end is None else player.tick_at(arguments.end)
    return trim(player.path, arguments.output, first=first, last=last, overwrite=arguments.overwrite)
