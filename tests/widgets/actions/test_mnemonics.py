"""Mnemonics of menus and their entries."""

from __future__ import annotations

import pytest

from tactile_widgets.actions.mnemonics import choose_mnemonics, with_mnemonic, without_mnemonic
from tactile_widgets.actions.registry import Line, Menu, entry_letters, menu_letters, specs_in
from tactile_widgets.actions.table import menu_bar


def all_menus(menus):
    for menu in menus:
        yield menu
        yield from all_menus([item for item in menu.items if isinstance(item, Menu)])


def test_menu_mnemonics_are_unique_and_no_alt_shortcuts():
    letters = menu_letters(menu_bar())
    assert len({*letters}) == len(menu_bar())
    assert "" not in letters
    alt = {key[-1].lower() for spec in specs_in(menu_bar()) for key in spec.keys if key[:-1] == "Alt+"}
    assert "h" in alt
    assert not alt & {*letters}


@pytest.mark.parametrize("menu", [*all_menus(menu_bar())], ids=lambda menu: menu.title)
def test_entry_mnemonics_are_unique(menu):
    letters = [
        letter for letter, item in zip(entry_letters(menu), menu.items, strict=True) if not isinstance(item, Line)
    ]
    assert "" not in letters
    assert len({*letters}) == len(letters)


@pytest.mark.parametrize(
    ("texts", "letters"),
    [
        (["Open robot…", "Open map…"], ["o", "m"]),
        (["Pin", "Pin pin"], ["p", "i"]),
        (["ab", "ab", "a"], ["a", "b", ""]),
        (["ab", "a"], ["b", "a"]),
        (["…", "²"], ["", ""]),
        (["Ä b"], ["b"]),
    ],
)
def test_mnemonics_prefer_initials(texts, letters):
    assert choose_mnemonics(texts) == letters


@pytest.mark.parametrize(
    ("text", "letter", "shown"),
    [
        ("Open map…", "m", "Open &map…"),
        ("Templates in map", "m", "Templates in &map"),
        ("Seams", "m", "Sea&ms"),
        ("Cut & join", "j", "Cut && &join"),
        ("Play", "x", "Play"),
        ("Play", "", "Play"),
    ],
)
def test_mnemonic_is_added_and_removed(text, letter, shown):
    assert with_mnemonic(text, letter) == shown
    assert without_mnemonic(shown) == text
