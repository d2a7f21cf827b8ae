from __future__ import annotations

import pytest

from app.errors import SkinError
from app.skin.cover_spec import MAX_TAXELS, CoverSpec


def test_the_usual_cover() -> None:
    assert CoverSpec() == CoverSpec((), 1000, 0.003, 0)


@pytest.mark.parametrize("taxels", [-1, 3, MAX_TAXELS + 1])
def test_absurd_counts_are_refused(taxels: int) -> None:
    with pytest.raises(SkinError, match=f"found: {taxels}"):
        CoverSpec(taxels=taxels)


@pytest.mark.parametrize("thickness", [0.0, -1.0, 1.0, float("nan")])
def test_absurd_thicknesses_are_refused(thickness: float) -> None:
    with pytest.raises(SkinError, match="thickness"):
        CoverSpec(thickness=thickness)
