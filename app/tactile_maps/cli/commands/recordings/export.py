"""``export``: a recording in the format of another program."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from tactile_maps.cli.shared.damage import damage_rows
from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.cli.shared.unused_options import refuse_with_input
from tactile_maps.core.errors import UsageError
from tactile_maps.export.export import FORMATS, ExportOptions, export_recording
from tactile_maps.recording.player import RecordingPlayer


def execute(arguments: argparse.Namespace) -> int:
    """Write the recording in the requested format."""
    if arguments.to not in FORMATS:
        raise UsageError("unknown format", place="--to", value=arguments.to, remedy=FORMATS.remedy(arguments.to))
    for name in ("image_width", "rate", "fps"):
        if name not in FORMATS[arguments.to].uses:
            others = ", ".join(form.name for form in FORMATS.values() if name in form.uses)
            option = f"--{name.replace('_', '-')}"
            refuse_with_input(arguments, [option], "format", arguments.to, purpose=f"It is for {others}")
    if arguments.end is not None and arguments.end < arguments.start:
        value = f"{arguments.start:g} to {arguments.end:g} s"
        raise UsageError("the part ends before it begins", value=value, remedy="Give --from before --until")
    options = ExportOptions(image_width=arguments.image_width, rate=arguments.rate, fps=arguments.fps)
    target = Path(arguments.output)
    FORMATS[arguments.to].check_name(target)
    report = progress_line()
    start = time.perf_counter()
    try:
        source = RecordingPlayer(arguments.input)
        end = source.duration if arguments.end is None else min(arguments.end, source.duration)
        player = export_recording(
            source,
            target,
            to=arguments.to,
            options=options,
            span=None if (arguments.start, end) == (0.0, source.duration) else (arguments.start, end),
            overwrite=arguments.overwrite,
            progress=report,
        )
    finally:
        report("", 1.0)
    for text in player.damage_texts:
        print_warning(text)
    size = sum(part.stat().st_size for part in (target.rglob("*") if target.is_dir() else [target]) if part.is_file())
    result = {
        "file": str(target),
        "format": arguments.to,
        "frames": len(player),
        "bytes": size,
        "complete": player.complete,
        "damage": list(player.damage),
    }
    rows = {
        "Frames": len(player),
        "Duration": f"{player.duration:.2f} s",
        **damage_rows(player.damage_texts),
        "Written to": f"{target}, {1e-6 * size:.1f} MB in {time.perf_counter() - start:.1f} s",
    }
    print_result(result, rows, as_json=arguments.json)
    return 0
