"""``recover``: the intact part of a truncated recording."""

from __future__ import annotations

import argparse

from tactile_maps.cli.shared.damage import damage_rows
from tactile_maps.cli.shared.output import print_fields, print_json
from tactile_maps.recording.recover import recover


def execute(arguments: argparse.Namespace) -> int:
    """Write the intact part to a new file."""
    saved = recover(arguments.input, arguments.output, overwrite=arguments.overwrite)
    if arguments.json:
        facts = {"frames": saved.frames, "lost_frames": saved.lost_frames}
        print_json(facts | {"damage": list(saved.damage), "file": saved.file})
    else:
        print_fields(
            {
                "Frames": saved.frames,
                "Known to be missing": saved.lost_frames,
                **damage_rows(saved.damage, saved.tick),
                "Written to": saved.file,
            }
        )
    return 0
