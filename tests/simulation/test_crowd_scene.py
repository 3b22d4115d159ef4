"""The chair as pedestrian models know it."""

import numpy as np

from cohelm.messages import Decision
from cohelm.simulation import Orca, World


class Spy(Orca):
    """Keeps the scene of the last step."""

    def step(self, crowd, scene, dt, rng):
        self.scene = scene
        return super().step(crowd, scene, dt, rng)


def test_it_is_an_outline_with_a_heading_and_discs_cover_it(make_setup, robot):
    spy = Spy()
    setup = make_setup(pedestrian_model=spy, start=np.array([4.0, 5.0, 2.0]))
    World(setup, 0).advance(Decision(twist=np.zeros(3)))
    scene = spy.scene
    assert scene.robot_heading == 2.0
    discs = scene.robot_discs()
    length, width = np.ptp(robot.outline, axis=0)
    assert len(discs) == 2  # 1.11 m hold 0.61 m once, and more
    np.testing.assert_allclose(discs[:, 2], np.hypot(length / 2, width) / 2)
    apart = np.hypot(*(scene.robot_outline[:, None] - discs[:, :2]).transpose(2, 0, 1))
    assert (apart <= discs[:, 2] + 1e-9).any(axis=1).all()
    np.testing.assert_allclose(discs[:, :2].mean(axis=0), scene.robot_position)


def test_people_pass_nearer_to_a_chair_whose_outline_they_avoid(make_scene, make_crowd):
    corners = np.array([[6.5, 5.3], [5.4, 5.3], [5.4, 4.7], [6.5, 4.7]])
    scene = make_scene(
        robot_position=np.array([5.95, 5.0]), robot_radius=0.63, robot_outline=corners
    )
    nearest = []
    for outline in (False, True):
        orca = Orca(Orca.Parameters(robot_outline=outline))
        crowd = make_crowd([[2.0, 5.5]], [[[10.0, 5.5]]], sees_robot=np.array([True]))
        aside, rng = [], np.random.default_rng(0)
        for _ in range(160):
            crowd = orca.step(crowd, scene, 0.05, rng)
            x, y = crowd.position[0]
            aside += [y - 5.3 - 0.25] if 5.4 < x < 6.5 else []
        nearest.append(min(aside))
    assert nearest[0] > nearest[1] + 0.1  # m
    assert nearest[1] > 0.1  # m
