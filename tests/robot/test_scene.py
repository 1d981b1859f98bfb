"""Cameras look along the axes that their names promise."""

import mujoco
import numpy as np
import pytest

from slider.robot.scene import aim


@pytest.mark.parametrize(("name", "axis", "sign"), [("side", 1, 1.0), ("front", 0, -1.0)])
def test_where_a_camera_looks(name, axis, sign):
    """From the right to the left (+y), and from the front backwards (−x); a little down."""
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")
    scene, camera = mujoco.MjvScene(model, 10), mujoco.MjvCamera()
    aim(camera, name, 2.0)
    data = mujoco.MjData(model)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, 7, scene)
    forward = np.array(scene.camera[0].forward)
    assert sign * forward[axis] > 0.9
    assert -0.3 < forward[2] < 0.0
    assert np.linalg.norm(scene.camera[0].pos) == pytest.approx(2.0, abs=0.1)
