"""Contracts of ``simulation.PedestrianModel`` and ``simulation.Rider``."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cohelm.arrays import Floats, identical
from cohelm.maps import OccupancyGrid
from cohelm.simulation import prepare_crowd
from cohelm.simulation.api import Crowd, CrowdScene, PedestrianModel, Rider, RiderAct, RiderView
from cohelm.simulation.crowds.motion import displacement, far_away
from cohelm.testing.conformance import TOLERANCE, require, require_finite, steady
from cohelm.testing.scenes import BODY, room

_STEP = 0.05
_SPRINT = 2.0
"""Allowed speed in multiples of the preferred speed."""


def check_pedestrian_model(model: PedestrianModel, *, within: float = 1.0) -> None:
    """Check a pedestrian model in a room: alone, two head-on, with a wall and a robot.

    An optional ``enter``, called before people walk, must keep the given people, first and in their
    places.

    Raises:
        ConformanceError: naming the violated rule.
    """
    bare = room()
    empty = _crowd(np.empty((0, 2)), np.empty((0, 2)))
    require(
        len(_step(model, empty, _scene(bare), within).position) == 0,
        "an empty crowd must stay empty",
    )
    _check_enter(model, within)
    _check_unseen_robot(model, bare)
    _check_absent(model, bare, within)
    _check_arrives(model, bare, within)
    _check_head_on(model, bare, within)
    _check_wall(model, within)


def _check_arrives(model: PedestrianModel, grid: OccupancyGrid, within: float) -> None:
    """Check the time for 9 m: at 1.2 m/s 7.5 s, twice that is allowed."""
    crowd = prepare_crowd(model, _crowd([[1.5, 4.0]], [[10.5, 4.0]]))
    crowd = _walk(model, crowd, _scene(grid), 15.0, within)
    require(crowd.target[0] == 1, "alone in a room a pedestrian must reach the way-point")
    off = np.hypot(*(crowd.position[0] - (10.5, 4.0)))
    require(
        off < 1.0, f"a pedestrian at the last way-point must stay there, but is {off:.2f} m away"
    )


def _check_head_on(model: PedestrianModel, grid: OccupancyGrid, within: float) -> None:
    crowd = prepare_crowd(model, _crowd([[2.0, 4.0], [10.0, 4.05]], [[10.0, 4.0], [2.0, 4.05]]))
    closest = np.inf
    for k in range(200):
        crowd = _step(model, crowd, _scene(grid, time=k * _STEP), within, verify=k % 50 == 0)
        apart = np.hypot(*(crowd.position[0] - crowd.position[1])) - 2.0 * BODY
        closest = min(closest, float(apart))
    require(
        closest > -0.05, f"two pedestrians who meet must not overlap, but do by {-closest:.2f} m"
    )


def _check_wall(model: PedestrianModel, within: float) -> None:
    grid = room(boxes=[(6.0, 0.0, 6.2, 8.0)])
    crowd = prepare_crowd(model, _crowd([[3.0, 4.0]], [[9.0, 4.0]]))
    crowd = _walk(model, crowd, _scene(grid), 8.0, within)
    beyond = float(crowd.position[0, 0]) + BODY - 6.0
    require(
        beyond < 0.05, f"a pedestrian must not walk through a wall, but enters it by {beyond:.2f} m"
    )


def _check_unseen_robot(model: PedestrianModel, grid: OccupancyGrid) -> None:
    crowd = prepare_crowd(model, _crowd([[3.0, 4.0]], [[9.0, 4.0]]))
    far = _scene(grid)
    near = dataclasses.replace(far, robot_position=np.array([4.2, 4.1]))
    blind = [model.step(crowd, scene, _STEP, np.random.default_rng(0)) for scene in (far, near)]
    require(identical(*blind), "a pedestrian who does not see the robot must not react to it")


def _check_absent(model: PedestrianModel, grid: OccupancyGrid, within: float) -> None:
    """Check that an absent person, placed far away, affects no other."""
    start, goal = np.array([[3.0, 4.0], [4.0, 4.0]]), np.array([[9.0, 4.0], [3.0, 4.0]])
    there = np.array([True, False])
    both = dataclasses.replace(
        _crowd(np.where(there[:, None], start, far_away(2)), goal), present=there
    )
    alone = _crowd(start[:1], goal[:1])
    with_absent, without = (
        _walk(model, prepare_crowd(model, crowd), _scene(grid), 3.0, within)
        for crowd in (both, alone)
    )
    off = float(np.hypot(*(with_absent.position[0] - without.position[0])))
    require(
        off <= TOLERANCE,
        f"an absent person must not change the paths of others, but does by {off:.3f} m",
    )
    require(not with_absent.there[1], "an absent person must stay absent")


def _check_enter(model: PedestrianModel, within: float) -> None:
    given = _crowd([[2.0, 4.0], [10.0, 4.05]], [[10.0, 4.0], [2.0, 4.05]])
    crowd = steady(lambda: prepare_crowd(model, given), inputs=given, what="enter", within=within)
    n = len(given.radius)
    require(len(crowd.radius) >= n, "enter must keep the people it is given")
    for name in ("position", "radius", "preferred_speed", "target", "loop"):
        kept = identical(getattr(given, name), getattr(crowd, name)[:n])
        require(kept, f"enter must keep the {name} of all people")
    require_finite({"positions": crowd.position, "velocities": crowd.velocity})


def _walk(
    model: PedestrianModel, crowd: Crowd, scene: CrowdScene, duration: float, within: float
) -> Crowd:
    for k in range(round(duration / _STEP)):
        now = dataclasses.replace(scene, time=k * _STEP)
        crowd = _step(model, crowd, now, within, verify=k % 50 == 0)
    return crowd


def _step(
    model: PedestrianModel, crowd: Crowd, scene: CrowdScene, within: float, *, verify: bool = True
) -> Crowd:
    if not verify:
        return model.step(crowd, scene, _STEP, np.random.default_rng(0))
    after = steady(
        lambda: model.step(crowd, scene, _STEP, np.random.default_rng(0)),
        inputs=(crowd, scene),
        what="step",
        within=within,
    )
    require_finite({"positions": after.position, "velocities": after.velocity})
    require_finite({"headings": after.heading})
    for name in ("radius", "preferred_speed", "waypoints", "loop", "sees_robot"):
        kept = identical(getattr(crowd, name), getattr(after, name))
        require(kept, f"step must keep the {name} of all people")
    require(identical(crowd.group, after.group), "step must keep the groups of all people")
    gone = np.hypot(*displacement(crowd, after).T)
    require(
        gone <= _SPRINT * crowd.preferred_speed * _STEP + TOLERANCE,
        f"no pedestrian may walk {_SPRINT} times as fast as preferred",
    )
    return after


def _crowd(start: ArrayLike, goal: ArrayLike) -> Crowd:
    """People at 1.2 m/s from ``start`` to ``goal``, (n, 2) each, who do not see the robot."""
    position = np.asarray(start, dtype=float).reshape(-1, 2)
    goals = np.asarray(goal, dtype=float).reshape(-1, 2)
    offset, n = goals - position, len(position)
    return Crowd(
        position=position,
        velocity=np.zeros((n, 2)),
        heading=np.arctan2(offset[:, 1], offset[:, 0]),
        radius=np.full(n, BODY),
        preferred_speed=np.full(n, 1.2),
        waypoints=goals[:, None],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=np.bool_),
        sees_robot=np.zeros(n, dtype=np.bool_),
    )


def _scene(grid: OccupancyGrid, *, time: float = 0.0) -> CrowdScene:
    return CrowdScene(
        grid=grid,
        robot_position=np.array([6.0, 1.0]),
        robot_velocity=np.zeros(2),
        robot_radius=0.5,
        time=time,
    )


def check_rider(rider: Rider, *, within: float = 0.1) -> None:
    """Check a simulated rider over twenty seconds along a bent route, among people.

    Equal calls with an equal seed must give equal commands: state belongs into the returned memory,
    and randomness comes from the generator only.

    Raises:
        ConformanceError: naming the violated rule.
    """
    first = _ride_along(rider, within)
    require(
        len({a.command is None for a in first}) == 1, "the device must be present always or never"
    )
    for one, again in zip(first, _ride_along(rider, within), strict=True):
        require(
            identical(one.command, again.command),
            "the same views and seed must give the same commands: a rider must not hold state",
        )


def _ride_along(rider: Rider, within: float) -> list[RiderAct]:
    route = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    rng, memory, heard = np.random.default_rng(0), None, -np.inf
    acts = []
    for k in range(400):
        view = _view(k * 0.05, route)
        act = _act(rider, view, memory, rng, within)
        memory = act.memory
        acts.append(act)
        if act.command is None:
            continue
        sent, beat = act.command.deflection, act.command.heartbeat
        require_finite({"deflection": sent, "heartbeat": beat})
        require(np.abs(sent) <= 1.0, "deflection must be within −1…1")
        require(beat <= view.time, "the heartbeat of a device must not be later than now")
        require(beat >= heard, "the heartbeat of a device must never decrease")
        heard = beat
    return acts


def _act(
    rider: Rider, view: RiderView, memory: Any, rng: np.random.Generator, within: float
) -> RiderAct:
    state = rng.bit_generator.state

    def once() -> RiderAct:
        rng.bit_generator.state = state
        return rider.act(view, memory, rng)

    return steady(once, inputs=(view, memory), what="act", within=within)


def _view(time: float, route: Floats) -> RiderView:
    gone = min(0.5 * time, 8.0)
    first = gone <= 4.0
    pose = (gone, 0.1, 0.0) if first else (4.0, gone - 4.0, np.pi / 2.0)
    return RiderView(
        time=time,
        pose=np.array(pose),
        twist=np.array([0.5, 0.0, 0.0]),
        goal=route[-1],
        route=route,
        people=np.array([[2.0, 0.5 - 0.1 * time, 0.0, -0.1, 0.25]]),
        bearings=np.linspace(-1.5, 1.5, 31),
        free=np.where(np.arange(31) % 3, np.inf, 3.0),
    )
