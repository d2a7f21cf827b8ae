"""``run``: simulate a scene as fast as it goes, and record it."""

from __future__ import annotations

import argparse
import time
from contextlib import nullcontext

from app.cli.output import answer, facts, progress_line
from app.cli.scenes import scene_of
from app.recording.recorder import Recorder
from app.session.prepare import prepare
from app.session.session import Session


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene for its seconds."""
    report = progress_line()
    prepared = prepare(scene_of(arguments), progress=report)
    session = Session(prepared)
    count = round(arguments.seconds / prepared.scene.tick)
    recorder = Recorder(arguments.output, prepared, overwrite=arguments.overwrite) if arguments.output else None
    contacts, strongest = set(), 0.0
    start = time.perf_counter()
    with recorder or nullcontext():
        for number in range(count):
            frame = session.tick()
            if recorder is not None:
                recorder.write(frame, session.inputs)
            contacts |= {region.id for region in frame.regions}
            strongest = max([strongest, *(region.force for region in frame.regions)])
            if number % 100 == 0:
                report("Simulating", number / count)
    wall = time.perf_counter() - start
    report("", 1.0)
    simulated = session.frame.time
    result = {
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / max(wall, 1e-9),
        "frames": count,
        "taxels": len(prepared.skin),
        "contacts": len(contacts),
        "max_force_N": strongest,
        "file": arguments.output,
    }
    if not arguments.json:
        facts(
            {
                "Simulated": f"{simulated:.2f} s in {wall:.2f} s ({result['real_time_factor']:.1f}× real time)",
                "Frames": count,
                "Taxels": len(prepared.skin),
                "Contacts": f"{len(contacts)}, up to {strongest:.2f} N",
                "Recorded to": arguments.output or "nothing",
            }
        )
    else:
        answer(result)
    return 0
