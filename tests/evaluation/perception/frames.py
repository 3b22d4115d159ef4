"""Frames with given people, built by hand."""

import numpy as np

from cohelm.evaluation.perception.recording_view import PerceivedFrame
from cohelm.messages import Groups, Observation, Sensing
from cohelm.perception import Detections, PerceptionResult
from cohelm.recordings import Labels
from cohelm.testing.scenes import walkers


def seen(time, mean=(), *, ids=None, groups=None, labels=None, sensing=Sensing.OK):
    """A frame with people of states ``mean`` (n, 4), the chair standing at (0, 0)."""
    states = np.asarray(mean, dtype=float).reshape(-1, 4)
    people = walkers(states, time=time)
    if ids is not None:
        people = people.__class__(**{**fields(people), "id": np.asarray(ids)})
    found = Detections.empty(time, np.zeros(2))
    return PerceivedFrame(
        observation=Observation(
            time=time, pose=np.zeros(3), pose_time=time, twist=np.zeros(3), twist_time=time
        ),
        labels=labels,
        perceived=PerceptionResult(
            sensing=sensing,
            detections=(found,),
            people=people,
            groups=Groups.alone(len(states)) if groups is None else groups,
        ),
    )


def fields(record):
    return {name: getattr(record, name) for name in record.__dataclass_fields__}


def labels(time, position, ids=None, visible=1.0):
    position = np.asarray(position, dtype=float).reshape(-1, 2)
    k = len(position)
    return Labels(
        time=time,
        position=position,
        id=np.full(k, -1) if ids is None else np.asarray(ids),
        visible=np.full(k, float(visible)),
    )
