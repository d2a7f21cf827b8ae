"""What a person says about a skin that places itself."""

from __future__ import annotations

from dataclasses import dataclass

from app.errors import SkinError

MAX_TAXELS = 20_000
BRIDGED = 3.0
"""A cover spans what a ball with a radius of this many thicknesses cannot roll into."""


@dataclass(frozen=True)
class CoverSpec:
    """A wanted cover.

    Attributes:
        links: Names of the links to cover; empty to choose the largest ones.
        taxels: How many in all, shared out by area.
        thickness: Of the cover over the link's mesh [m].
        seed: Of the one random choice: where each patch's first taxel lies.
    """

    links: tuple[str, ...] = ()
    taxels: int = 1000
    thickness: float = 0.003
    seed: int = 0

    def __post_init__(self) -> None:
        if not 4 <= self.taxels <= MAX_TAXELS:
            raise SkinError(
                "that number of taxels cannot be placed",
                place="taxels",
                value=self.taxels,
                remedy=f"Choose 4 to {MAX_TAXELS}",
            )
        if not 1e-4 <= self.thickness <= 0.1:
            raise SkinError(
                "that cover thickness cannot be made",
                place="thickness",
                value=f"{self.thickness} m",
                remedy="Choose 0.0001 to 0.1 m",
            )
