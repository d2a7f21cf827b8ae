"""Number of Hypothesis examples: all with ``--all``, a fifth by default."""

from __future__ import annotations

from typing import Any

from hypothesis import settings


def examples(count: int, **more: Any) -> settings:
    """Return settings for ``count`` examples with ``--all``, and by default for a fifth of them, at least five."""
    share = settings.default.max_examples / 100
    return settings(max_examples=max(min(count, 5), round(share * count)), **more)
