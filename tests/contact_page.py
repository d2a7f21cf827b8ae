"""Writes the guide's page of contacts from ``assets/findings/contact.csv``: ``python -m tests.contact_page``.

``--tables DIR`` first takes the table that ``tactile-maps study contact -o DIR`` wrote. A test writes the page again
and compares.
"""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

from tactile_maps.studies.base.rows import Row, distinct
from tactile_maps.studies.sweeps.contact import (
    EXCEPTIONS,
    MODELS,
    OK,
    OUTSIDE,
    REJECTED,
    STEPS_MS,
    TOLERANCES,
    exception_of,
    tolerance,
)
from tests.findings_page import ASSETS, TABLES, as_shipped, table

PAGE = ASSETS / "guide" / "contact.md"
COLUMNS = (
    "check",
    "skin",
    "shape",
    "physics",
    "motion",
    "integrator",
    "timestep_ms",
    "ratio",
    "seed",
    "model",
    "verdict",
    *TOLERANCES,
)
_NAMES = {
    "weight_percent": "weight",
    "centre_mm": "centre of pressure",
    "creep_mm_s": "creep",
    "spin_deg_s": "spin",
    "flicker_percent": "standard deviation of the force",
    "slide_percent": "acceleration of a slide",
    "impulse_percent": "impulse of an impact",
    "rebound_percent": "rebound",
    "decay_percent": "rate of decay",
    "balance": "forces of two skins on each other",
    "mirror_mm": "centres of mirrored loads",
}
_UNITS = {"percent": " %", "mm": " mm", "mm_s": " mm/s", "deg_s": " °/s"}
_HEAD = """# Contact against mechanics

This page is made by `python -m tests.contact_page` from the rows of `tactile-maps study contact`
([rows](../findings/contact.csv)), and `tests/tactile/test_contact_table.py` checks each row again.

Bodies of 0.5 kg rest on a fixed block, slide on it, fall on it or are pressed on it. The cover has 20 kN/m. Unless
stated otherwise, the integrator is `implicitfast` with 1 ms, and a reading is the mean of 5 steps. The reference is
mechanics alone. The upper side of the block is one of these skins:

- *flat*, *convex* (radius 60 mm) or *concave* (radius 80 mm),
- *border*: covered on one half, and the body is half on the skin,
- *bare*: without skin at the body, so that nothing may be read and the program must report it."""


def rows() -> list[Row]:
    """Return the shipped rows."""
    return table("contact")


def page() -> str:
    """Return the text of the page."""
    found = rows()
    parts = [_HEAD, _tolerances(found), "## At rest", _legend(), *_at_rest(found), "## Other checks", *_checks(found)]
    parts += ["## Integrators and time steps", *_steps(found), "## Exceptions", *_exceptions(found)]
    return "\n\n".join(parts) + "\n"


def _tolerances(found: Sequence[Row]) -> str:
    lines = ["| quantity | tolerance | largest value of the rows that are ok |", "|---|---|---|"]
    for column, limit in TOLERANCES.items():
        kept = [row for row in found if row["verdict"] == OK and tolerance(column, str(row["model"])) == limit]
        values = [abs(row[column]) for row in kept if row[column] is not None]
        lines.append(f"| {_NAMES[column]} | {_value(column, limit)} | {_value(column, max(values, default=0.0))} |")
    nearest = _value("centre_mm", tolerance("centre_mm", "point"))
    note = (
        f"The table does not contain the centre of `point`, which loads only the nearest taxel: its tolerance is "
        f"half a pitch, {nearest}. Rebound is the highest point after an impact as a share of the height of the fall. "
        f"Energy may be lost but not gained, so any value up to 100 % is correct."
    )
    return "\n".join(lines) + "\n\n" + wrapped(note)


