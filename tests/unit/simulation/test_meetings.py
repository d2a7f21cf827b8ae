"""Who may press whose layer."""

from __future__ import annotations

from app.scene.effects import Effects
from app.simulation.assemble import assemble
from app.simulation.contact_pairs import feeling_links, never_touching
from app.simulation.meetings import meetings
from app.simulation.object_geoms import has_body
from app.touch.shapes import Ball, Plane
from tests.things import every_kind, thing
from tests.touch import arm, pair


def found(contact: str, objects=()):
    robot, skin = arm().robot, arm().skin
    effects = Effects(contact=contact, skin="foundation")
    model = assemble(robot, skin, effects, objects=objects)
    present = [t for t in objects if has_body(model, t.spec)]
    return meetings(model, robot, skin, effects, present)


def test_objects_meet_every_link_that_feels():
    links = set(feeling_links(arm().skin))
    assert {(m.link, m.by) for m in found("probe", every_kind())} == {(link, "probe") for link in links}
    outside = found("environment", every_kind())
    assert {(m.link, m.by) for m in outside} == {(link, t.spec.name) for link in links for t in every_kind()}
    assert all(m.own is None for m in outside)
    (plane,) = (m.shape for m in found("environment", (thing("plane"),)) if m.link == "hand")
    assert plane == Plane()
    assert {m.shape for m in found("probe", (thing("probe"),))} == {Ball(0.01)}


def test_links_meet_once_unless_they_never_touch():
    apart = never_touching(arm().robot, arm().skin)
    itself = found("self")
    met = [frozenset((m.link, m.by)) for m in itself if m.own is not None]
    assert len(set(met)) == len(met)
    assert set(met) <= {frozenset((a, b)) for a in feeling_links(arm().skin) for b in feeling_links(arm().skin)}
    assert not any(frozenset((m.link, m.by)) in apart for m in itself)
    assert {m.by for m in itself} - set(feeling_links(arm().skin)), "links without skin press too"


def test_everything_is_both():
    assert len(found("all", every_kind())) == len(found("environment", every_kind())) + len(found("self"))
    assert found("off", every_kind()) == ()


def test_the_links_own_shape_comes_along_where_both_feel():
    robot, skin = pair()
    effects = Effects(contact="self", skin="foundation")
    (meeting,) = meetings(assemble(robot, skin, effects), robot, skin, effects, ())
    assert (meeting.link, meeting.by) == ("left", "right")
    assert meeting.own is not None
    assert meeting.own[0] is not meeting.shape
