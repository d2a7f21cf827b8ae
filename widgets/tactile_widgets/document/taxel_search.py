"""Finding taxels by what a person types: a hardware id, a running number, or a module with a channel."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import IntArray, freeze_arrays
from tactile_maps.core.errors import SkinError
from tactile_maps.skin.model.skin import Skin, identity_summary, identity_text

SEARCH_HINT = (
    "87012 for an id, #13 for a running number, 14/3 for module and channel, 14/ for a whole module, or a name"
)
_WANTED = re.compile(r"(#?)\s*([0-9]{1,10})|([0-9]{1,10})\s*/\s*([0-9]{0,10})")


@dataclass(frozen=True, eq=False)
class FoundTaxels:
    """What was found.

    Attributes:
        taxels: (k,) running numbers, rising; at least one.
        words: Which they are, for a person.
    """

    taxels: IntArray
    words: str

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxels", dtype=np.int64)


def taxel_words(skin: Skin, taxel: int) -> str:
    """``id 87012, module 14, channel 3 (taxel 13)``, or ``taxel 13`` where the skin knows no more."""
    name = str(skin.taxel_name(taxel))
    return f"{name} (taxel {taxel})" if name else f"taxel {taxel}"


def find_taxels(skin: Skin, text: str) -> FoundTaxels:
    """The taxels of ``skin`` that ``text`` names.

    A number alone is a hardware id where a taxel has that id, and a running number otherwise; with # before it, it is
    always a running number. Several taxels are found where boards repeat an id.

    Raises:
        SkinError: The text is none of these, or there is no such taxel.
    """
    found = _WANTED.fullmatch(text.strip())
    if len(named := skin.taxels_named(text.strip())):
        first = taxel_words(skin, int(named[0]))
        return FoundTaxels(named, first if len(named) == 1 else f"{len(named)} taxels, first {first}")
    if found is None:
        raise SkinError("this names no taxel", value=text.strip()[:40] or "nothing", remedy=f"Type {SEARCH_HINT}")
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
        raise SkinError("there is no such taxel", value=text.strip(), remedy=f"There are {ends}")
    first = taxel_words(skin, int(taxels[0]))
    return FoundTaxels(taxels, first if len(taxels) == 1 else f"{len(taxels)} taxels, first {first}")


def _on_module(skin: Skin, module: int, channel: int | None) -> IntArray:
    parts = []
    for patch, start in zip(skin.patches, skin.first[:-1], strict=True):
        identity = patch.taxels.identity
        if identity.modules is None or (channel is not None and identity.channels is None):
            continue
        wanted = identity.modules == module
        if channel is not None:
            wanted &= identity.channels == channel
        parts.append(start + np.flatnonzero(wanted))
    return np.concatenate(parts) if parts else np.zeros(0, np.int64)
