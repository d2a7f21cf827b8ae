"""A proposal says what it costs, what it gives up, and what could not be kept."""

from __future__ import annotations

import pytest

from tactile_maps.studies.budget.proposal import Cost, Option, Proposal
from tactile_maps.studies.budget.wording import proposal_words, setting_words
from tactile_maps.studies.study.work_precision import Setting, Trial

STEP = Setting("simulation", "implicitfast", {"timestep_ms": 2.0})
FOUND = Proposal(
    {"simulation": Option(Trial(STEP, "", 1.0, {}), Cost(0.3))},
    Cost(0.3384, 4.07, 0.0, 0.15),
    Cost(1.72, 4.07, 0.0, 0.14),
)
PATH = Trial(Setting("control", "hybrid", {"path_speed_mm_s": 20.0}), "", 1500.0, {})


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        (None, "–"),
        (STEP, "Implicitfast 2\u202fms"),
        (Setting("image", "barycentric", {"pixels": 512}), "Barycentric 512²"),
        (Setting("touch", "point"), "Point"),
        (PATH.setting, "Hybrid 20\u202fmm/s"),
    ],
)
def test_setting_is_its_method_and_numbers_with_their_units(setting, words):
    assert setting_words(setting) == words


def test_text_lists_costs_the_most_accurate_setting_and_the_path():
    cost, finest = proposal_words(FOUND, None, tried=False)
    assert cost == "0.338\u202fms a tick; off by 4.07\u202fmm, 0\u202fN and 15\u202f% of the pressure."
    assert finest == "The most accurate settings: 1.72\u202fms, 4.07\u202fmm, 0\u202fN, 14\u202f%."
    assert proposal_words(FOUND, PATH, tried=True)[2] == "A path of 30\u202fmm in 1.5\u202fs keeps both limits."
    assert proposal_words(FOUND, None, tried=True)[2].startswith("▲ No controller keeps both limits")
