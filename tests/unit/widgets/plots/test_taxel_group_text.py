"""Groups of taxels as text."""

from __future__ import annotations

import pytest

from tactile_widgets.plots.choice.plot_choice import PlotKey, TaxelGroup


def test_a_group_is_read_again_whatever_its_name_has():
    group = TaxelGroup("a=b, c:d-1", (2, 3, 4, 9, 11))
    assert group.text == "a=b, c:d-1=2-4,9,11"
    assert TaxelGroup.parse(group.text) == group
    key = PlotKey.parse(f"group-force:{group.text}")
    assert key is not None
    assert key.title == "Force on a=b, c:d-1"


@pytest.mark.parametrize("text", ["", "palm", "=1", "palm=", "palm=x", "palm=3-1", "palm=1,,2", "palm=0-999999999"])
def test_what_names_no_group_is_none(text):
    assert TaxelGroup.parse(text) is None
    assert PlotKey.parse(f"group-pressure:{text}") is None