def wrapped(text: str, indent: str = "") -> str:
    return textwrap.fill(text, 118, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _value(column: str, value: float) -> str:
    return f"{value:.3g}{_UNITS.get(column.partition('_')[2], '')}"


def _legend() -> str:
    return wrapped(
        "Each cell is *ok* or the letter of an [exception](#exceptions). Bodies that would topple or slide off are "
        "guided along the vertical; the others are free."
    )


def _at_rest(found: Sequence[Row]) -> Iterator[str]:
    lines = [f"| skin | shape | {' | '.join(MODELS)} |", "|---|---|" + "---|" * len(MODELS)]
    plain = [row for row in found if row["check"] == "rest" and _usual(row)]
    for skin in distinct(plain, "skin"):
        for shape in distinct(plain, "shape"):
            cells = [
                _cell([row for row in plain if (row["skin"], row["shape"], row["model"]) == (skin, shape, model)])
                for model in MODELS
            ]
            lines.append(f"| {skin} | {shape} | {' | '.join(cells)} |")
    yield "\n".join(lines)


def _usual(row: Row) -> bool:
    return (row["integrator"], row["timestep_ms"], row["ratio"]) == ("implicitfast", 1.0, 5)


def _cell(found: Sequence[Row]) -> str:
    """Return the text of a cell: the worst verdict of its rows."""
    letters = sorted({_letter(row) for row in found if row["verdict"] == OUTSIDE})
    if letters:
        return ", ".join(letters)
    rejected = sum(row["verdict"] == REJECTED for row in found)
    if rejected == len(found):
        return "rejected" if found else ""
    return f"{OK}, {rejected} of {len(found)} rejected" if rejected else OK


def _letter(row: Row) -> str:
    known = exception_of(row)
    assert known is not None, row
    return _letters()[known.reason]


def _letters() -> dict[str, str]:
    reasons = dict.fromkeys(known.reason for known in EXCEPTIONS)
    return {reason: chr(ord("A") + number) for number, reason in enumerate(reasons)}


def _checks(found: Sequence[Row]) -> Iterator[str]:
    lines = [f"| check | skin | {' | '.join(MODELS)} |", "|---|---|" + "---|" * len(MODELS)]
    others = [row for row in found if row["check"] != "rest"]
    for check in distinct(others, "check"):
        for skin in distinct([row for row in others if row["check"] == check], "skin"):
            cells = [
                _cell([r for r in others if (r["check"], r["skin"], r["model"]) == (check, skin, model)])
                for model in MODELS
            ]
            lines.append(f"| {check} | {skin} | {' | '.join(cells)} |")
    yield "\n".join(lines)
    yield wrapped(
        "*stick*: on a slope at 95 % of the friction angle; *slip*: 5 degrees beyond it; *impact*: a fall of 10 mm, "
        "read every 1, 5 or 20 steps; *decay*: return to rest from a deeper start, compared with c / (2 m) of the "
        "spring and damper of the contact (MuJoCo's impedance of 0.5 adds the body's mass once more); *third law*: "
        "two skins pressed together; *mirror*: loads at mirrored places of a regular grid of taxels."
    )


def _steps(found: Sequence[Row]) -> Iterator[str]:
    solver = [row for row in found if row["physics"] == "solver" and row["model"] == "punch"]
    soft = [row for row in found if row["model"] == "foundation"]
    lines = [
        f"| integrator | contacts of | {' | '.join(f'{step:g} ms' for step in STEPS_MS)} |",
        "|---|---|" + "---|" * len(STEPS_MS),
    ]
    for integrator in distinct(found, "integrator"):
        for title, chosen in (("the solver", solver), ("foundation", soft)):
            cells = []
            for step in STEPS_MS:
                here = [
                    r
                    for r in chosen
                    if (r["integrator"], r["timestep_ms"]) == (integrator, step) and r["skin"] == "flat"
                ]
                counts = [sum(row["verdict"] == verdict for row in here) for verdict in (OK, OUTSIDE, REJECTED)]
                cells.append(
                    ", ".join(
                        f"{count} {word}" for count, word in zip(counts, (OK, OUTSIDE, REJECTED), strict=True) if count
                    )
                )
            lines.append(f"| {integrator} | {title} | {' | '.join(cells)} |")
    yield wrapped(
        "Number of checks on flat skin by integrator and time step (contacts of the solver: `punch`). All combinations "
        "of guided, free, scripted and stacked bodies with integrators and steps are included; shapes and ratios of "
        "tick to step are distributed so that each pair of values occurs."
    )
    yield "\n".join(lines)
    yield wrapped(
        "*rejected*: the program names the cause and the longest possible step. Examples are a probe of 0.2 kg at 4 ms "
        "with 20 kN/m, the foundation at 4 ms under a face, and friction with the foundation, which has none. A free "
        "body too light for the step touches with less than the stated stiffness, which the program states."
    )


def _exceptions(found: Sequence[Row]) -> Iterator[str]:
    lines = []
    for reason, letter in _letters().items():
        hit = [row for row in found if row["verdict"] == OUTSIDE and _letter(row) == letter]
        beyond = []
        for column, limit in TOLERANCES.items():
            largest = max((abs(row[column]) for row in hit if row[column] is not None), default=0.0)
            if largest > limit:
                beyond.append(f"{_NAMES[column]} {_value(column, largest)}")
        extent = f"; up to {', '.join(beyond)}" if beyond else ""
        lines.append(wrapped(f"- **{letter}** ({len(hit)} row{'s' * (len(hit) > 1)}{extent}): {reason}.", "  "))
    yield "\n".join(lines)


def main() -> None:
    """Write the page, after taking a table where one is given."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--tables", type=Path, help="a folder that tactile-maps study contact wrote")
    folder = parser.parse_args().tables
    if folder is not None:
        text = as_shipped((folder / "contact.csv").read_text(encoding="utf8"), COLUMNS)
        (TABLES / "contact.csv").write_text(text, encoding="utf8", newline="")
    PAGE.write_text(page(), encoding="utf8", newline="")


if __name__ == "__main__":
    main()
