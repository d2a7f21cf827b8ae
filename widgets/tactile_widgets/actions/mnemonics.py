"""Mnemonics: letters that select the entries of a menu by keyboard, unique within each menu."""

from __future__ import annotations

from collections.abc import Collection, Sequence


def choose_mnemonics(texts: Sequence[str], taken: Collection[str] = ()) -> list[str]:
    """Choose a different letter for each text: preferably the first letter of a word, or another letter of the text.

    Args:
        texts: The entries of one menu, in order; earlier ones have precedence.
        taken: Letters in lower case that have another use.

    Returns:
        Letters in lower case; empty for a text whose letters are all in use.
    """
    candidates = [[letter for letter in _candidates(text) if letter not in taken] for text in texts]
    owners: dict[str, int] = {}
    for number in range(len(texts)):
        _assign(number, candidates, owners, set())
    letters = {owner: letter for letter, owner in owners.items()}
    return [letters.get(number, "") for number in range(len(texts))]


def with_mnemonic(text: str, letter: str) -> str:
    """Return a text with ``&`` before the letter, at the start of a word if possible."""
    words = text.replace("&", "&&")
    lower = text.replace("&", "&&").lower()
    starts = [at for at, char in enumerate(lower) if char == letter]
    if not letter or not starts:
        return words
    at = next((start for start in starts if start == 0 or not lower[start - 1].isalnum()), starts[0])
    return f"{words[:at]}&{words[at:]}"


def without_mnemonic(text: str) -> str:
    """Return a text of Qt as displayed."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&")


def _candidates(text: str) -> list[str]:
    letters = [char for char in text.lower() if char.isascii() and char.isalnum()]
    initials = [word[0] for word in text.lower().split() if word[0].isascii() and word[0].isalnum()]
    return list(dict.fromkeys((*initials, *letters)))


def _assign(number: int, candidates: Sequence[Sequence[str]], owners: dict[str, int], seen: set[str]) -> bool:
    """Assign the first free letter to a text, or one whose owner can use another (augmenting path)."""
    for letter in candidates[number]:
        if letter not in owners:
            owners[letter] = number
            return True
    for letter in candidates[number]:
        if letter not in seen:
            seen.add(letter)
            if _assign(owners[letter], candidates, owners, seen):
                owners[letter] = number
                return True
    return False
