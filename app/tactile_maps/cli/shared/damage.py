"""Rows about the damage of a recording, separate from ``output``, which the command line loads without NumPy."""

from __future__ import annotations

from collections.abc import Sequence


def damage_rows(damage: Sequence[str]) -> dict[str, object]:
    """Return rows for ``print_fields``: if a recording is complete, and descriptions of what it has lost."""
    return {"Complete": "no", "Damage": "; ".join(damage)} if damage else {"Complete": "yes"}
