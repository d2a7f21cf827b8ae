"""Calls after the pending events: their order, and nothing kept for a receiver that was deleted before."""

from __future__ import annotations

import gc
from functools import partial

import pytest
import shiboken6
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QApplication, QWidget

from tactile_widgets.jobs.later import call_later


class Kept:
    """An object that a call needs."""


class Receiver(QWidget):
    """A widget that calls itself, with an object of its own."""

    def __init__(self):
        super().__init__()
        self.kept = Kept()
        self.calls = 0

    def act(self):
        self.calls += 1


FUNCTIONS = {
    "method": lambda receiver: receiver.act,
    "closure": lambda receiver: lambda: receiver.act(),
    "other object": lambda receiver: partial(id, receiver.kept),
}


def alive():
    gc.collect()
    return sum(isinstance(thing, (Kept, Receiver)) for thing in gc.get_objects())


def delete_by_event(receiver):
    receiver.deleteLater()
    QApplication.sendPostedEvents(receiver, QEvent.Type.DeferredDelete.value)


@pytest.mark.parametrize("delete", [shiboken6.delete, delete_by_event])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_call_of_a_deleted_object_is_dropped_with_all_that_it_needs(qapp, name, delete):
    before = alive()
    for _ in range(10):
        receiver = Receiver()
        call_later(receiver, FUNCTIONS[name](receiver))
        delete(receiver)
        del receiver
    qapp.processEvents()
    assert alive() == before


@pytest.mark.parametrize("name", FUNCTIONS)
def test_completed_call_keeps_nothing(qapp, name):
    before = alive()
    receiver = Receiver()
    call_later(receiver, FUNCTIONS[name](receiver))
    qapp.processEvents()
    assert receiver.calls == (name != "other object")
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    assert receiver.children() == []
    del receiver
    assert alive() == before


def test_calls_are_made_once_and_in_order_after_the_current_event(qapp):
    receiver = Receiver()
    calls = []
    call_later(receiver, lambda: (calls.append("first"), call_later(receiver, lambda: calls.append("third"))))
    call_later(receiver, lambda: calls.append("second"))
    assert calls == []
    for _ in range(3):
        qapp.processEvents()
    assert calls == ["first", "second", "third"]
