"""Yielding in the pipeline: a rider who keeps steering otherwise gets their way, and keeps it."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm import sharing
from cohelm.maps import write_map
from cohelm.messages import RiderCommand
from cohelm.navigation import Navigator
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing.scenes import room, walkers

SMALL_ETA = 1.0 / 11.0
"""So small that the chair would take its own path."""
TURNED = 0.5
"""Heading that the rider wants, rad; the goal is straight ahead."""


@pytest.fixture
def small_eta(monkeypatch):
    """Let no rider have more than this authority."""
    given = sharing.authority

    def small(*values, **options):
        authority, state = given(*values, **options)
        return replace(authority, eta=min(authority.eta, SMALL_ETA)), state

    monkeypatch.setattr(sharing, "authority", small)


@pytest.fixture
def drive(tmp_path):
    """Ticks and truths of a shared ride with a goal straight ahead."""

    def run(seconds, stick, *, goal=(10.5, 4.0), **keys):
        write_map(room(boxes=()), tmp_path / "room.yaml")
        scenario = {
            "map": str(tmp_path / "room.yaml"),
            "start": [2.0, 4.0, 0.0],
            "goal": list(goal),
            "mode": "shared",
            "tracker": "given",
            **keys,
        }
        file = tmp_path / "ride.yaml"
        file.write_text("\n".join(f"{key}: {value}" for key, value in scenario.items()))
        setup = build_scenario(load_scenario(file), 0)
        world, navigator, tick = World(setup.world, 0), Navigator(setup.navigator), None
        ticks, truths = [], []
        while world.truth.time < seconds:
            time, truth = world.truth.time, world.truth
            rider = RiderCommand(heartbeat=time, deflection=np.array(stick(time, truth)))
            given = replace(
                world.observe(), people=walkers([], time=time, source="given"), rider=rider
            )
            tick = navigator.step(given, setup.request, tick)
            ticks.append(tick)
            truths.append(truth)
            world.advance(tick.decision)
        return ticks, truths

    return run


def towards(time, truth):
    """A rider who holds a heading 0.5 rad left of the way to the goal."""
    return 0.5, float(np.clip(1.2 * (TURNED - truth.pose[2]), -1.0, 1.0))


def test_a_rider_who_keeps_steering_otherwise_gets_their_heading(drive, small_eta):
    ticks, truths = drive(5.0, towards)
    yields = [t.authority.yields for t in ticks]
    assert any(yields)
    assert truths[-1].pose[2] == pytest.approx(TURNED, abs=0.15)
    _, alone = drive(5.0, towards, yielding="{use: false}")
    assert alone[-1].pose[2] < 0.5 * TURNED
    # where it yields in the open, the wheels get what the stick asks, and no plan
    led = [t for t in ticks if t.authority.yields]
    assert all(t.plan is None for t in led)
    assert led[-1].decision.twist[0] == pytest.approx(led[-1].authority.twist[0], abs=0.01)


def test_a_stick_that_jumps_does_not_jolt_a_chair_that_yields(drive, small_eta):
    def jumping(time, truth):
        ahead, left = towards(time, truth)
        return (ahead if int(4.0 * time) % 2 else 0.15), left

    ticks, _ = drive(4.0, jumping)
    led = [t for t in ticks if t.authority.yields]
    assert led
    # 0.8 and 1.0 m/s² over half a step of 0.16 s
    for tick in led:
        change = tick.decision.twist[0] - tick.observation.twist[0]
        assert -0.08 - 1e-9 <= change <= 0.064 + 1e-9


def test_a_rider_who_agrees_is_not_yielded_to(drive):
    ticks, _ = drive(2.5, lambda t, truth: (0.7, float(-1.2 * truth.pose[2])))
    assert not any(t.authority.yields for t in ticks)


def test_the_fading_near_the_goal_does_not_silence_a_rider_who_steers_away(drive):
    # the goal is 1.2 m ahead, within the 1.5 m over which η fades
    ticks, truths = drive(6.0, lambda t, truth: (0.5, 0.5), goal=(3.2, 4.0))
    led = [t for t in ticks if t.authority.yields and not t.arrived]
    assert led
    assert max(t.authority.eta for t in led) > 0.9
    assert abs(truths[-1].pose[2]) > 0.5


def test_a_rider_who_was_yielded_to_and_lets_go_stands_first(drive, small_eta):
    def stick(time, truth):
        return towards(time, truth) if time < 3.0 else (0.0, 0.0)

    ticks, truths = drive(4.5, stick)
    at_release = next(k for k in ticks if k.observation.time >= 3.0)
    assert at_release.authority.yields
    assert abs(truths[-1].twist[0]) < 0.05
