"""``recover``: the intact part of a truncated recording."""

from __future__ import annotations

import argparse

from tactile_maps.cli.shared.damage import damage_rows
from tactile_maps.cli.shared.output import print_result
from tactile_maps.recording.file.damage import damage_text
from tactile_maps.recording.recover import recover


def execute(arguments: argparse.Namespace) -> int:
    """Write the intact part to a new file."""
    saved = recover(arguments.input, arguments.output, overwrite=arguments.overwrite)
    result = {
        "frames": saved.frames,
        "lost_frames": saved.lost_frames,
        "damage": list(saved.damage),
        "file": saved.file,
    }
    rows = {
        "Frames": saved.frames,
        "Known to be missing": saved.lost_frames,
        **damage_rows([damage_text(one, saved.tick) for one in saved.damage]),
        "Written to": saved.file,
    }
    print_result(result, rows, as_json=arguments.json)
    return 0
