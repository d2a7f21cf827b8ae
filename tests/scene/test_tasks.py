"""What a scene is for, as values."""

from __future__ import annotations

from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.tasks import OUTPUTS, TASKS, TOUCH_OUTPUTS, Needs

BOX = ObjectSpec("box", "box", size=(0.1, 0.1, 0.1), mass=1.0)
WALL = ObjectSpec("wall", "box", size=(0.1, 0.1, 0.1))
PROBE = ObjectSpec("probe", "probe", size=(0.01,))
PLATE = ObjectSpec("plate", "plate", size=(0.1, 0.1, 0.01), mass=0.2)


def test_tasks_want_what_there_is():
    for task in TASKS.values():
        assert task.title
        assert set(task.outputs) <= set(OUTPUTS)
    assert set(TOUCH_OUTPUTS) < set(OUTPUTS)


def test_what_is_known_by_touch():
    assert Needs(outputs=("posture",)).touch == ()
    assert Needs(outputs=("posture", "readings")).touch == ("readings",)
    assert Needs(outputs=("posture",), controller="hold_force").touch == ("force",)


def test_the_things_in_it():
    assert not Needs().outside
    assert not Needs(objects=(PROBE,)).outside
    assert Needs(objects=(PROBE,)).probes
    assert Needs(objects=(PROBE, WALL)).outside
    assert Needs(objects=(PROBE, WALL, PLATE, BOX)).free == ("box",)
