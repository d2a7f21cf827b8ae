"""``replay``: step through a recording; with ``--verify`` simulate it again and compare."""

from __future__ import annotations

import argparse

from tactile_maps.cli.shared.damage import damage_rows
from tactile_maps.cli.shared.output import print_error, print_result, progress_line
from tactile_maps.core.errors import RecordingError, counted
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import Verification, verify
from tactile_maps.stimuli.stimuli_from_pokes import stimuli_from_pokes
from tactile_maps.stimuli.stimulus_file import save_stimuli

_NOTHING = "nothing to compare"


def execute(arguments: argparse.Namespace) -> int:
    """Read or verify every frame; return 1 where a verification finds a difference, damage or nothing to compare."""
    player = RecordingPlayer(arguments.input)
    result: dict[str, object] = {
        "frames": len(player),
        "complete": player.complete,
        "damage": list(player.damage),
        "identical": None,
        "max_difference": None,
    }
    rows: dict[str, object] = {
        "Frames": len(player),
        "Duration": f"{player.duration:.2f} s",
        "Robot": player.prepared.robot.name,
        **damage_rows(player.damage_texts),
    }
    if player.failure is not None:
        tick, error = player.failure
        result |= {"stopped_at": tick, "stopped": str(error), "stopped_again": None}
        rows["Stopped"] = f"at tick {tick}: {error}"
    if arguments.stimuli:
        _save_stimuli(player, arguments.stimuli, rows)
    if player.measured is not None:
        result["measured"] = rows["Measured"] = player.measured
    if arguments.verify and player.measured is not None:
        rows["Identical"] = f"{_NOTHING}: measured readings cannot be simulated again"
    else:
        (_verify if arguments.verify else _read)(player, result, rows)
    print_result(result, rows, as_json=arguments.json)
    return 1 if arguments.verify and not (result["identical"] is True and player.complete) else 0


def _save_stimuli(player: RecordingPlayer, file: str, rows: dict[str, object]) -> None:
    scene = player.prepared.scene
    stimuli = stimuli_from_pokes(
        player.prepared.skin, player.inputs, tick=scene.tick, last=player.frame(len(player) - 1).tick
    )
    if not stimuli:
        raise RecordingError("the recording contains no pokes", file=player.path)
    save_stimuli(stimuli, file)
    rows["Touches"] = f"{len(stimuli)}, written to {file}"


def _verify(player: RecordingPlayer, result: dict[str, object], rows: dict[str, object]) -> None:
    report = progress_line()
    outcome = verify(player, progress=report)
    report("", 1.0)
    result |= {
        "identical": outcome.identical,
        "max_difference": outcome.max_difference,
        "first_difference": outcome.first_difference,
        "differing": outcome.differing or None,
        "other_versions": outcome.other_versions,
        "other_machine": outcome.other_machine,
    }
    if player.failure is not None:
        result["stopped_again"] = outcome.stopped is not None
        rows["Stopped again"] = "yes, at the same tick with the same message" if outcome.stopped else "no"
    result["not_compared"] = outcome.not_compared
    if outcome.not_compared:
        rows["Not compared"] = f"{counted(outcome.not_compared, 'frame')}: inputs before them are missing"
    rows["Identical"] = _identical_text(outcome)
    if outcome.identical is False and outcome.other_machine:
        rows["Likely reason"] = f"the last digits depend on the machine: {'; '.join(outcome.other_machine)}"
    if outcome.other_versions:
        print_error(
            "recorded with other versions, so small differences are expected: " + ", ".join(outcome.other_versions)
        )


def _identical_text(outcome: Verification) -> str:
    if outcome.identical is None:
        return f"{_NOTHING}: inputs before the first frame are missing"
    if not outcome.identical:
        quantity = f" in {outcome.differing}" if outcome.differing else ""
        return f"no: from tick {outcome.first_difference} on, by up to {outcome.max_difference:.3g}{quantity}"
    frames = counted(outcome.frames, "frame")
    return f"yes: all joint positions, velocities, object poses and pressures of {frames}, bit for bit"


def _read(player: RecordingPlayer, result: dict[str, object], rows: dict[str, object]) -> None:
    report = progress_line()
    strongest = 0.0
    known = True
    for number in range(len(player)):
        frame = player.frame(number)
        known &= frame.units.force is not None
        strongest = max(strongest, frame.strongest_force)
        if number % 200 == 0:
            report("Reading", number / len(player))
    report("", 1.0)
    result["max_force_N"] = strongest if known else None
    rows["Strongest contact"] = f"{strongest:.2f} N" if known else "force unknown: readings not calibrated"
