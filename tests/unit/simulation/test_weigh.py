"""The known-load check: a weight reads its weight, or says why not."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.robots.configuration import Configuration
from app.simulation.weigh import GRAVITY, weigh
from app.touch.layer import Layer
from tests.touch import arm, bar, bar_skin

CONSERVING = ("point", "water-fill", "punch", "foundation")


@pytest.mark.parametrize("model", CONSERVING)
@pytest.mark.parametrize("hinged", [False, True])
def test_a_tenth_of_a_kilogram_reads_0_981_newton_on_a_level_bar(model, hinged):
    weighed = weigh(bar(hinged=hinged), bar_skin(), Layer(), model)
    assert weighed.wanted_N == pytest.approx(0.981)
    assert weighed.read_N == pytest.approx(0.981, rel=0.01)
    assert weighed.error == pytest.approx(weighed.read_N / 0.981 - 1)
    assert (weighed.model, weighed.patch, weighed.place.patch) == (model, "top", 0)
    assert 0.1 < weighed.seconds < 5.0


@pytest.mark.parametrize("model", CONSERVING)
def test_so_it_does_on_the_round_links_of_an_arm_that_yields(model):
    prepared = arm()
    weighed = weigh(prepared.robot, prepared.skin, Layer(), model)
    assert weighed.read_N == pytest.approx(0.981, rel=0.01)
    patch = prepared.skin.patches[weighed.place.patch]
    normal = Configuration(prepared.robot).pose(patch.link).directions(prepared.skin.normal(weighed.place))
    assert normal[2] > 0.93, "it lies where the skin is level"


@pytest.mark.parametrize("mass", [0.002, 0.01, 1.0, 10.0])
def test_light_and_heavy(mass):
    weighed = weigh(bar(hinged=False), bar_skin(), Layer(), "water-fill", mass=mass)
    assert weighed.read_N == pytest.approx(mass * GRAVITY, rel=0.01)


@pytest.mark.parametrize("stiffness", [1e3, 1e5])
def test_soft_and_stiff_covers(stiffness):
    assert abs(weigh(bar(hinged=False), bar_skin(), Layer(stiffness=stiffness), "water-fill").error) < 0.01


@pytest.mark.parametrize(("model", "mass", "words"), [("off", 0.1, "model.*off"), ("point", 0.0, "mass.*0 kg"),
                                                      ("point", float("nan"), "mass.*nan")])  # fmt: skip
def test_what_cannot_be_weighed_is_refused(model, mass, words):
    with pytest.raises(SimulationError, match=words):
        weigh(bar(), bar_skin(), Layer(), model, mass=mass)


def test_a_model_that_feels_nothing_of_it_is_named():
    """MuJoCo's taxels feel depth, and in a stiff cover the weight has none."""
    with pytest.raises(SimulationError, match=r"rests, but no taxel feels it"):
        weigh(arm().robot, arm().skin, Layer(stiffness=1e5), "depth")


def test_a_weight_that_sinks_through_says_so():
    with pytest.raises(SimulationError, match=r"does not come to rest.*mm lower.*stiffer cover"):
        weigh(bar(hinged=False), bar_skin(), Layer(stiffness=10.0), "water-fill", mass=1.0)


def test_the_same_weight_reads_the_same_bit_for_bit():
    one, other = (weigh(bar(), bar_skin(), Layer(), "water-fill") for _ in range(2))
    assert one == other
    assert np.isfinite(one.read_N)
