"""Error messages as sentences: they begin in lower case, as on the command line after "error:"."""

from __future__ import annotations


def as_sentence(text: str) -> str:
    """Return the text with a capital first letter, unless it begins with a file, an address or an identifier."""
    first = text.partition(" ")[0]
    return text[0].upper() + text[1:] if first.isalpha() else text
