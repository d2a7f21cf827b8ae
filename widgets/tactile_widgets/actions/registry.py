"""Definitions of actions and menus, and the Qt actions and menus made from them.

``ActionRegistry.show`` enables, checks and names all actions in one pass from one ``WindowState``: presenters never
enable an action.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from tactile_maps.core.errors import install_line, is_installed
from tactile_widgets.actions.icons import icon
from tactile_widgets.actions.keymap import KeyMap
from tactile_widgets.actions.mnemonics import choose_mnemonics, with_mnemonic
from tactile_widgets.actions.state import StateRule, WindowState, always
from tactile_widgets.common.colours import Theme, mixed

StateText = Callable[[WindowState], str]


@dataclass(frozen=True)
class ActionSpec:
    """Definition of an action.

    Attributes:
        name: Identifier, for code and tests.
        text: Text in menus; begins with a verb.
        shortcuts: Default shortcuts, separated by spaces; the first is displayed. The user may change them.
        tip: Tool tip; the shortcut is appended.
        enabled: Rule that enables it.
        yields: Whether a focused control takes its default shortcuts first: Space presses a button.
        checked: Rule that checks it; None unless the state determines it.
        checkable: Whether a click checks it, independently of the state.
        group: Group in which exactly one action is checked; may be empty.
        text_for: Text that depends on the state.
        refusal_for: Reason why the state disables it, shown as its tool tip; empty where that is obvious.
        icon: Icon of its button; empty if there is none.
        icon_for: Icon that depends on the state.
        toolbar: Group of buttons in the toolbar; empty if there is none.
        needs: Module of an optional package without which it is disabled; empty if there is none.
        extra: Extra of the program that installs this package.
    """

    name: str
    text: str
    shortcuts: str = ""
    tip: str = ""
    enabled: StateRule = always
    yields: bool = False
    checked: StateRule | None = None
    checkable: bool = False
    group: str = ""
    text_for: StateText | None = None
    refusal_for: StateText | None = None
    icon: str = ""
    icon_for: StateText | None = None
    toolbar: str = ""
    needs: str = ""
    extra: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """Default shortcuts."""
        return tuple(self.shortcuts.split())


@dataclass(frozen=True)
class Line:
    """Separator in a menu."""


LINE = Line()


@dataclass(frozen=True)
class MenuList:
    """Menu whose entries are listed each time it is opened, by the function for ``name``."""

    name: str
    title: str


@dataclass(frozen=True)
class Menu:
    """Menu with its entries in order."""

    title: str
    items: tuple[ActionSpec | Line | MenuList | Menu, ...]


def specs_in(menus: Sequence[Menu]) -> Iterator[ActionSpec]:
    """Yield the actions of menus and submenus, in order."""
    for menu in menus:
        for item in menu.items:
            if isinstance(item, Menu):
                yield from specs_in([item])
            elif isinstance(item, ActionSpec):
                yield item


def menu_letters(menus: Sequence[Menu]) -> list[str]:
    """Return the mnemonics of the menu bar, avoiding letters that are shortcuts of actions with Alt."""
    keys = (key for spec in specs_in(menus) for key in spec.keys)
    return choose_mnemonics([menu.title for menu in menus], {key[-1].lower() for key in keys if key[:-1] == "Alt+"})


def entry_letters(menu: Menu) -> list[str]:
    """Return the mnemonics of the entries of a menu, in order; empty for separators."""
    return choose_mnemonics(
        [item.text if isinstance(item, ActionSpec) else getattr(item, "title", "") for item in menu.items]
    )


def _action_letters(menus: Sequence[Menu]) -> Iterator[tuple[str, str]]:
    """Yield name and mnemonic of each action."""
    for menu in menus:
        for item, letter in zip(menu.items, entry_letters(menu), strict=True):
            if isinstance(item, Menu):
                yield from _action_letters([item])
            elif isinstance(item, ActionSpec):
                yield item.name, letter


class ActionRegistry:
    """The Qt actions of a window.

    Args:
        parent: Window that owns the actions and in which their shortcuts work.
        theme: Colours of the icons.
        menus: Menu bar with all actions except the remedies.
        remedies: Actions that only messages offer.

    Attributes:
        keymap: Shortcuts of the actions.
        install: Commands that install the missing packages of disabled actions, by the name of the action.
    """

    def __init__(
        self,
        parent: QWidget,
        theme: Theme,
        *,
        menus: Sequence[Menu],
        remedies: Sequence[ActionSpec] = (),
    ) -> None:
        self.menus = tuple(menus)
        self.specs = (*specs_in(menus), *remedies)
        self._theme = theme
        self._state = WindowState()
        self._icons: dict[str, str] = {}
        optional = (spec for spec in self.specs if spec.needs and not is_installed(spec.needs))
        self.install = {spec.name: install_line(spec.extra) for spec in optional}
        groups: dict[str, QActionGroup] = {}
        self._letters = dict(_action_letters(menus))
        self.keymap = KeyMap({spec.name: spec.keys for spec in self.specs})
        self._actions = {spec.name: self._make_action(spec, parent, groups) for spec in self.specs}
        for spec in self.specs:
            parent.addAction(self._actions[spec.name])
        self.show(self._state)

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the shortcuts of an action; the first is displayed."""
        return self.keymap.keys(name)

    def use_keys(self, keymap: KeyMap) -> None:
        """Replace the shortcuts, in menus and tool tips too."""
        self.keymap = keymap
        for spec in self.specs:
            self._set_keys(self._actions[spec.name], spec)

    def trigger_key(self, key: str) -> None:
        """Trigger the action of a shortcut that a view received, if the action is enabled."""
        if (name := self.keymap.owner(key)) is not None:
            self._actions[name].trigger()

    def in_toolbar(self, group: str) -> list[ActionSpec]:
        """Return the actions of a group of buttons, in order."""
        return [spec for spec in self.specs if spec.toolbar == group]

    def bind(self, **handlers: Callable[[], object]) -> None:
        """Call a handler whenever the action of that name is triggered."""
        for name, handler in handlers.items():
            self._actions[name].triggered.connect(partial(self._run, handler))

    def _run(self, handler: Callable[[], object], _checked: bool = False) -> None:
        handler()
        self.show(self._state)  # the click has checked the action, even if the handler changed nothing

    def show(self, state: WindowState) -> None:
        """Enable, check and name all actions for a state. Cost: 0.3 ms."""
        self._state = state
        for spec in self.specs:
            action = self._actions[spec.name]
            action.setEnabled(spec.enabled(state) and spec.name not in self.install)
            if spec.checked is not None and (checked := spec.checked(state)) != action.isChecked():
                action.setChecked(checked)
            if spec.text_for is not None:
                action.setText(self._text(spec, spec.text_for(state)))
            if spec.refusal_for is not None:
                self._set_tip(action, spec)
            shape = spec.icon if spec.icon_for is None else spec.icon_for(state)
            if shape and self._icons.get(spec.name) != shape:
                self._icons[spec.name] = shape
                self._draw(action, shape)

    def set_theme(self, theme: Theme) -> None:
        """Draw the icons in another theme."""
        self._theme = theme
        for name, shape in self._icons.items():
            self._draw(self._actions[name], shape)

    def _make_action(self, spec: ActionSpec, parent: QWidget, groups: dict[str, QActionGroup]) -> QAction:
        action = QAction(self._text(spec, spec.text), parent)
        action.setObjectName(f"action-{spec.name}")
        self._set_keys(action, spec)
        action.setCheckable(spec.checked is not None or spec.checkable)
        if spec.group:
            groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        return action

    def _set_keys(self, action: QAction, spec: ActionSpec) -> None:
        keys = self.keys(spec.name)
        action.setShortcuts([QKeySequence(key) for key in keys])
        self._set_tip(action, spec)

    def _set_tip(self, action: QAction, spec: ActionSpec) -> None:
        keys = self.keys(spec.name)
        refusal = "" if spec.refusal_for is None else spec.refusal_for(self._state)
        tip = refusal or (f"{spec.tip} ({key_text(keys[0])})" if keys else spec.tip)
        if command := self.install.get(spec.name):
            tip += f". Not installed; run this command, then start the program again: {command}"
        action.setToolTip(tip)
        action.setStatusTip(tip)

    def _text(self, spec: ActionSpec, text: str) -> str:
        """Return a text of an action with its mnemonic."""
        return with_mnemonic(text, self._letters.get(spec.name, ""))

    def _draw(self, action: QAction, shape: str) -> None:
        theme = self._theme
        colour = theme.fault if shape in ("record", "stop") else theme.text
        action.setIcon(icon(shape, colour, disabled=mixed(theme.panel, theme.quiet, 0.65)))


_ARROWS = {"Up": "↑", "Down": "↓", "Left": "←", "Right": "→"}


def key_text(keys: str) -> str:
    """Return a shortcut as displayed, with arrows for the arrow keys."""
    return "+".join(_ARROWS.get(key, key) for key in keys.split("+")) if keys != "+" else keys


def key_rows(menus: Sequence[Menu]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the title of each menu with the names and texts of its actions."""
    return [(menu.title, [(spec.name, spec.text.rstrip("…")) for spec in specs_in([menu])]) for menu in menus]


def taken_by_menus(menus: Sequence[Menu]) -> dict[str, str]:
    """Return the keys that open a menu, each with a description."""
    return {
        f"Alt+{letter.upper()}": f"opening the menu {menu.title}"
        for menu, letter in zip(menus, menu_letters(menus), strict=True)
        if letter
    }


def build_menus(bar: QMenuBar, actions: ActionRegistry, lists: Mapping[str, Callable[[QMenu], None]]) -> None:
    """Fill a menu bar with the menus of ``actions``.

    Args:
        bar: Menu bar of the window.
        actions: Actions and menus.
        lists: Function for the name of each ``MenuList`` that fills it when it is opened.
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
