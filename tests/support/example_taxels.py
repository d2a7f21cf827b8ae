"""Hand-written taxel sets, and a strip of iCub modules with a known map, for tests of foreign files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactile_maps.skin.formats.icub.layout import IcubLayout, LayoutModule
from tactile_maps.skin.formats.icub.positions import ROWS_PER_MODULE, THERMAL_PADS
from tactile_maps.skin.model.taxel_set import TaxelSet

ARRAYS = ("numbers", "positions", "normals", "faces", "points", "modules")


def dome(count: int = 12, **changes: object) -> TaxelSet:
    """Return taxels on a ball of 50 mm, with normals, a map, and unordered ids with gaps."""
    turn = 2.4 * np.arange(count)
    down = 0.1 + 1.2 * np.sqrt(np.arange(count) / count)
    normals = np.stack([np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down)], axis=1)
    fields = {
        "name": "dome",
        "link": "hand",
        "numbers": (7 * np.arange(count) + 3) % (7 * count),
        "positions": 0.05 * normals + [0.1, -0.2, 0.3],
        "normals": normals,
        "points": 0.05 * down[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1),
        "modules": np.arange(count) // 4,
    }
    return TaxelSet(**(fields | changes))


def strip(count: int = 9, *, radius: float = 0.06) -> tuple[TaxelSet, IcubLayout]:
    """Return a strip of modules around a tube, and the layout that is its true map."""
    modules = tuple(
        LayoutModule(k + 2, 0.016 * k, 0.00924 * (k % 2), np.deg2rad([0, 60][k % 2]), mirrored=k % 3 == 0)
        for k in range(count)
    )
    layout = IcubLayout("strip", modules)
    felt = ~np.isin(layout.numbers % ROWS_PER_MODULE, THERMAL_PADS)
    x, y = layout.points[felt].T
    positions = np.stack([radius * np.sin(x / radius), radius * np.cos(x / radius), y], axis=1)
    return TaxelSet("strip", "arm", layout.numbers[felt], positions), layout


def assert_equal(first: TaxelSet, second: TaxelSet, *, arrays: tuple[str, ...] = ARRAYS, atol: float = 1e-14) -> None:
    """Assert that taxels and their order are equal in all ``arrays``."""
    for name in arrays:
        one = getattr(first, name)
        other = getattr(second, name)
        assert (one is None) == (other is None), name
        if one is not None:
            np.testing.assert_allclose(one, other, rtol=0, atol=atol, err_msg=name)


def write_icub_layout(layout: IcubLayout, path: Path) -> None:
    """Write ``layout`` for the viewer."""
    lines = ["[SENSORS]", "# kind number x y orientation gain mirror layoutNum"]
    lines += [
        f"{m.kind.name} {m.number} {1e3 * m.x:.10g} {1e3 * m.y:.10g} {np.rad2deg(m.angle):.10g} {m.gain:.10g} "
        f"{int(m.mirrored)} {int(m.backwards)}"
        for m in layout.modules
    ]
    path.write_text("\n".join(lines))
