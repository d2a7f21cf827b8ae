"""Links drawn: each primitive has the area of its formula, and visual geoms go before collision geoms."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.robots.tessellate import link_mesh


def mesh_of(geoms: str) -> Mesh | None:
    text = f'<mujoco><worldbody><body name="b"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>{geoms}</body></worldbody></mujoco>'  # noqa: E501
    return link_mesh(mujoco.MjModel.from_xml_string(text), 1)


@pytest.mark.parametrize(
    ("geom", "area", "half"),
    [('type="box" size=".1 .2 .3"', 0.88, (0.1, 0.2, 0.3)),
     ('type="sphere" size=".2"', 4 * np.pi * 0.04, (0.2, 0.2, 0.2)),
     ('type="cylinder" size=".1 .3"', 2 * np.pi * 0.1 * 0.6 + 2 * np.pi * 0.01, (0.1, 0.1, 0.3)),
     ('type="capsule" size=".1 .3"', 2 * np.pi * 0.1 * 0.6 + 4 * np.pi * 0.01, (0.1, 0.1, 0.4)),
     ('type="ellipsoid" size=".1 .1 .3"', 0.3084, (0.1, 0.1, 0.3))],
)  # fmt: skip
def test_primitives_are_centred_closed_and_as_large_as_their_formula(
    geom: str, area: float, half: tuple[float, float, float]
) -> None:
    mesh = mesh_of(f"<geom {geom}/>")
    assert mesh is not None
    assert mesh.area == pytest.approx(area, rel=0.02)
    assert mesh.bounds == pytest.approx(np.array([half, half]) * [[-1], [1]], abs=2e-3)
    assert np.abs((mesh.face_normals * mesh.face_areas[:, None]).sum(axis=0)).max() < 1e-9
    centroids = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((centroids * mesh.face_normals).sum(axis=1) > -1e-9).all()


def test_geoms_are_placed_in_the_body_frame() -> None:
    mesh = mesh_of('<geom type="box" size=".1 .2 .3" pos="1 2 3" euler="0 0 90"/>')
    assert mesh is not None
    assert mesh.bounds == pytest.approx(np.array([[0.8, 1.9, 2.7], [1.2, 2.1, 3.3]]))


def test_visual_geoms_go_first_then_what_is_shown_then_anything() -> None:
    collision, visual = '<geom size=".3" group="3"/>', '<geom size=".1" contype="0" conaffinity="0"/>'
    for geoms, size in ((collision + visual, 0.1), (collision, 0.3), ('<geom size=".2"/>' + collision, 0.2)):
        mesh = mesh_of(geoms)
        assert mesh is not None
        assert mesh.bounds[1, 2] == pytest.approx(size, rel=0.01)


def test_a_body_without_shape_has_no_mesh() -> None:
    assert mesh_of("") is None
