"""Record of a ride without ground truth: the chair's own measurements in its place."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.maps import OccupancyGrid
from cohelm.messages import Observation, People
from cohelm.simulation import Crowd, GroundTruth
from cohelm.simulation.contact import gap_to_people, gap_to_walls


class MeasuredTruth:
    """Ground truth as the chair itself measures it, for logs of real rides.

    Pose and twist are those of localiser and odometry, people those that are tracked. A contact is
    never reported, since a track may lie a few centimetres beside the person.

    Args:
        outline: (k, 2) footprint in the robot's frame, m.
        grid: Map.
    """

    def __init__(self, outline: Floats, grid: OccupancyGrid) -> None:
        self._outline, self._grid = outline, grid
        self._rows: list[int] = []
        """Id of the track in each row; −1: free."""

    def at(self, observation: Observation, people: People) -> GroundTruth:
        """Return the measured state of one step.

        A track keeps its row while it lasts, and later tracks take rows that became free.
        """
        rows = self._rows_of(people.id)
        crowd = _crowd(people, rows, len(self._rows))
        n, pose = len(self._rows), observation.pose
        gaps = gap_to_people(self._outline, pose, crowd.position, crowd.radius)
        return GroundTruth(
            time=observation.time,
            pose=pose,
            twist=observation.twist,
            crowd=crowd,
            gap_people=np.where(crowd.there, np.maximum(gaps, 1e-3), np.inf),
            gap_wall=max(gap_to_walls(self._outline, pose, self._grid), 1e-3),
            hit_moving=np.zeros(n, dtype=np.bool_),
            hit_standing=np.zeros(n, dtype=np.bool_),
            hit_wall=False,
        )

    def _rows_of(self, ids: Integers) -> Integers:
        """Row (n,) of each track."""
        present = set(ids.tolist())
        self._rows = [known if known in present else -1 for known in self._rows]
        for new in [each for each in ids.tolist() if each not in self._rows]:
            if -1 in self._rows:
                self._rows[self._rows.index(-1)] = new
            else:
                self._rows.append(new)
        return np.array([self._rows.index(each) for each in ids.tolist()], dtype=np.int64)


def _crowd(people: People, rows: Integers, n: int) -> Crowd:
    """Crowd of n rows, of which some are present."""
    states, heading = np.zeros((n, 4)), np.zeros(n)
    radius, there = np.full(n, 0.25), np.zeros(n, dtype=np.bool_)
    states[rows], radius[rows], there[rows] = people.mean, people.radius, True
    heading[rows] = np.nan_to_num(people.heading)
    return Crowd(
        position=states[:, :2],
        velocity=states[:, 2:],
        heading=heading,
        radius=radius,
        preferred_speed=np.ones(n),
        waypoints=np.full((n, 1, 2), np.nan),
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=np.bool_),
        sees_robot=np.ones(n, dtype=np.bool_),
        present=there,
    )
