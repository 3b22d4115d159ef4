"""JuPedSim's models as pedestrian models."""

import jupedsim as jps
import numpy as np
import pytest
import shapely
from jupedsim import native

from cohelm.simulation.crowds.jupedsim_models import JuPedSim, walkable_areas
from cohelm.testing import check_pedestrian_model

AGENTS = {
    "collision_free_speed": jps.CollisionFreeSpeedModelV2AgentParameters,
    "anticipation_velocity": jps.AnticipationVelocityModelAgentParameters,
    "social_force": jps.SocialForceModelAgentParameters,
}


@pytest.fixture(params=AGENTS)
def model(request):
    return JuPedSim(JuPedSim.Parameters(model=request.param))


def walked(model, crowd, scene, steps):
    rng = np.random.default_rng(0)
    for _ in range(steps):
        crowd = model.step(crowd, scene, 0.05, rng)
    return crowd


def test_each_model_keeps_the_contract(model):
    check_pedestrian_model(model)


def test_a_simulation_built_anew_in_each_step_is_one_that_goes_on(model, make_crowd, make_scene):
    """The anticipation velocity model draws at random among others, so its people are far apart."""
    start, goal = [[2.0, 4.0], [3.0, 2.0], [9.0, 8.0]], [[10.0, 4.3], [9.0, 2.0], [6.0, 8.0]]
    scene = make_scene()
    sim = native.Simulation(
        model=model._model(0), geometry=walkable_areas(scene.grid)[0].native, dt=0.01
    )
    stage = sim.add_direct_steering_stage()
    journey = sim.add_journey(jps.JourneyDescription([stage])._obj)
    given = {"radius": 0.25, "desired_speed": 1.0, "journey_id": journey, "stage_id": stage}
    make = AGENTS[model.parameters.model]
    agents = [sim.add_agent(make(position=tuple(at), **given).as_native()) for at in start]
    for agent, to in zip(agents, goal, strict=True):
        sim.agent(agent).target = tuple(to)
    for _ in range(200):
        sim.iterate()
    crowd = walked(model, make_crowd(start, [[each] for each in goal]), scene, 40)
    expected = [sim.agent(agent).position for agent in agents]
    np.testing.assert_allclose(crowd.position, expected, atol=1e-9)


def test_people_walk_round_a_chair_that_they_see_and_through_one_that_they_do_not(
    model, make_crowd, make_scene
):
    scene = make_scene(robot_position=np.array([6.0, 5.0]), robot_radius=0.6)
    crowd = make_crowd(
        [[2.0, 5.1], [10.0, 4.9]], [[[10.0, 5.1]], [[2.0, 4.9]]], sees_robot=np.array([True, False])
    )
    near, rng = np.full(2, np.inf), np.random.default_rng(0)
    for _ in range(200):
        crowd = model.step(crowd, scene, 0.05, rng)
        near = np.minimum(near, np.hypot(*(crowd.position - scene.robot_position).T))
    assert near[0] > 0.8  # m; the discs touch at 0.85
    assert near[1] < 0.4
    assert crowd.target[1] == 1


def test_areas_are_the_rooms_of_a_grid_in_the_map_frame(make_grid):
    grid = make_grid(boxes=((6.0, 0.0, 6.2, 10.0),), X_MG=(1.0, 2.0, np.pi / 2))
    left, right = sorted(walkable_areas(grid), key=lambda area: area.inside.bounds[1])
    # Turned by 90°: x of the grid is y of the map; people keep 2 cm away.
    np.testing.assert_allclose(left.inside.bounds, (-8.98, 2.02, 0.98, 7.98), atol=1e-6)
    assert shapely.contains_xy(right.inside, -4.0, 10.0)
