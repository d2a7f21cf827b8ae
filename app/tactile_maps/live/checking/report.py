"""The result of a guided check as a self-contained web page: parts, faulty channels, a map, and all readings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import datetime
from html import escape
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import write_atomically
from tactile_maps.live.checking.parts import part_numbers
from tactile_maps.live.checking.skin_check import Outcome, SkinCheck
from tactile_maps.live.checking.verdicts import FAULT_TEXTS, ChannelFault, Verdicts, verdicts_of
from tactile_maps.maps.formats.html_page import facts_html, page_html, rows_html
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import number_ranges

_PICTURE = 900.0
"""Width of the drawing of the map [px]."""
_MARKS = {
    ChannelFault.UNHEARD: ("?", "#868e96"),
    ChannelFault.DEAD: ("x", "#e03131"),
    ChannelFault.STUCK: ("s", "#e03131"),
    ChannelFault.NOISY: ("n", "#f59f00"),
    ChannelFault.SATURATED: ("f", "#f59f00"),
    ChannelFault.INVERTED: ("i", "#845ef7"),
    ChannelFault.SWAPPED: ("w", "#845ef7"),
    ChannelFault.NOT_FELT: ("-", "#868e96"),
}
"""Letter and colour of each fault in the drawing."""


def fault_counts(verdicts: Verdicts) -> dict[str, int]:
    """Return the number of channels with each fault."""
    return {str(fault): int(those.sum()) for fault, those in verdicts.faults.items()}


def channels_text(check: SkinCheck, verdicts: Verdicts) -> str:
    """Return the number of channels with each fault in words; without faults, whether channels were checked."""
    if faults := ", ".join(f"{count} {name}" for name, count in fault_counts(verdicts).items() if count):
        return faults
    return "all that were pressed work" if check.any_pressed else "not checked: nothing was pressed"


def outcome_counts(check: SkinCheck) -> dict[str, int]:
    """Return the number of parts with each outcome."""
    return {str(outcome): sum(result.outcome is outcome for result in check.results) for outcome in Outcome}


def swap_texts(check: SkinCheck, verdicts: Verdicts) -> tuple[str, ...]:
    """Return the swapped parts and channels in words."""
    texts = []
    for swap in verdicts.swaps:
        if swap.parts:
            texts.append(f"{swap.parts[0]} with {swap.parts[1]}")
            continue
        first, second = (", ".join(map(check.skin.taxel_text, side)) for side in (swap.first, swap.second))
        texts.append(f"{first} with {second}")
    return tuple(texts)


def check_facts(prepared: PreparedScene, source: str, unit: str, started: datetime) -> dict[str, object]:
    """Return date, source and files of a check for its report.

    Args:
        prepared: Scene with the skin.
        source: Address of the readings.
        unit: Their unit.
        started: Start of the check, with its time zone.
    """
    scene = prepared.scene
    return {
        "Date": started.strftime("%Y-%m-%d %H:%M %Z"),
        "Source": source,
        "Skin": ", ".join(map(str, scene.taxel_files)) or f"cover of {scene.robot}",
        "Robot": scene.robot,
        "Taxels": len(prepared.skin),
        "Unit": unit,
    }


def write_check_report(
    check: SkinCheck, path: str | Path, facts: Mapping[str, object], *, points: FloatArray | None = None
) -> Path:
    """Write the page.

    Args:
        check: The check, at its end or before.
        path: The file; an existing one is replaced.
        facts: Date, source and files of the check, by name.
        points: (taxels, 2) places of the taxels on the map [m] for the drawing; None for a page without one.

    Returns:
        The file.

    Raises:
        ExportError: It cannot be written.
    """
    write_atomically(Path(path), page_html("Check of a skin", _body(check, facts, points)).encode(), error=ExportError)
    return Path(path)


def _body(check: SkinCheck, facts: Mapping[str, object], points: FloatArray | None) -> str:
    verdicts = verdicts_of(check)
    settings = check.settings
    counts = {name: count for name, count in fault_counts(verdicts).items() if count}
    summary = {
        **facts,
        "Readings": check.readings,
        "Noise at rest": f"median {np.median(check.noise):.3g}, largest {check.noise.max():.3g}",
        "Felt from": f"six standard deviations of the noise, at least {settings.least:g}",
        "Direction": "values fall under pressure" if verdicts.falls else "values rise under pressure",
        "Order": "as requested" if settings.ordered else "any touches of a recording",
        "Parts": ", ".join(f"{count} {name}" for name, count in outcome_counts(check).items() if count),
        "Channels": channels_text(check, verdicts),
    }
    body = facts_html(summary)
    if swaps := swap_texts(check, verdicts):
        body += "<h2>Swapped</h2><ul>" + "".join(f"<li>{escape(text)}</li>" for text in swaps) + "</ul>"
    rows = list(_fault_rows(check, verdicts))
    if rows:
        body += f"<h2>Faulty channels</h2>{rows_html(rows)}"
        said = [
            f"<strong>{fault}</strong>: {escape(FAULT_TEXTS[fault])}." for fault in ChannelFault if counts.get(fault)
        ]
        body += f'<p class="note">{"<br>".join(said)}</p>'
    if points is not None:
        body += f"<h2>Map</h2>{_drawing(check, verdicts, points)}"
    if boards := board_rows(check, verdicts):
        body += f"<h2>Boards</h2>{rows_html(boards)}"
    body += f"<h2>Parts</h2>{rows_html(list(_part_rows(check, verdicts)))}"
    return body + f"<h2>All channels</h2>{rows_html(list(_channel_rows(check, verdicts, range(len(check.skin)))))}"


def board_rows(check: SkinCheck, verdicts: Verdicts) -> list[dict[str, object]]:
    """Return what was felt of each board and its faults; empty where the boards are unknown.

    A board of which nothing was felt or received although several of its modules were pressed is named: its cable or
    supply is at fault rather than its channels.
    """
    parts = dict[str, list[int]]()
    for number, part in enumerate(check.parts):
        if part.board_name:
            parts.setdefault(part.board_name, []).append(number)
    rows = list[dict[str, object]]()
    for name, numbers in parts.items():
        own = np.concatenate([check.parts[number].taxels for number in numbers])
        faults = {str(fault): int(those[own].sum()) for fault, those in verdicts.faults.items()}
        asked = sum(check.results[number].outcome not in (Outcome.OPEN, Outcome.SKIPPED) for number in numbers)
        felt = int(check.felt[own].sum())
        mute = not felt and (not check.heard[own].any() or asked > 1)
        rows.append(
            {
                "board": name,
                "modules": number_ranges(np.array([check.parts[number].module for number in numbers])),
                "felt": f"{felt} of {len(own)}",
                "faults": ", ".join(f"{count} {fault}" for fault, count in faults.items() if count),
                "verdict": "no channel responds: check its cable and supply" if mute else "responds" if felt else "",
            }
        )
    return rows


def _part_rows(check: SkinCheck, verdicts: Verdicts) -> Iterator[dict[str, object]]:
    felt = check.felt
    peak = np.maximum(check.rise, check.fall)
    for part, result in zip(check.parts, check.results, strict=True):
        own = part.taxels
        faults = {str(fault): int(those[own].sum()) for fault, those in verdicts.faults.items()}
        yield {
            "part": part.name,
            "link": part.link,
            **({"board": part.board} if part.board_name else {}),
            "outcome": str(result.outcome),
            "responded": check.names(result.others),
            "felt": f"{int(felt[own].sum())} of {len(own)}",
            "largest change": float(peak[own].max()),
            "median noise": float(np.median(check.noise[own])),
            "time [s]": result.seconds if check.settings.ordered else None,
            "faults": ", ".join(f"{count} {name}" for name, count in faults.items() if count),
        }


def _fault_rows(check: SkinCheck, verdicts: Verdicts) -> Iterator[dict[str, object]]:
    some = np.zeros(len(check.skin), dtype=bool)
    for those in verdicts.faults.values():
        some |= those
    part_of = part_numbers(check.skin, check.parts)
    taxels = np.flatnonzero(some)
    yield from _channel_rows(check, verdicts, taxels[np.argsort(part_of[taxels], kind="stable")].tolist())


def _channel_rows(check: SkinCheck, verdicts: Verdicts, taxels: range | list[int]) -> Iterator[dict[str, object]]:
    part_of = part_numbers(check.skin, check.parts)
    change = np.where(check.rise >= check.fall, check.rise, -check.fall)
    for taxel in taxels:
        part = check.parts[part_of[taxel]]
        name = check.skin.taxel_name(taxel)
        heard = bool(check.heard[taxel])
        yield {
            "part": part.name,
            "link": part.link,
            **({"board": part.board} if part.board_name else {}),
            "taxel": taxel,
            "id": name.id,
            "channel": name.channel,
            "verdict": ", ".join(map(str, verdicts.of(taxel))) or ("works" if check.felt[taxel] else "not checked"),
            "peak": float(check.extreme[taxel]) if heard and np.isfinite(check.extreme[taxel]) else None,
            "largest change": float(change[taxel]) if heard else None,
            "baseline": float(check.baseline[taxel]) if heard else None,
            "noise": float(check.noise[taxel]) if heard else None,
        }


def _drawing(check: SkinCheck, verdicts: Verdicts, points: FloatArray) -> str:
    """Return the taxels on the map: felt ones filled, faulty ones with the letter of their fault."""
    low = points.min(axis=0)
    size = np.maximum(points.max(axis=0) - low, 1e-9)
    scale = _PICTURE / float(size.max())
    radius = float(np.clip(0.35 * _PICTURE / np.sqrt(len(points)), 2.0, 12.0))
    margin = 2 * radius
    places = margin + scale * (points - low)
    places[:, 1] = 2 * margin + scale * size[1] - places[:, 1]  # up on the map is up in the drawing
    felt = check.felt
    marks = []
    for taxel, (x, y) in enumerate(places.tolist()):
        faults = verdicts.of(taxel)
        letter, colour = _MARKS[faults[0]] if faults else ("", "#22b8cf" if felt[taxel] else "none")
        words = (
            f"{check.skin.taxel_text(taxel)}: {', '.join(map(str, faults)) or ('felt' if felt[taxel] else 'not felt')}"
        )
        circle = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{colour}" stroke="var(--note)"/>'
        text = (
            f'<text x="{x:.1f}" y="{y + 0.35 * 1.6 * radius:.1f}" font-size="{1.6 * radius:.1f}" '
            f'text-anchor="middle" fill="#fff">{letter}</text>'
        )
        marks.append(f"<g><title>{escape(words)}</title>{circle}{text if letter else ''}</g>")
    found = [fault for fault, those in verdicts.faults.items() if those.any()]
    legend = ", ".join([*(f"{_MARKS[fault][0]} {fault}" for fault in found), "filled: felt", "empty: not felt"])
    width, height = (2 * margin + scale * size).tolist()
    return (
        f'<svg viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="Map of the taxels">{"".join(marks)}</svg>'
        f'<p class="note">{escape(legend)}</p>'
    )
