"""Fills a menu bar from the tree of menus."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtWidgets import QMenu, QMenuBar

from tactile_widgets.actions.mnemonics import with_mnemonic
from tactile_widgets.actions.registry import (
    ActionRegistry,
    ActionSpec,
    Line,
    Menu,
    MenuList,
    entry_letters,
    menu_letters,
)


def build_menus(bar: QMenuBar, actions: ActionRegistry, lists: Mapping[str, Callable[[QMenu], None]]) -> None:
    """Fill a menu bar with the menus of ``actions``.

    Args:
        bar: The window's.
        actions: What can be chosen, and where it stands.
        lists: Fill each ``MenuList`` when it is opened, by its name.
    """
    for menu, letter in zip(actions.menus, menu_letters(actions.menus), strict=True):
        _fill(bar.addMenu(with_mnemonic(menu.title, letter)), menu, actions, lists)


def _fill(menu: QMenu, spec: Menu, actions: ActionRegistry, lists: Mapping[str, Callable[[QMenu], None]]) -> None:
    menu.setToolTipsVisible(True)
    for item, letter in zip(spec.items, entry_letters(spec), strict=True):
        if isinstance(item, ActionSpec):
            menu.addAction(actions[item.name])
        elif isinstance(item, Line):
            menu.addSeparator()
        elif isinstance(item, MenuList):
            inner = menu.addMenu(with_mnemonic(item.title, letter))
            inner.setObjectName(item.name)
            inner.setToolTipsVisible(True)
            inner.aboutToShow.connect(partial(lists[item.name], inner))
        else:
            _fill(menu.addMenu(with_mnemonic(item.title, letter)), item, actions, lists)
