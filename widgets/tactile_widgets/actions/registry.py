"""What an action is, the tree of menus that lists all of them, and the actions made from it.

``ActionRegistry.show`` sets what is enabled, checked and said of every action in one pass from one ``WindowState``:
no presenter enables anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from tactile_widgets.actions.icons import icon
from tactile_widgets.actions.keymap import KeyMap
from tactile_widgets.actions.mnemonics import choose_mnemonics, with_mnemonic
from tactile_widgets.actions.state import WindowState, always
from tactile_widgets.common.colours import Theme, mixed

StateText = Callable[[WindowState], str]
StateRule = Callable[[WindowState], bool]


@dataclass(frozen=True)
class ActionSpec:
    """One action.

    Attributes:
        name: In code and for tests.
        text: In menus; a verb.
        keys: Shortcuts it ships with, the first is shown; a person may change them.
        tip: What it does; the key is added.
        enabled: Whether it can be asked for.
        yields: Whether the keys it ships with first belong to a control that has the focus: Space presses a button.
        checked: Whether it is down; None for one that is not checkable.
        checkable: Whether it stays down by itself, where no state says so.
        group: Of the actions of one group exactly one is down.
        text_for: Its text where that depends on the state.
        icon: Of the button; empty for none.
        icon_for: Its icon where that depends on the state.
        toolbar: The group of buttons it is among; empty for none.
    """

    name: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    enabled: StateRule = always
    yields: bool = False
    checked: StateRule | None = None
    checkable: bool = False
    group: str = ""
    text_for: StateText | None = None
    icon: str = ""
    icon_for: StateText | None = None
    toolbar: str = ""


@dataclass(frozen=True)
class Line:
    """A line between groups of a menu."""


LINE = Line()


@dataclass(frozen=True)
class MenuList:
    """A menu that lists what there is when it is opened; ``name`` says who fills it."""

    name: str
    title: str


@dataclass(frozen=True)
class Menu:
    """A menu and what is in it, in order."""

    title: str
    items: tuple[ActionSpec | Line | MenuList | Menu, ...]


def specs_in(menus: Sequence[Menu]) -> Iterator[ActionSpec]:
    """The actions of menus and those within them, in order."""
    for menu in menus:
        for item in menu.items:
            if isinstance(item, Menu):
                yield from specs_in([item])
            elif isinstance(item, ActionSpec):
                yield item


def menu_letters(menus: Sequence[Menu]) -> list[str]:
    """The mnemonics of the menu bar; Alt with a letter is the shortcut of some actions."""
    keys = (key for spec in specs_in(menus) for key in spec.keys)
    return choose_mnemonics([menu.title for menu in menus], {key[-1].lower() for key in keys if key[:-1] == "Alt+"})


def entry_letters(menu: Menu) -> list[str]:
    """The mnemonics of the entries of a menu, in order; empty for lines."""
    texts = ["" if isinstance(item, Line) else _entry_text(item) for item in menu.items]
    return choose_mnemonics(texts)


def _entry_text(item: ActionSpec | MenuList | Menu) -> str:
    return item.text if isinstance(item, ActionSpec) else item.title


def _action_letters(menus: Sequence[Menu]) -> Iterator[tuple[str, str]]:
    """Name and mnemonic of each action."""
    for menu in menus:
        for item, letter in zip(menu.items, entry_letters(menu), strict=True):
            if isinstance(item, Menu):
                yield from _action_letters([item])
            elif isinstance(item, ActionSpec):
                yield item.name, letter


class ActionRegistry:
    """The actions of a window, made once. Mutable: ``bind`` what they do, ``show`` a state, ``use_keys``.

    Args:
        parent: The window: owns them, and their keys act in it.
        theme: Colours of the icons.
        menus: All actions but the remedies, where the menu bar has them.
        remedies: Actions that are only offered by a message.

    Attributes:
        keymap: Which keys ask for which of them.
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
        self._bound: set[str] = set()
        self._icons: dict[str, str] = {}
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
        """The keys of an action, the first is shown."""
        return self.keymap.keys(name)

    def use_keys(self, keymap: KeyMap) -> None:
        """Take other keys: menus, tool tips and what the keyboard does follow at once."""
        self.keymap = keymap
        for spec in self.specs:
            self._give_keys(self._actions[spec.name], spec)

    def trigger_key(self, key: str) -> None:
        """Ask for what a key asks for, if that can be asked for now; a view that took the key gives it back so."""
        if (name := self.keymap.owner(key)) is not None:
            self._actions[name].trigger()

    def in_toolbar(self, group: str) -> list[ActionSpec]:
        """The actions of a group of buttons, in order."""
        return [spec for spec in self.specs if spec.toolbar == group]

    def bind(self, name: str, handler: Callable[[], object]) -> None:
        """Have ``handler`` called when a person asks for the action called ``name``."""

        def asked(_checked: bool = False) -> None:
            handler()
            self.show(self._state)  # what it did not change is as it was, though the button went down

        self._bound.add(name)
        self._actions[name].triggered.connect(asked)

    @property
    def bound(self) -> frozenset[str]:
        """The names of the actions that do something."""
        return frozenset(self._bound)

    def show(self, state: WindowState) -> None:
        """Enable, check and name all actions as a state has it. Cost: 0.3 ms."""
        self._state = state
        for spec in self.specs:
            action = self._actions[spec.name]
            action.setEnabled(spec.enabled(state))
            if spec.checked is not None and (checked := spec.checked(state)) != action.isChecked():
                action.setChecked(checked)
            if spec.text_for is not None:
                action.setText(self._text(spec, spec.text_for(state)))
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
        self._give_keys(action, spec)
        action.setCheckable(spec.checked is not None or spec.checkable)
        if spec.group:
            groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        return action

    def _give_keys(self, action: QAction, spec: ActionSpec) -> None:
        keys = self.keys(spec.name)
        action.setShortcuts([QKeySequence(key) for key in keys])
        tip = f"{spec.tip} ({key_text(keys[0])})" if keys else spec.tip
        action.setToolTip(tip)
        action.setStatusTip(tip)

    def _text(self, spec: ActionSpec, text: str) -> str:
        """A text of an action with the mnemonic that it has in its menu."""
        return with_mnemonic(text, self._letters.get(spec.name, ""))

    def _draw(self, action: QAction, shape: str) -> None:
        theme = self._theme
        colour = theme.fault if shape in ("record", "stop") else theme.text
        action.setIcon(icon(shape, colour, disabled=mixed(theme.panel, theme.quiet, 0.65)))


_ARROWS = {"Up": "↑", "Down": "↓", "Left": "←", "Right": "→"}


def key_text(keys: str) -> str:
    """A shortcut as a person reads it: arrows are drawn."""
    return "+".join(_ARROWS.get(key, key) for key in keys.split("+")) if keys != "+" else keys


def key_rows(menus: Sequence[Menu]) -> list[tuple[str, list[tuple[str, str]]]]:
    """The actions of each menu, with or without keys: name, and what it does."""
    return [(menu.title, [(spec.name, spec.text.rstrip("…")) for spec in specs_in([menu])]) for menu in menus]


def taken_by_menus(menus: Sequence[Menu]) -> dict[str, str]:
    """The keys that open a menu, with what they do."""
    return {
        f"Alt+{letter.upper()}": f"opening the menu {menu.title}"
        for menu, letter in zip(menus, menu_letters(menus), strict=True)
        if letter
    }


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
