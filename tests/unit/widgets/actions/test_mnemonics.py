"""Every menu and every entry of the static menus has a mnemonic of its own."""

from __future__ import annotations

import pytest

from tactile_widgets.actions.mnemonics import choose_mnemonics, with_mnemonic, without_mnemonic
from tactile_widgets.actions.registry import Line, Menu, entry_letters, menu_letters, specs_in
from tactile_widgets.actions.table import menu_bar


def all_menus(menus):
    for menu in menus:
        yield menu
        yield from all_menus([item for item in menu.items if isinstance(item, Menu)])


def test_the_menus_of_the_bar_have_a_letter_each_that_no_shortcut_has():
    letters = menu_letters(menu_bar())
    assert len({*letters}) == len(menu_bar())
    assert "" not in letters
    alt = {key[-1].lower() for spec in specs_in(menu_bar()) for key in spec.keys if key[:-1] == "Alt+"}
    assert "h" in alt
    assert not alt & {*letters}


@pytest.mark.parametrize("menu", [*all_menus(menu_bar())], ids=lambda menu: menu.title)
def test_every_entry_has_a_letter_of_its_own(menu):
    letters = [
        letter for letter, item in zip(entry_letters(menu), menu.items, strict=True) if not isinstance(item, Line)
    ]
    assert "" not in letters
    assert len({*letters}) == len(letters)


@pytest.mark.parametrize(("texts", "letters"), [
    (["Open robot…", "Open map…"], ["o", "m"]),
    (["Pin", "Pin pin"], ["p", "i"]),
    (["ab", "ab", "a"], ["a", "b", ""]),
    (["ab", "a"], ["b", "a"]),
    (["…", "²"], ["", ""]),
    (["Ä b"], ["b"]),
])  # fmt: skip
def test_letters_are_the_first_of_a_word_where_they_can_be(texts, letters):
    assert choose_mnemonics(texts) == letters


@pytest.mark.parametrize(("text", "letter", "shown"), [
    ("Open map…", "m", "Open &map…"),
    ("Templates in map", "m", "Templates in &map"),
    ("Seams", "m", "Sea&ms"),
    ("Cut & join", "j", "Cut && &join"),
    ("Play", "x", "Play"),
    ("Play", "", "Play"),
])  # fmt: skip
def test_the_letter_is_marked_and_the_mark_comes_off(text, letter, shown):
    assert with_mnemonic(text, letter) == shown
    assert without_mnemonic(shown) == text
