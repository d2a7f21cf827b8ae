"""Search for taxels by a hardware id, a running number, a module with a channel, or a name."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, IntArray
from tactile_maps.core.errors import SkinError
from tactile_maps.skin.model.skin import Skin, identity_summary, identity_text

SEARCH_HINT = (
    "87012 for an id, l_hand:12 for an id on a link, #13 for a running number, 14/3 for module and channel, "
    "14/ for a whole module, or a name"
)
_PATTERN = re.compile(r"(#?)\s*([0-9]{1,10})|([0-9]{1,10})\s*/\s*([0-9]{0,10})")


@dataclass(frozen=True, eq=False)
class FoundTaxels(ArrayFields):
    """Result of a search.

    Attributes:
        taxels: (k,) running numbers, ascending; at least one.
        words: Description for the user.
    """

    taxels: IntArray
    words: str


def taxel_words(skin: Skin, taxel: int) -> str:
    """``id 87012, module 14, channel 3 (taxel 13)``, or ``taxel 13`` for a skin without ids."""
    name = str(skin.taxel_name(taxel))
    return f"{name} (taxel {taxel})" if name else f"taxel {taxel}"


def find_taxels(skin: Skin, text: str) -> FoundTaxels:
    """Return the taxels of ``skin`` that ``text`` names.

    A number alone is a hardware id if a taxel has that id, else a running number; with # before it, it is always a
    running number. Several taxels are found if boards repeat an id.

    Raises:
        SkinError: The text has another form, or names no taxel of the skin.
    """
    found = _PATTERN.fullmatch(text.strip())
    if len(named := skin.taxels_named(text.strip())):
        first = taxel_words(skin, int(named[0]))
        return FoundTaxels(named, first if len(named) == 1 else f"{len(named)} taxels, first {first}")
    link, colon, number = text.strip().rpartition(":")
    if colon and number.isdecimal() and len(on_link := skin.taxels_with_id(int(number[:18]), link=link)):
        return FoundTaxels(on_link, taxel_words(skin, int(on_link[0])))
    if found is None:
        raise SkinError("invalid name of a taxel", value=text.strip()[:40] or "nothing", remedy=f"Type {SEARCH_HINT}")
    mark, number, module, channel = found.groups()
    if module is not None:
        taxels = _on_module(skin, int(module), int(channel) if channel else None)
    else:
        taxels = skin.taxels_with_id(int(number)) if not mark else np.zeros(0, np.int64)
        if not len(taxels) and int(number) < len(skin):
            taxels = np.array([int(number)])
    if not len(taxels):
        known = identity_text(identity_summary(skin.identity))
        ends = f"taxels 0 to {len(skin) - 1}" + (f", {known}" if known else "; this skin states no ids")
        raise SkinError("unknown taxel", value=text.strip(), remedy=f"There are {ends}")
    first = taxel_words(skin, int(taxels[0]))
    return FoundTaxels(taxels, first if len(taxels) == 1 else f"{len(taxels)} taxels, first {first}")


def _on_module(skin: Skin, module: int, channel: int | None) -> IntArray:
    parts = []
    for patch, start in zip(skin.patches, skin.first[:-1], strict=True):
        identity = patch.taxels.identity
        if identity.modules is None or (channel is not None and identity.channels is None):
            continue
        found = identity.modules == module
        if channel is not None:
            found &= identity.channels == channel
        parts.append(start + np.flatnonzero(found))
    return np.concatenate(parts) if parts else np.zeros(0, np.int64)
