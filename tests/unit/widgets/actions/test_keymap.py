"""Keys of actions: one owner a key, whatever is chosen, and nobody loses a key without being told of it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from tactile_widgets.actions.keymap import KeyMap

SHIPPED = KeyMap({"undo": ("Ctrl+Z",), "redo": ("Ctrl+Shift+Z", "Ctrl+Y"), "poke": ("T",), "quit": ()})


def test_a_free_key_is_given_and_the_one_before_is_free():
    keys = SHIPPED.with_keys("poke", ("U",))
    assert keys.keys("poke") == ("U",)
    assert keys.owner("T") is None
    assert keys.changed("poke")
    assert not keys.changed("undo")


def test_a_swap_gives_the_other_the_key_that_is_free_now():
    assert SHIPPED.conflicts("undo", ("T",)) == {"T": "poke"}
    keys = SHIPPED.with_keys("undo", ("T",))
    assert (keys.keys("undo"), keys.keys("poke")) == (("T",), ("Ctrl+Z",))


def test_who_has_another_key_left_gets_none():
    keys = SHIPPED.with_keys("undo", ("Ctrl+Y",))
    assert keys.keys("redo") == ("Ctrl+Shift+Z",)
    assert keys.owner("Ctrl+Z") is None


def test_no_key_is_a_choice_and_a_reset_forgets_it():
    keys = SHIPPED.with_keys("undo", ())
    assert keys.keys("undo") == ()
    assert keys.with_keys("undo", ("Ctrl+Z",)).changes == {}


def test_a_key_written_by_hand_for_two_or_for_an_action_that_is_gone_asks_for_one():
    keys = KeyMap(SHIPPED.defaults, {"gone": ("T",), "poke": ("X",), "undo": ("X",), "quit": ("Ctrl+Y",)})
    assert (keys.owner("X"), keys.keys("undo")) == ("poke", ())
    assert keys.keys("redo") == ("Ctrl+Shift+Z",)


@given(st.lists(st.tuples(st.sampled_from(list(SHIPPED.defaults)), st.sampled_from(["T", "U", "Ctrl+Z", "Ctrl+Y"]))))
def test_whatever_is_chosen_a_key_asks_for_one_action(acts):
    keys = SHIPPED
    for name, key in acts:
        keys = keys.with_keys(name, (key,))
        assert keys.keys(name) == (key,)
        assert keys.owner(key) == name
        all_keys = [own for action in SHIPPED.defaults for own in keys.keys(action)]
        assert len(all_keys) == len(set(all_keys))
