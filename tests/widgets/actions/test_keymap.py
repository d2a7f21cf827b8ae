"""Shortcuts of actions: each key has one owner, and swaps give freed keys to the other action."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent

from tactile_widgets.actions.key_editor import pressed_key
from tactile_widgets.actions.keymap import KeyMap

SHIPPED = KeyMap({"undo": ("Ctrl+Z",), "redo": ("Ctrl+Shift+Z", "Ctrl+Y"), "poke": ("T",), "quit": ()})


def test_free_key_replaces_the_previous_one():
    keys = SHIPPED.with_keys("poke", ("U",))
    assert keys.keys("poke") == ("U",)
    assert keys.owner("T") is None
    assert keys.changed("poke")
    assert not keys.changed("undo")


def test_swap_gives_the_freed_key_to_the_other_action():
    assert SHIPPED.conflicts("undo", ("T",)) == {"T": "poke"}
    keys = SHIPPED.with_keys("undo", ("T",))
    assert (keys.keys("undo"), keys.keys("poke")) == (("T",), ("Ctrl+Z",))


def test_action_with_another_key_gets_no_freed_key():
    keys = SHIPPED.with_keys("undo", ("Ctrl+Y",))
    assert keys.keys("redo") == ("Ctrl+Shift+Z",)
    assert keys.owner("Ctrl+Z") is None


def test_removed_key_is_stored_and_reset():
    keys = SHIPPED.with_keys("undo", ())
    assert keys.keys("undo") == ()
    assert keys.with_keys("undo", ("Ctrl+Z",)).changes == {}


def test_inconsistent_stored_keys_have_one_owner():
    keys = KeyMap(SHIPPED.defaults, {"gone": ("T",), "poke": ("X",), "undo": ("X",), "quit": ("Ctrl+Y",)})
    assert (keys.owner("X"), keys.keys("undo")) == ("poke", ())
    assert keys.keys("redo") == ("Ctrl+Shift+Z",)


@given(st.lists(st.tuples(st.sampled_from(list(SHIPPED.defaults)), st.sampled_from(["T", "U", "Ctrl+Z", "Ctrl+Y"]))))
def test_every_key_has_at_most_one_action(acts):
    keys = SHIPPED
    for name, key in acts:
        keys = keys.with_keys(name, (key,))
        assert keys.keys(name) == (key,)
        assert keys.owner(key) == name
        all_keys = [own for action in SHIPPED.defaults for own in keys.keys(action)]
        assert len(all_keys) == len(set(all_keys))


@pytest.mark.parametrize(
    ("key", "held", "text", "name"),
    [
        (Qt.Key.Key_A, Qt.KeyboardModifier.ShiftModifier, "A", "Shift+A"),
        (Qt.Key.Key_Question, Qt.KeyboardModifier.ShiftModifier, "?", "?"),
        (Qt.Key.Key_F5, Qt.KeyboardModifier.ShiftModifier, "", "Shift+F5"),
        (Qt.Key.Key_5, Qt.KeyboardModifier.KeypadModifier, "5", "5"),
        (Qt.Key.Key_Shift, Qt.KeyboardModifier.ShiftModifier, "", ""),
    ],
)
def test_pressed_key_has_shift_unless_it_is_punctuation(key, held, text, name):
    assert pressed_key(QKeyEvent(QEvent.Type.KeyPress, key, held, text)) == name
