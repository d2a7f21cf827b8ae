"""Texts as sentences. Error messages begin in lower case, as on the command line after "error:"."""

from __future__ import annotations


def capitalized(text: str) -> str:
    """Return the text with a capital first letter, and the other letters unchanged."""
    return text[:1].upper() + text[1:]


def as_sentence(text: str) -> str:
    """Return the text with a capital first letter, unless it begins with a file, an address or an identifier."""
    first = text.partition(" ")[0]
    return capitalized(text) if first.isalpha() else text
