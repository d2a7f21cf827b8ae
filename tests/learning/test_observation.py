"""An observation says what the frame says, in arrays of the spaces."""

import numpy as np
import pytest

from tactile_maps.learning.observation import FrameObserver
from tactile_maps.learning.touched_arm import prepared_arm
from tactile_maps.session.session import Session


@pytest.mark.long
def test_observation_of_a_frame_fits_the_spaces():
    prepared = prepared_arm(300)
    session = Session.of(prepared.robot, prepared.map)
    observer = FrameObserver(prepared.robot, prepared.map)
    for taxel in (50, 200):
        session.press(prepared.skin.taxel_point(taxel), finger=taxel)
    frame = session.run_for(0.5)
    seen = observer.observe(frame)
    assert len(frame.regions) == 2, "two fingers are felt"
    assert seen["contact_mask"].tolist() == [1, 1, 0, 0]
    assert not seen["contacts"][2:].any()
    for row, region in zip(seen["contacts"], frame.regions, strict=False):
        assert row == pytest.approx([*region.map_point, region.force, region.area], rel=1e-6)
    assert seen["image"].max() == pytest.approx(observer.image.render(frame.pressures).max(), rel=1e-6)
    assert seen["image"].max() * 1000 <= frame.pressures.max() * 1.001, "in kPa"
    assert seen["image"].max() * 1000 > 0.3 * frame.pressures.max(), "in kPa"
    assert np.array_equal(seen["position"], frame.posture.astype(np.float32))
    assert all(space.contains(seen[name]) for name, space in observer.spaces.items())
