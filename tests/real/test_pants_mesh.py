"""The curves drawn on a real mesh make a network of four panels, waist and ankles open."""

import numpy as np
from pants_mesh import pants_project

from flatnet.forms import make_surface
from flatnet.network.assembly import make_network
from flatnet.project import load_project


def test_four_panels_on_the_mesh(tmp_path):
    project = load_project(pants_project(tmp_path))
    surface = make_surface(project)
    network = make_network(project, surface)
    assert not network.failed
    assert [patch.name for patch in network.patches] == [
        "front_left",
        "back_left",
        "front_right",
        "back_right",
    ]
    assert sorted(network.openings) == ["left_ankle", "right_ankle", "waist"]
    assert network.face_count == 7
    for patch in network.patches:
        vertices = patch.boundary.vertices
        feet, _ = surface.nearest(vertices)
        assert np.linalg.norm(feet - vertices, axis=1).max() < 1e-5  # written with six decimals
    # In the file's frame the figure is 8.2 dm high with y up.
    rims = np.vstack([patch.boundary.vertices for patch in network.patches])
    assert np.ptp(rims[:, 2]) > 800.0
    # The figure faces -y, so that outside is there in front and +y behind, low at the crotch aside.
    assert network.stretches["centre_front"].left_normals[:5, 1].max() < -0.8
    assert network.stretches["centre_back"].left_normals[:5, 1].min() > 0.8
