"""Every kind of note has words of its own, with what it is about and what to do."""

from dataclasses import replace

import pytest

from tactile_maps.tactile.mechanics.contact_notes import (
    ContactNote,
    ContactNoteKind,
    bent_skin_notes,
    border_notes,
    contact_note_text,
    load_note,
)


@pytest.mark.parametrize("kind", list(ContactNoteKind))
def test_every_note_names_its_subject(kind):
    assert "forearm" in contact_note_text(ContactNote(kind, ("forearm",)))
    assert contact_note_text(ContactNote(kind, ()))


def test_note_contains_the_name_of_the_body():
    note = load_note(ContactNoteKind.OUTSIDE_SKIN, "ball", "hand")
    assert note.bodies == ("ball", "hand")
    assert contact_note_text(note) == "ball presses hand outside its skin: no reading"
    assert contact_note_text(load_note(ContactNoteKind.OUTSIDE_SKIN, "", "hand")).startswith("something presses hand")


def test_stiff_contact_reports_the_largest_stable_stiffness():
    note = ContactNote(ContactNoteKind.UNSTABLE, ("ball", "hand"), 1e5, 2.5e4, 0.5e-3)
    text = contact_note_text(note)
    assert text.startswith("ball and hand may be unstable: 1e+05 N/m is too stiff")
    assert "at most 2.5e+04 N/m or 0.5 ms" in text
    softer = contact_note_text(replace(note, kind=ContactNoteKind.SOFTER))
    assert softer.startswith("ball and hand touch with 2.5e+04 N/m instead of 1e+05 N/m, as much as the time step")
    assert softer.endswith("use at most 0.5 ms, or the integrator discrete")


def test_notes_state_depth_force_and_longest_step():
    def text(kind, *bodies, **figures):
        return contact_note_text(ContactNote(kind, bodies, **figures))

    assert text(ContactNoteKind.DEEP, "ball", "hand", depth=0.0234).startswith("ball is deep in hand: 23.4 mm; ")
    assert text(ContactNoteKind.HARD, "ball", "hand", force=12345.0).startswith(
        "ball presses hand very hard with 12.3 kN; "
    )
    servo = text(ContactNoteKind.UNSTABLE_SERVO, "elbow", max_timestep=0.0057)
    assert servo == "the servo of elbow may be unstable: use at most 5.7 ms, or the integrator implicitfast or discrete"


def test_load_across_the_border_is_noted_from_one_percent():
    assert border_notes(0.009, "ball", "hand") == ()
    (note,) = border_notes(0.37, "ball", "hand")
    assert (note.kind, note.share) == (ContactNoteKind.PARTLY_OUTSIDE, 0.37)
    assert contact_note_text(note) == "ball presses hand across the edge of its skin: 37 % of the force is not read"
    (note,) = border_notes(1.0, "ball", "hand")
    assert note == load_note(ContactNoteKind.OUTSIDE_SKIN, "ball", "hand")


@pytest.mark.parametrize(("felt", "ratio"), [(9.5, 0.95), (11.0, 1.1), (10.04, None), (9.96, None), (10.0, None)])
def test_readings_that_differ_from_the_force_are_noted_with_their_ratio(felt, ratio):
    notes = bent_skin_notes(felt, 10.0, "ball", "hand")
    assert [note.ratio for note in notes] == ([] if ratio is None else [pytest.approx(ratio)])
    for note in notes:
        expected = f"ball presses hand where the skin bends: the readings sum to {ratio:.3f} of the force"
        assert contact_note_text(note) == expected
