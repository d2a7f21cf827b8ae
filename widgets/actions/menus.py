"""Fills a menu bar from the tree of menus."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtWidgets import QMenu, QMenuBar

from widgets.actions.registry import ActionRegistry, ActionSpec, Line, Menu, MenuList


def build_menus(bar: QMenuBar, actions: ActionRegistry, lists: Mapping[str, Callable[[QMenu], None]]) -> None:
    """Fill a menu bar with the menus of ``actions``.

    Args:
        bar: The window's.
        actions: What can be chosen, and where it stands.
        lists: Fill each ``MenuList`` when it is opened, by its name.
    """
    for menu in actions.menus:
        _fill(bar.addMenu(menu.title), menu, actions, lists)


def _fill(menu: QMenu, spec: Menu, actions: ActionRegistry, lists: Mapping[str, Callable[[QMenu], None]]) -> None:
    menu.setToolTipsVisible(True)
    for item in spec.items:
        if isinstance(item, ActionSpec):
            menu.addAction(actions[item.name])
        elif isinstance(item, Line):
            menu.addSeparator()
        elif isinstance(item, MenuList):
            inner = menu.addMenu(item.title)
            inner.setObjectName(item.name)
            inner.setToolTipsVisible(True)
            inner.aboutToShow.connect(partial(lists[item.name], inner))
        else:
            _fill(menu.addMenu(item.title), item, actions, lists)
