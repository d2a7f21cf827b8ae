"""How many examples a property is tried on: all with ``--all``, a fifth by default."""

from __future__ import annotations

from typing import Any

from hypothesis import settings


def examples(count: int, **more: Any) -> settings:
    """Settings of a property that is tried ``count`` times with ``--all``; by default a fifth, not fewer than five."""
    share = settings.default.max_examples / 100
    return settings(max_examples=max(min(count, 5), round(share * count)), **more)
