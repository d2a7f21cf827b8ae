"""Replay of the run behind a row of path time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import UsageError
from tactile_maps.flattening.methods import METHODS
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.studies.base.rows import Row, number_or
from tactile_maps.studies.path_time.body_path import path_length, with_path_on_body
from tactile_maps.studies.path_time.conditions import Conditions, setup_of
from tactile_maps.studies.path_time.factors import Factor
from tactile_maps.studies.path_time.path_time import QUICK_SIZE, conditions_of, settings_of
from tactile_maps.studies.path_time.speed_search import SLOWEST
from tactile_maps.studies.study.study import CaseReplay
from tactile_maps.studies.testbeds.path_following import SETTLING, PathSetup


def replay_row(factors: Sequence[Factor], row: Row) -> CaseReplay:
    """Return the run behind a row, at the speed that was found, or at the slowest speed if none met the tolerances.

    Raises:
        UsageError: The row does not belong to a case of these factors, or its map has triangles between taxels (learned
            or Isomap), which a recording cannot store. This is checked before anything is prepared.

    Cost: 3 s to prepare.
    """
    try:
        conditions = conditions_of(factors, row)
        _check_map(conditions, row)
        setup = setup_of(str(row["robot"]), conditions, int(number_or(row["seed"], 0)))
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError("the row does not belong to a case of this study", value=error) from error
    drawn = settings_of(conditions, QUICK_SIZE if row.get("quick") else None)
    settings = with_path_on_body(drawn, setup)
    speed = number_or(row["speed_mm_s"], 1e3 * SLOWEST) / 1e3
    seconds = number_or(row["seconds"], path_length(settings) / speed)
    return replay_path(setup, replace(settings, path_speed=speed), seconds)


def _check_map(conditions: Conditions, row: Row) -> None:
    if conditions.map not in METHODS:
        raise UsageError(
            "this run cannot be replayed: its map has its own triangles between the taxels, and a recording stores "
            "places on the triangles of the skin",
            value=f"{row['factor']} {row['level']}",
            remedy=f"Choose a row of another factor, or of a map by {' or '.join(METHODS)}",
        )


def replay_path(setup: PathSetup, settings: ControlSettings, seconds: float) -> CaseReplay:
    """Return the run of ``run_path``: the contact settles, then follows its path for ``seconds``."""
    tick = setup.prepared.scene.tick
    settling = round(SETTLING / tick)
    return CaseReplay(
        setup.session(replace(settings, path_speed=0.0)),
        settling + round(seconds / tick),
        {settling: ControlChanged(settings)},
    )
