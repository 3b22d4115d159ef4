import dataclasses

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.platforms.twin import TwinChair, load_mujoco
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import Crowd, CrowdStep
from cohelm.simulation.contact import gap_to_walls
from cohelm.simulation.drivetrain import drive_command
from cohelm.simulation.sensors.human_bodies import HumanBodies

STEP = 0.05


@pytest.fixture(scope="session")
def mujoco():
    return load_mujoco()


@pytest.fixture(scope="session")
def empty():
    return build_scenario(load_scenario("empty"), 0)


class Bench:
    """The twin's chair alone on a floor, driven by twists, without world and rider."""

    def __init__(self, mujoco, setup, **changes):
        self.setup = dataclasses.replace(setup, **changes)
        self.chair = TwinChair(mujoco, self.setup)
        self.poses = [self.chair.pose]

    @property
    def data(self):
        return self.chair.twin.data

    def drive(self, twist, seconds, *, emergency=False, dt=0.01):
        """Follow a twist; returns the contacts of the last control step."""
        decision = Decision(twist=np.array(twist, dtype=float), emergency=emergency)
        command = drive_command(self.setup.robot, decision)
        for _ in range(round(seconds / STEP)):
            self.chair.begin(self._step())
            for k in range(round(STEP / dt)):
                self.chair.move(command, dt, (k + 1) * dt / STEP, lambda twist: twist)
            contacts = self.chair.end()
            self.crowd = contacts.after
            self.poses.append(self.chair.pose)
        return contacts

    crowd: Crowd | None = None

    def _step(self):
        crowd = self.crowd or self.setup.crowd
        n = len(crowd.radius)
        after = dataclasses.replace(crowd, position=crowd.position + STEP * crowd.velocity)
        statures = self.setup.statures
        height = np.full(n, 1.7) if statures is None else statures

        def people(share):
            return HumanBodies(
                position=crowd.position + share * STEP * crowd.velocity,
                heading=crowd.heading,
                walked=np.zeros(n),
                speed=np.zeros(n),
                height=height,
                radius=crowd.radius,
            )

        return CrowdStep(
            before=crowd,
            after=after,
            people=people,
            grid=self.setup.grid,
            gap_people=np.full(n, np.inf),
            gap_wall=gap_to_walls(self.setup.robot.outline, self.chair.pose, self.setup.grid),
        )


@pytest.fixture(scope="session")
def bench(mujoco, empty):
    """Makes a chair on the empty floor; changes are those of the world."""
    return lambda **changes: Bench(mujoco, empty.world, **changes)
