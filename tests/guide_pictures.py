"""Makes the pictures of the guide: ``python -m tests.guide_pictures assets/guide``. No display is needed.

The same pictures on the same machine; look at each before it is committed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("MPLBACKEND", "agg")

from PIL import Image
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication

import tactile_maps as tm
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import THEMES
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.tools.registry import PINS
from tactile_widgets.window.application import make_application, picture_window
from tests.tour import FRAME_MS, Film

SIZE = (1280, 800)
SCENES = {"window": ("arm", 1.5), "path": ("follow_path", 6.0), "touch": ("many_pokes", 1.0)}


def keep_small(path: Path) -> None:
    """Save with a palette and without alpha, which halves the size."""
    colours = Image.open(path).convert("RGB")
    few = colours.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


@contextmanager
def filmed(scene: tm.Scene) -> Iterator[Film]:
    """Return the window with a scene and without hints."""
    window = picture_window("dark", SIZE)
    try:
        window.live.show_prepared(tm.prepare(scene))
        window.hint_bar.hide()
        QApplication.processEvents()
        yield Film(window)
    finally:
        window.presenters.map_files.give_up()
        window.close()


def scene_picture(name: str, seconds: float, path: Path) -> None:
    """Show the window after some seconds of a scene."""
    with filmed(tm.load_scene(name)) as film:
        film.pass_time(round(1e3 * seconds / FRAME_MS))
        film.window.grab().save(str(path))


def edited_map(path: Path) -> None:
    """Show a map during editing: pins, one of them dragged, the area distortion, and the quality."""
    with filmed(replace(tm.load_scene("arm"), stimuli=())) as film:
        window = film.window
        skin = window.live.prepared.skin
        viewport = window.map_view.viewport()
        window.presenters.view.set_tool(PINS)
        places = [window.map_view.pixel_of(skin.taxel_point(taxel)).toPoint() for taxel in (20, 150, 300)]
        for place in places[:2]:
            film.drag(viewport, place, place)
        film.drag(viewport, places[2], places[2] + QPoint(-12, -24))
        window.presenters.view.set_base_layer(BaseLayer.AREA)
        window.live.measurements.map_executor.run_waiting()
        film.pass_time(4)
        window.grab().save(str(path))


def figure(path: Path) -> None:
    """Draw the figure of the README's example."""
    text = Path("README.md").read_text(encoding="utf8").split("```python\n")[1].split("```")[0]
    names: dict[str, Any] = {}
    with TemporaryDirectory() as folder, chdir(folder):  # the example saves a picture
        exec(text, names)
    ax = tm.draw_map(names["tactile_map"], names["frame"].pressures, contacts=names["frame"].regions)
    ax.figure.savefig(path, dpi=110, bbox_inches="tight")


def main() -> None:
    """Write all pictures into the folder named on the command line."""
    folder = Path(sys.argv[1])
    apply_theme(make_application(), THEMES["dark"])
    for name, (scene, seconds) in SCENES.items():
        scene_picture(scene, seconds, folder / f"{name}.png")
    edited_map(folder / "edit.png")
    figure(folder / "notebook.png")
    for name in (*SCENES, "edit", "notebook"):
        keep_small(folder / f"{name}.png")


if __name__ == "__main__":
    main()
