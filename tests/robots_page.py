"""Measures the control of robots and writes the rows as CSV: ``python -m tests.robots_page -o rows.csv``.

    python -m tests.robots_page -o rows.csv             # the full grid of all robots that are installed: hours
    python -m tests.robots_page -o rows.csv --robots panda,leg --trials press=8,path=4,pushed=3

Robots are those of ``tests/robots/robot_models.py``; published ones are found in installed wheels, or in wheels that
were unpacked in the folder ``TACTILE_MAPS_ROBOTS``. Rows are written after each trial, so that a run may be stopped.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from app.core.errors import TactileMapsError
from tests.robots.robot_models import BY_NAME
from tests.robots.robot_trials import CONTROLLERS, Place, Trial, at_posture, grid, posture_of, run

COLUMNS = ("robot", "task", "posture", "stiffness", "rate", "controller", "verdict", "cause", "tilt_deg", "force",
           "ripple", "peak", "overload_ms", "error_mm", "way_mm", "limits")  # fmt: skip


def measure(names: Sequence[str], counts: Mapping[str, int]) -> Iterator[dict[str, object]]:
    """Yield the rows of robots that are available.

    Args:
        names: Names of robots.
        counts: Number of trials of each task and robot; all where none is stated.
    """
    for name in names:
        if BY_NAME[name].missing():
            sys.stderr.write(f"skipped: {BY_NAME[name].missing()}\n")
            continue
        with tempfile.TemporaryDirectory() as folder:
            prepared = BY_NAME[name].prepare(Path(folder))
        places: dict[str, Place | str] = {}
        for trial in (
            trial for task in CONTROLLERS for trial in grid(task, turn=list(BY_NAME).index(name))[: counts.get(task)]
        ):
            if trial.posture not in places:
                places[trial.posture] = _place(prepared, trial)
            place = places[trial.posture]
            row = {"robot": name, **vars(trial)}
            if isinstance(place, str):
                yield {**row, "verdict": "no place", "cause": place}
            else:
                yield {**row, **vars(run(place, trial))}


def _place(prepared, trial: Trial) -> Place | str:
    posture = posture_of(prepared, trial.posture)
    if posture is None:
        return "no posture without contact of links was found"
    try:
        place = Place(at_posture(prepared, posture))
        assert place.gap < 1  # raises where the ball cannot touch
        return place
    except TactileMapsError as error:
        return str(error)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure robots and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", dest="out", type=Path, required=True)
    parser.add_argument("--robots", default=",".join(BY_NAME))
    parser.add_argument("--trials", default="")
    chosen = parser.parse_args(arguments)
    counts = dict(part.split("=") for part in chosen.trials.split(",") if part)
    with chosen.out.open("w", newline="", encoding="utf8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for row in measure(chosen.robots.split(","), {task: int(count) for task, count in counts.items()}):
            writer.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
