"""``run``: simulate a scene as fast as it goes, and record it."""

from __future__ import annotations

import argparse
import time
from contextlib import nullcontext
from typing import Any

from app.cli.output import print_fields, print_json, print_warning, progress_line
from app.cli.scenes import scene_from_arguments
from app.core.errors import SimulationError
from app.recording.recorder import Recorder
from app.session.frame import Frame
from app.session.prepare import PreparedScene, prepare
from app.session.session import Session
from app.tactile.contact_notes import ContactNote, ContactNoteKind, contact_note_text


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene for its seconds."""
    scene = scene_from_arguments(arguments)
    for lack in scene.decision.warnings:
        print_warning(f"{lack.where}: {lack.action}")
    prepared = prepare(scene, progress=progress_line())
    recorder = _recorder(prepared, arguments) if arguments.output else None
    with recorder or nullcontext():
        session = Session(prepared, effects=scene.unattended.effects)
        result, notes = _simulate(session, round(arguments.seconds / prepared.scene.tick), recorder)
    for note in notes:
        print_warning(contact_note_text(note))
    problems = [{"kind": lack.kind, "where": lack.where, "remedy": lack.action} for lack in scene.decision.warnings]
    result |= {"taxels": len(prepared.skin), "file": arguments.output, "problems": problems}
    if arguments.json:
        print_json(result)
    else:
        print_fields(
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


def _recorder(prepared: PreparedScene, arguments: argparse.Namespace) -> Recorder:
    return Recorder(prepared, arguments.output, overwrite=arguments.overwrite, viewers=arguments.viewers)


def _simulate(session: Session, count: int, recorder: Recorder | None) -> tuple[dict[str, Any], list[ContactNote]]:
    """Figures of the run; and what physics or skin told otherwise than asked, each where it was told first."""
    report, contacts, strongest = progress_line(), set(), 0.0
    notes: dict[tuple[ContactNoteKind, tuple[str, ...]], ContactNote] = {}
    start = time.perf_counter()
    for number in range(count):
        frame = _tick(session, recorder)
        if recorder is not None:
            recorder.write(frame, session.inputs)
        contacts |= {region.id for region in frame.regions}
        for note in frame.notes:
            notes.setdefault((note.kind, note.bodies), note)
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
        "contacts": len(contacts),
        "max_force_N": strongest,
        "notes": [{"kind": kind.value, "bodies": list(bodies)} for kind, bodies in notes],
    }
    return result, list(notes.values())


def _tick(session: Session, recorder: Recorder | None) -> Frame:
    """One tick; what stops the session is kept in the recording, and its message says how to see it again."""
    try:
        return session.tick()
    except SimulationError as error:
        if session.failure is None:
            raise
        again = "run it with --output to keep a recording that stops again"
        if recorder is not None:
            recorder.fail(session.failure)
            again = f"replay {recorder.path} --verify stops again at the same tick"
        remedy = f"{error.remedy}; {again}" if error.remedy else again[0].upper() + again[1:]
        raise error.at(remedy=remedy) from error
