"""``run``: simulate a scene as fast as possible, or in real time for viewers, and record it."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from tactile_maps.cli.shared.findings import model_notes_text, without_model_notes
from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.cli.shared.recording_sweep import record_sweep
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.errors import SimulationError, UsageError, names_text
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene, check_stimuli, findings_of
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, contact_note_text

if TYPE_CHECKING:
    from tactile_maps.export.live_rerun import LiveRerun
    from tactile_maps.export.live_server import LiveServer

SECONDS = 5.0
"""Default of the simulated time [s]."""
_LINKS_NAMED = 5


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene, or record many variations of it."""
    scene = scene_from_arguments(arguments)
    if arguments.sweep:
        return record_sweep(scene, arguments)
    if arguments.resume or arguments.cluster or arguments.jobs != 1:
        remedy = "Add --sweep FILE.toml, or leave out --resume, --jobs and --cluster"
        raise UsageError("a single recording is made in one process without interruption", remedy=remedy)
    prepared = prepare_cached(scene, progress=progress_line())
    check_stimuli(prepared, arguments.stimuli or arguments.scene_file or scene.name)
    findings = findings_of(prepared)
    for finding in without_model_notes(findings):
        times = f"{finding.count} x " if finding.count > 1 else ""
        kind = "" if finding.kind == "scene-warning" else f"{finding.kind.replace('-', ' ')}, "
        print_warning(f"{times}{kind}{finding.where}: {finding.action}")
    notes_text = model_notes_text(findings, prepared.robot.source)
    if notes_text:
        print_warning(notes_text)
    with ExitStack() as closing:
        recorder = closing.enter_context(_recorder(prepared, arguments)) if arguments.output else None
        session = Session(prepared, effects=scene.unattended.effects)
        watch = _share(session, arguments, closing) if arguments.serve or arguments.rerun else None
        ticks = max(round((arguments.seconds or SECONDS) / prepared.scene.tick), 1)
        result, notes = _simulate(session, ticks, recorder, watch)
    for note in notes:
        print_warning(contact_note_text(note))
    problems = [{"kind": f.kind, "where": f.where, "remedy": f.action, "count": f.count} for f in findings]
    covered = Counter[str]()
    for patch in prepared.skin.patches:
        covered[patch.link] += len(patch.taxels)
    result |= {"taxels": len(prepared.skin), "links": dict(covered), "file": arguments.output, "problems": problems}
    rows = {
        "Simulated": "{simulated_s:.2f} s in {wall_s:.2f} s ({real_time_factor:.1f}× real time)".format(**result),
        "Frames": result["frames"],
        "Taxels": _taxels_text(covered),
        "Contacts": "{contacts}, up to {max_force_N:.2f} N".format(**result),
        "Recorded to": arguments.output or "nothing",
    }
    print_result(result, rows, as_json=arguments.json)
    return 0


def _taxels_text(covered: Counter[str]) -> str:
    """Number of taxels and names of the covered links, those with the most taxels first."""
    links = [f"{link} ({count})" for link, count in covered.most_common()]
    return f"{covered.total()} on {names_text(links, _LINKS_NAMED)}" if covered else "0"


def _recorder(prepared: PreparedScene, arguments: argparse.Namespace) -> Recorder:
    return Recorder(prepared, arguments.output, overwrite=arguments.overwrite, viewers=arguments.viewers)


def _share(session: Session, arguments: argparse.Namespace, closing: ExitStack) -> Callable[[Frame], None]:
    """Start the viewers; the returned function sends a frame to them and waits for real time."""
    viewers: list[LiveServer | LiveRerun] = []
    if arguments.serve:
        viewers.append(_serve(session, arguments, closing))
    if arguments.rerun:
        from tactile_maps.export.live_rerun import LiveRerun  # an extra's package

        viewers.append(closing.enter_context(LiveRerun(session.prepared, address=arguments.rerun)))
        print_warning(f"shown in the Rerun viewer at {arguments.rerun}")
    start = time.perf_counter() - session.frame.time

    def watch(frame: Frame) -> None:
        for viewer in viewers:
            viewer.offer(frame, session.runtime_settings.map)
        time.sleep(max(start + frame.time - time.perf_counter(), 0.0))

    return watch


def _serve(session: Session, arguments: argparse.Namespace, closing: ExitStack) -> LiveServer:
    """Start a server for Foxglove and Lichtblick."""
    from tactile_maps.export.live_server import LOOPBACK, LiveServer

    server = closing.enter_context(LiveServer(session.prepared, host=arguments.host, port=arguments.port))
    print_warning(f"viewers find this session at {server.address}")
    if arguments.host not in (LOOPBACK, "localhost", "::1"):
        print_warning("other computers on the network can watch, but cannot change anything")
    return server


def _simulate(
    session: Session, count: int, recorder: Recorder | None, watch: Callable[[Frame], None] | None
) -> tuple[dict[str, Any], list[ContactNote]]:
    """Return figures of the run, and each note of physics and skin when it first occurred or deviated most."""
    report = progress_line()
    contacts = set()
    strongest = 0.0
    notes: dict[tuple[ContactNoteKind, tuple[str, ...]], ContactNote] = {}
    start = time.perf_counter()
    for number in range(count):
        frame = _tick(session, recorder)
        if recorder is not None:
            recorder.write(frame, session.inputs)
        if watch is not None:
            watch(frame)
        contacts |= {region.id for region in frame.regions}
        for note in frame.notes:
            key = note.kind, note.bodies
            notes[key] = max(notes.get(key, note), note, key=_deviation)
        strongest = max(strongest, frame.strongest_force)
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
        "notes": [
            {"kind": note.kind.value, "bodies": list(note.bodies)}
            | ({} if note.ratio is None else {"ratio": note.ratio})
            | ({} if note.pressure is None else {"force_N": note.force, "max_pressure_Pa": note.pressure})
            for note in notes.values()
        ],
    }
    return result, list(notes.values())


def _deviation(note: ContactNote) -> float:
    return 0.0 if note.ratio is None else abs(note.ratio - 1)


def _tick(session: Session, recorder: Recorder | None) -> Frame:
    """Simulate a tick; a failure is stored in the recording, and its message states how to reproduce it."""
    try:
        return session.tick()
    except SimulationError as error:
        if session.failure is None:
            raise
        again = "run it with --output for a recording that reproduces the stop"
        if recorder is not None:
            recorder.fail(session.failure)
            again = f"replay {recorder.written} --verify reproduces the stop at the same tick"
        remedy = f"{error.remedy}; {again}" if error.remedy else again[0].upper() + again[1:]
        raise error.at(remedy=remedy) from error
