"""See people with a simulated LiDAR.

Two walk together, one passes by, three stand and talk, in a hall that no map describes.
The chair stands among them. The name of a file, as who.png, is given for a picture like those of
``cohelm people --plot``.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cohelm.evaluation import RecordingSummary, parts_of, perceive_frames, perception_of
from cohelm.evaluation.perception.film import FilmRecorder
from cohelm.maps import read_floor_plan
from cohelm.messages import Observation
from cohelm.recordings import Frame
from cohelm.robots import LidarMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud

CHAIR = np.array([7.0, 5.0, np.pi / 2])
WALKERS = np.array([[5.6, 10.8, 0.1, -0.9], [6.3, 10.9, 0.1, -0.9], [10.6, 4.2, -0.3, 1.1]])
"""(x, y, v_x, v_y), m and m/s."""
TALKERS = np.array([[4.2, 5.35], [3.55, 4.85], [4.2, 4.35]])


def bodies(time: float) -> HumanBodies:
    """Everybody at a time, s."""
    middle = TALKERS.mean(axis=0)
    position = np.vstack([WALKERS[:, :2] + time * WALKERS[:, 2:], TALKERS])
    velocity = np.vstack([WALKERS[:, 2:], middle - TALKERS])  # who stands faces the middle
    speed = np.append(np.hypot(*WALKERS[:, 2:].T), np.zeros(len(TALKERS)))
    return HumanBodies(
        position=position,
        heading=np.arctan2(velocity[:, 1], velocity[:, 0]),
        walked=time * speed,
        speed=speed,
        height=np.array([1.75, 1.62, 1.8, 1.7, 1.68, 1.83]),
        radius=np.full(len(position), 0.25),
    )


def frames(seconds: float) -> Iterator[Frame]:
    """Ten clouds a second, as a recording gives them."""
    rng = np.random.default_rng(0)
    scenery = StaticScene(grid=read_floor_plan(floor_file("hall")).draw()[0])
    for k in range(round(10 * seconds)):
        time = k / 10
        cloud = scan_cloud(LidarMount(), scenery, bodies(time), CHAIR, time=time, rng=rng)
        yield Frame(observation=Observation.at_rest(time, pose=CHAIR, clouds=(cloud,)))


def main() -> None:
    spacing = parts_of(keys=("predictor", "social_model"))
    tracks, filming = RecordingSummary(), FilmRecorder(**spacing, at=3.5)
    for seen in perceive_frames(frames(4.0), perception_of(["group_detector.use=affinity"])):
        tracks.add(seen)
        filming.add(seen, None)
    people, groups = seen.perceived.people, seen.perceived.groups
    truth = bodies(seen.observation.time).position
    apart = np.hypot(*(truth[:, None] - people.mean[None, :, :2]).transpose(2, 0, 1))
    print(f"told: {len(people)} people, {len(truth)} are there")
    print(f"farthest from where they are: {apart.min(axis=1).max():.2f} m")
    for number in range(len(groups.id)):
        print(f"together: {', '.join(str(who) for who in people.id[groups.member == number])}")
    if sys.argv[1:]:
        filming.draw(tracks, Path(sys.argv[1]), "a hall")


if __name__ == "__main__":
    main()
