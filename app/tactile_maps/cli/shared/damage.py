"""Rows about the damage of a recording, separate from ``output``, which the command line loads without NumPy."""

from __future__ import annotations

from collections.abc import Sequence

from tactile_maps.recording.file.damage import RecordingDamage, damage_text


def damage_rows(damage: Sequence[RecordingDamage], tick: float) -> dict[str, object]:
    """Return rows for ``print_fields``: if a recording is complete, and what it has lost; its tick in seconds."""
    if not damage:
        return {"Complete": "yes"}
    return {"Complete": "no", "Damage": "; ".join(damage_text(one, tick) for one in damage)}
