"""The menus, as a table over the actions; what a menu lists by itself (robots, recent files) is added here too."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu

from app.robots.library import list_robots
from widgets.common.controller_settings import CONTROLLERS, SETTING_CHOICES
from widgets.common.settings import MARKS, BaseLayer

if TYPE_CHECKING:
    from widgets.presenters.file_presenter import FilePresenter
    from widgets.window.main_window import MainWindow


SEPARATOR = ""
"""Between groups."""
ALIGN = ("align_left", "align_centre", "align_right", SEPARATOR, "align_top", "align_middle", "align_bottom")
MENUS = (
    (
        "Edit",
        (
            "undo",
            "redo",
            SEPARATOR,
            "arrange",
            "pins",
            "seams",
            "interest",
            SEPARATOR,
            "add_pin",
            "remove_pin",
            "select_pins",
            SEPARATOR,
            "propose_seam",
            "mirror",
            "true_size",
            "repack",
            SEPARATOR,
            "hide_patches",
            "show_patches",
            SEPARATOR,
            "cancel_edit",
        ),
    ),
    ("Session", ("pause", "step", "reset", "record")),
    ("Touch", ("save_script", "play_script", SEPARATOR, "weigh")),
    (
        "Control",
        (
            "draw_path",
            "set_target",
            SEPARATOR,
            "more_force",
            "less_force",
            SEPARATOR,
            "clear_path",
            "start_again",
            SEPARATOR,
            "reset_gains",
            "compare_controllers",
        ),
    ),
    (
        "Select",
        (
            "poke",
            SEPARATOR,
            "select_box",
            "select_lasso",
            "select_brush",
            "smaller_brush",
            "larger_brush",
            SEPARATOR,
            "select_all",
            "select_none",
            "select_inverse",
        ),
    ),
    (
        "View",
        ("frame", "morph", "compare", "theme", "panels", "timing", "effects", "plots", "reset_layout", "full_screen"),
    ),
    ("Help", ("keys", "about")),
)

OVERLAY = (
    *(f"ground_{ground.value}" for ground in BaseLayer),
    SEPARATOR,
    *(f"mark_{name}" for name in MARKS),
)

PATHS = ("path_polyline", "path_spline", "path_lemniscate", "path_raster")

SUBMENUS = (
    ("Align", "Edit", "true_size", ALIGN),
    ("Controller", "Control", "draw_path", tuple(f"controller_{controller}" for controller in CONTROLLERS)),
    ("Task", "Control", "draw_path", tuple(f"task_{task}" for task in SETTING_CHOICES["task"][1])),
    ("Path shape", "Control", "more_force", PATHS),
    ("Overlay", "View", "theme", OVERLAY),
)
"""Title, the menu it is in, before which action, and its actions."""


def build_menus(window: MainWindow, commands: FilePresenter) -> None:
    """Fill the window's menu bar."""
    bar = window.menuBar()
    _build_file_menu(window, commands, bar.addMenu("File"))
    for title, names in MENUS:
        menu = bar.addMenu(title)
        menu.setToolTipsVisible(True)
        add_actions(menu, window, names)
        for inner, within, before, inner_names in SUBMENUS:
            if title == within:
                submenu = QMenu(inner, menu)
                submenu.setToolTipsVisible(True)
                menu.insertMenu(window.action(before), submenu)
                add_actions(submenu, window, inner_names)


def add_actions(menu: QMenu, window: MainWindow, names: tuple[str, ...]) -> None:
    """Add the actions called ``names``, with lines between groups."""
    for name in names:
        if name == SEPARATOR:
            menu.addSeparator()
        else:
            menu.addAction(window.action(name))


def _build_file_menu(window: MainWindow, commands: FilePresenter, file: QMenu) -> None:
    file.addAction(window.action("open_robot"))
    robots = file.addMenu("Robots")
    for entry in list_robots():
        item = robots.addAction(entry.title)
        item.setObjectName(f"robot-{entry.name}")
        item.setEnabled(entry.available)
        item.setToolTip(entry.remedy)
        item.triggered.connect(partial(commands.open_robot, entry.name))
    robots.setToolTipsVisible(True)
    scenes = file.addMenu("Open scene")
    scenes.setObjectName("scenes")
    window.scene_file_presenter.fill(scenes)
    add_actions(file, window, ("import_taxels", "open_recording"))
    recent = file.addMenu("Recent files")
    recent.aboutToShow.connect(partial(_list_recent, recent, window, commands))
    file.addSeparator()
    add_actions(
        file,
        window,
        (
            "open_map",
            "save_map",
            "save_map_as",
            "export_map",
            SEPARATOR,
            "save_scene",
            SEPARATOR,
            "save_picture",
            SEPARATOR,
            "quit",
        ),
    )


def _list_recent(menu: QMenu, window: MainWindow, commands: FilePresenter) -> None:
    menu.clear()
    for path in window.settings.recent:
        menu.addAction(path).triggered.connect(partial(commands.open_path, path))
    if menu.isEmpty():
        menu.addAction("Nothing opened yet").setEnabled(False)
