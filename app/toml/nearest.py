"""What was meant by a word that is not known."""

from __future__ import annotations

from difflib import get_close_matches


def nearest(word: str, known: tuple[str, ...]) -> str:
    """A remedy for a word that is not known: the nearest spelling, and all there are."""
    close = get_close_matches(word.lower(), known, n=1, cutoff=0.5)
    every = f"Choose one of: {', '.join(known)}" if known else "There are none"
    return f"Did you mean {close[0]}? {every}" if close else every
