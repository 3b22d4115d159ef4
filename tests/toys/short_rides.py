"""Rides that end soon, as many as are asked for."""

from cohelm.evaluation.sweeps import RideTask, ride_row

SETTINGS = (
    "local_planner.use=path_follower",
    "tracker.use=given",
    "people.count=2",
    "time_limit=0.3",
)


def tasks(seeds):
    return [(RideTask((("scene", "crossing"),), "crossing", SETTINGS, seed),) for seed in seeds]


def work(task, folder):
    return [ride_row(each) for each in task]
