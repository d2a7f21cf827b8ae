"""A list of notes: its rows, the copied text, and a mark for faults that does not rely on words."""

from __future__ import annotations

import itertools

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from tactile_widgets.common.note_list import Note, NoteList, _wrapped
from tests.widgets.support.mouse import left_click

NOTES = (Note("Missing mesh, a.stl", "A small box is used", fault=True), Note("Units, b.csv", "Read as millimetres"))


@pytest.fixture
def made(qtbot):
    made = NoteList("notes", "Notes", "Nothing yet.")
    qtbot.addWidget(made)
    made.resize(260, 120)
    made.show()
    made.show_notes(NOTES)
    return made


def test_selected_notes_are_copied_or_all_without_a_selection(made):
    QTest.keyClick(made, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    everything = "Missing mesh, a.stl: A small box is used\nUnits, b.csv: Read as millimetres"
    assert QGuiApplication.clipboard().text() == everything
    left_click(made.viewport(), made.visualItemRect(made.item(1)).center())
    QTest.keyClick(made, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert QGuiApplication.clipboard().text() == "Units, b.csv: Read as millimetres"


def test_long_text_wraps_over_as_many_lines_as_needed(made):
    made.put_first(Note("Torn", "modules whose places do not fit together " * 6), most=9)
    assert made.visualItemRect(made.item(0)).height() > 2 * made.visualItemRect(made.item(1)).height()


def test_long_head_wraps_above_the_text(made):
    made.show_notes([Note("Neighbouring taxels fall below their baseline far more than the others", ""), NOTES[1]])
    both = made.fontMetrics().lineSpacing()
    first, second = (made.visualItemRect(made.item(number)) for number in range(2))
    assert first.height() > second.height() - both / 2
    image = made.viewport().grab(first).toImage()
    lower = [image.pixelColor(x, y) for y in range(first.height() // 2, first.height()) for x in range(image.width())]
    assert len({colour.name() for colour in lower}) > 2, "the second line of the head"


@pytest.mark.parametrize("width", [60, 90, 133, 211])
def test_lines_break_between_words_unless_a_word_exceeds_a_line(made, width):
    text = f"a path drawn on the map is kept in {'/folders' * 9} as\nwas said"
    layout = _wrapped(text, made.font(), width)
    lines = [layout.lineAt(number) for number in range(layout.lineCount())]
    said = [text[line.textStart() : line.textStart() + line.textLength()] for line in lines]
    assert "".join(said) == text
    assert all(line.naturalTextWidth() <= width for line in lines)
    broken = [one for one, other in itertools.pairwise(said) if one[-1:].isalnum() and other[:1].isalnum()]
    assert all("folders" in one or one.startswith("/") for one in broken)
    assert layout.boundingRect().height() == pytest.approx(sum(line.height() for line in lines))


def test_newest_note_is_on_top_and_the_oldest_is_dropped(made):
    made.put_first(Note("New", "one"), most=2)
    assert [note.head for note in made.notes] == ["New", "Missing mesh, a.stl"]


def test_fault_is_marked_and_an_empty_list_shows_an_explanation(made):
    palette = made.palette()
    palette.setColor(palette.ColorRole.BrightText, "#e03131")
    made.setPalette(palette)

    def fault_pixels():
        image = made.viewport().grab().toImage()
        colour = made.palette().color(made.palette().ColorRole.BrightText)
        return sum(image.pixelColor(1, y) == colour for y in range(image.height()))

    assert fault_pixels() > 10
    made.show_notes(NOTES[1:])
    assert not fault_pixels()
    said = made.viewport().grab().toImage()
    made.show_notes(())
    assert made.viewport().grab().toImage() != said
