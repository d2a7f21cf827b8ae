"""``check``: guided check of a real skin, whose parts are pressed one after another, with a report."""

from __future__ import annotations

import argparse
import sys
import threading
from collections import deque
from contextlib import closing
from datetime import datetime
from typing import Any

import numpy as np

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line, write_error
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.cli.shared.source_options import (
    OTHER_SKIN,
    blaming,
    connection_of,
    refuse_silence,
    token_of,
    until_interrupted,
)
from tactile_maps.core.errors import UsageError, counted
from tactile_maps.live.channels.matching import load_matching
from tactile_maps.live.checking.report import (
    board_rows,
    channels_text,
    check_facts,
    fault_counts,
    outcome_counts,
    swap_texts,
    write_check_report,
)
from tactile_maps.live.checking.skin_check import RELEASED, CheckSettings, CheckStage, Outcome, SkinCheck
from tactile_maps.live.checking.verdicts import Verdicts, verdicts_of
from tactile_maps.live.motion.command_loop import CommandLoop
from tactile_maps.live.prepare import prepare_measured
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.facts import few_heard
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.open import is_live
from tactile_maps.session.frame import Frame

_PAUSE = 0.01
"""Period of looking for keys and the end [s]."""
_FINISH_SECONDS = 1.0
_NAMED = 8
"""Maximum number of parts and channels that are listed; the page lists all."""
_KEYS = "Enter: next part, s: skip, b: back, q: finish"


def execute(arguments: argparse.Namespace) -> int:
    """Check until all parts were pressed, the source ends, or Ctrl-C; report what was found."""
    arguments.token = token_of(arguments)
    settings = _settings(arguments)
    scene = scene_from_arguments(arguments)
    connection = connection_of(arguments)
    prepared = prepare_measured(scene, progress=progress_line())
    table = load_matching(arguments.ids, prepared.skin) if arguments.ids else None
    session = MeasuredSession(prepared, connection.take, table=table, finite=connection.source.finite)
    check = SkinCheck(prepared.skin, settings)
    started = datetime.now().astimezone()
    connection.open()
    try:
        _run(connection, session, check)
    finally:
        connection.close()
    refuse_silence(connection, session.facts)
    reached = check.stage is CheckStage.DONE
    check.finish()
    if arguments.report:
        facts = check_facts(prepared, connection.source.address, str(session.facts.unit), started)
        write_check_report(check, arguments.report, facts, points=prepared.map.taxel_points)
    verdicts = verdicts_of(check)
    result = _result(check, verdicts, connection, arguments.report)
    for warning in _warnings(check, session, reached=reached):
        print_warning(warning)
    print_result(result, _rows(result, channels_text(check, verdicts)), as_json=arguments.json)
    return 0


def _settings(arguments: argparse.Namespace) -> CheckSettings:
    live = is_live(arguments.source)
    ordered = live if arguments.order is None else arguments.order == "asked"
    if live and not ordered:
        remedy = "Press the requested parts, or give a file"
        raise UsageError("a live skin is checked part by part", place="--order", value="any", remedy=remedy)
    if not ordered and (
        waits := [f"--{name}" for name in ("patience", "pause") if getattr(arguments, name) is not None]
    ):
        remedy = "Add --order asked if the parts were pressed in their order"
        raise UsageError("the option has no effect on any touches of a file", value=", ".join(waits), remedy=remedy)
    names = {"rest": arguments.rest, "patience": arguments.patience, "pause": arguments.pause}
    given = {name: value for name, value in names.items() if value is not None}
    if arguments.threshold is not None:
        given["least"] = arguments.threshold
    with blaming("check"):
        return CheckSettings(ordered=ordered, **given)


def _run(connection: Connection, session: MeasuredSession, check: SkinCheck) -> None:
    """Pass the readings to the check until it is done or the source ends."""

    def each(frame: Frame) -> None:
        assert frame.measured is not None
        check.add(frame.measured.raw, frame.time)

    guided = check.settings.ordered and is_live(connection.source.address)
    keys = Keys() if guided and sys.stdin is not None and sys.stdin.isatty() else None
    lock = threading.Lock()
    commands = CommandLoop(connection, session, None, each, lock=lock)
    shown = ""
    with until_interrupted(live=is_live(connection.source.address)), closing(commands):
        connection.start()
        commands.start()
        while not commands.finished.wait(_PAUSE) and check.stage is not CheckStage.DONE:
            commands.raise_error()
            with lock:
                if keys is not None and keys.apply(check):
                    break
                text = check.prompt
            if guided and text != shown:
                write_error(f"tactile-maps: {text}{f' ({_KEYS})' if keys is not None and not shown else ''}\n")
                shown = text
    connection.close()
    commands.finish(_FINISH_SECONDS)


