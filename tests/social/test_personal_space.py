import numpy as np
import pytest

from cohelm.messages import Groups, People, Predictions, RiderProfile
from cohelm.shapes import RadialShape, extent
from cohelm.social import PersonalSpace
from cohelm.testing import check_social_model

REST = np.zeros(3)


def world(velocity, heading):
    """People with these velocities (n, 2) and headings (n,), and their predictions."""
    velocity = np.reshape(np.array(velocity, dtype=float), (-1, 2))
    n = len(velocity)
    mean = np.concatenate([np.zeros((n, 2)), velocity], axis=1)
    nobody = People.empty(0.0)
    people = type(nobody)(
        time=0.0,
        id=np.arange(n),
        mean=mean,
        covariance=np.zeros((n, 4, 4)),
        heading=np.array(heading, dtype=float),
        radius=np.full(n, 0.25),
        confidence=np.ones(n),
    )
    predictions = Predictions(
        step=0.1,
        names=("keeps_going",),
        weight=np.ones((n, 1)),
        mean=np.zeros((n, 1, 4, 2)),
        velocity=np.tile(velocity[:, None, None], (1, 1, 4, 1)),
        deviation=np.zeros((n, 1, 4)),
    )
    return people, predictions


def spaces(velocity, heading, twist=REST, profile=None, **parameters):
    people, predictions = world(velocity, heading)
    model = PersonalSpace(PersonalSpace.Parameters(**parameters))
    profile = profile or RiderProfile()
    return model.spaces(people, Groups.alone(len(people)), predictions, np.array(twist), profile)


@pytest.mark.parametrize("shape", ["contour", "printed"])
def test_fulfils_the_contract(shape):
    check_social_model(PersonalSpace(PersonalSpace.Parameters(shape=shape)))


def test_eq_5_for_a_walker():
    s = spaces([[0.0, 1.2]], [0.0])
    # σ_h = 2·1.2, σ_s = 2/3 σ_h, σ_r = σ_h/2, along the motion whatever the kept heading says
    assert s.front == pytest.approx(np.full((1, 1, 4), 2.4))
    assert s.side == pytest.approx(np.full((1, 1, 4), 1.6))
    assert s.rear == pytest.approx(np.full((1, 1, 4), 1.2))
    assert s.axis == pytest.approx(np.full((1, 1, 4), np.pi / 2))


@pytest.mark.parametrize("shape", ["contour", "printed"])
def test_a_walker_at_1_2_reaches_1_2_ahead_in_either_shape(shape):
    s = spaces([[1.2, 0.0]], [0.0], shape=shape)
    assert extent(s.shape(0), 0.0)[0] == pytest.approx(1.2, abs=0.01)


def test_who_rests_keeps_the_heading_and_who_has_none_is_round():
    s = spaces([[0.05, 0.0], [0.05, 0.0]], [2.0, np.nan])
    assert s.axis[:, 0, 0].tolist() == [2.0, 0.0]
    assert s.front[0] == pytest.approx(0.5)
    assert s.rear[0] == pytest.approx(0.25)
    assert (s.front[1] == s.side[1]).all()
    assert (s.front[1] == s.rear[1]).all()


def test_the_floor_is_the_riders():
    assert spaces([[0.0, 0.0]], [0.0], profile=RiderProfile(social_distance=0.9)).floor == 0.9


def test_the_robots_own_reach_is_a_share_of_a_persons_in_either_shape():
    for shape in ("contour", "printed"):
        s = spaces([[1.0, 0.0]], [0.0], twist=[1.0, 0.0, 0.3], shape=shape, robot_share=0.25)
        person = s.shape(0)._replace(floor=0.0)
        robot = RadialShape(s.kind, *s.robot, s.scale, s.robot_floor)
        for delta in (0.0, 1.0, 2.5):
            theirs, _ = extent(person, delta)
            ours, _ = extent(robot, delta)
            assert ours == pytest.approx(0.25 * theirs)


def test_reversing_the_robots_front_is_behind():
    ahead, back = (spaces([], [], twist=[v, 0.0, 0.0]).robot for v in (0.8, -0.8))
    assert back == pytest.approx(ahead[::-1])


def test_switched_off_the_robot_has_no_reach_and_nothing_divides_by_zero():
    s = spaces([], [], twist=[1.0, 0.0, 0.0], robot_share=0.0)
    length, slope = extent(RadialShape(s.kind, *s.robot, s.scale, s.robot_floor), 0.3)
    assert 0.0 < length < 1e-3
    assert np.isfinite(slope)


def test_nobody_is_ordinary():
    s = spaces([], [])
    assert s.axis.shape == (0, 1, 4)
