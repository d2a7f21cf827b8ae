"""``run``: simulate a scene as fast as it goes, and record it."""

from __future__ import annotations

import argparse
import time
from contextlib import nullcontext
from typing import Any

from app.cli.output import answer, facts, progress_line
from app.cli.scenes import scene_of
from app.recording.recorder import Recorder
from app.session.prepare import prepare
from app.session.session import Session


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene for its seconds."""
    prepared = prepare(scene_of(arguments), progress=progress_line())
    recorder = Recorder(arguments.output, prepared, overwrite=arguments.overwrite) if arguments.output else None
    with recorder or nullcontext():
        result = _simulate(Session(prepared), round(arguments.seconds / prepared.scene.tick), recorder)
    result |= {"taxels": len(prepared.skin), "file": arguments.output}
    if arguments.json:
        answer(result)
    else:
        facts(
            {
                "Simulated": "{simulated_s:.2f} s in {wall_s:.2f} s ({real_time_factor:.1f}× real time)".format(
                    **result
                ),
                "Frames": result["frames"],
                "Taxels": result["taxels"],
                "Contacts": "{contacts}, up to {max_force_N:.2f} N".format(**result),
                "Recorded to": arguments.output or "nothing",
            }
        )
    return 0


def _simulate(session: Session, count: int, recorder: Recorder | None) -> dict[str, Any]:
    report, contacts, strongest = progress_line(), set(), 0.0
    start = time.perf_counter()
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
    return {
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / max(wall, 1e-9),
        "frames": count,
        "contacts": len(contacts),
        "max_force_N": strongest,
    }