class Keys:
    """Keys of the user, a line each, read on a thread of their own. Mutable."""

    def __init__(self) -> None:
        self._lines: deque[str] = deque()
        threading.Thread(target=self._read, name="keys", daemon=True).start()

    def _read(self) -> None:
        for line in sys.stdin:
            self._lines.append(line.strip().lower())

    def apply(self, check: SkinCheck) -> bool:
        """Apply the keys so far; return whether the user finishes the check."""
        acts = {"": check.next, "n": check.next, "s": check.skip, "b": check.back}
        while self._lines:
            line = self._lines.popleft()
            if line == "q":
                return True
            if (act := acts.get(line)) is None:
                write_error(f"tactile-maps: unknown key. {_KEYS}\n")
            else:
                act()
        return False


def _result(check: SkinCheck, verdicts: Verdicts, connection: Connection, report: str | None) -> dict[str, Any]:
    skin = check.skin
    channels = [
        {
            "taxel": taxel,
            "name": skin.taxel_text(taxel),
            "faults": [str(fault) for fault in verdicts.of(taxel)],
            "change": float(max(check.rise[taxel], check.fall[taxel])),
            "noise": float(check.noise[taxel]),
            "baseline": float(check.baseline[taxel]),
        }
        for taxel in verdicts.faulty.tolist()
    ]
    parts = [
        {
            "name": part.name,
            "link": part.link,
            "outcome": str(result.outcome),
            "responded": [check.parts[one].name for one in result.others],
            "felt": int(check.felt[part.taxels].sum()),
            "taxels": len(part.taxels),
        }
        for part, result in zip(check.parts, check.results, strict=True)
    ]
    return {
        "source": connection.source.address,
        "readings": check.readings,
        "touches": check.touches,
        "outcomes": outcome_counts(check),
        "faults": fault_counts(verdicts),
        "falls": verdicts.falls,
        "median_noise": float(np.median(check.noise)),
        "swapped": list(swap_texts(check, verdicts)),
        "channels": channels,
        "boards": board_rows(check, verdicts),
        "parts": parts,
        "report": report,
    }


def _rows(result: dict[str, Any], channels: str) -> dict[str, object]:
    unclear = [part for part in result["parts"] if part["outcome"] not in (Outcome.FELT, Outcome.OPEN)]
    return {
        "Source": result["source"],
        "Readings": result["readings"],
        "Touches": f"{result['touches']}; pauses below {RELEASED:g} s do not separate touches",
        "Parts": ", ".join(f"{count} {name}" for name, count in result["outcomes"].items() if count),
        **{part["name"]: _part_text(part) for part in unclear[:_NAMED]},
        "Channels": channels,
        **{one["name"]: ", ".join(one["faults"]) for one in result["channels"][:_NAMED]},
        **({"Swapped": "; ".join(result["swapped"][:_NAMED])} if result["swapped"] else {}),
        "Report": result["report"] or "none; --report FILE.html writes one",
    }


def _part_text(part: dict[str, Any]) -> str:
    others = f": {', '.join(part['responded'])}" if part["responded"] else ""
    return f"{part['outcome']}{others}"


def _warnings(check: SkinCheck, session: MeasuredSession, *, reached: bool) -> list[str]:
    facts = session.facts
    found = []
    left = sum(result.outcome is Outcome.OPEN for result in check.results)
    if check.settings.ordered and left and not reached:
        found.append(f"the readings ended before {left} of {len(check.parts)} parts had their turn")
    if facts.unknown:
        found.append(f"{counted(facts.unknown_values, 'value')} of taxels that the skin does not have")
    if few := few_heard(facts, len(check.skin)):
        found.append(f"{few}; {OTHER_SKIN}")
    if facts.ambiguous:
        found.append(
            f"{counted(facts.ambiguous_values, 'value')} of ids that several taxels have; use --ids, or link:id"
        )
    if facts.refused:
        found.append(f"{counted(facts.refused, 'reading')} rejected; the last: {facts.problem}")
    return found
