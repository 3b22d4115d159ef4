"""Samples for the classifier of scan candidates: simulated scenes and labelled recordings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.benchmarks.perception.training_scenes import training_scan
from cohelm.evaluation.perception.ego_pose import EgoPoses
from cohelm.evaluation.perception.recording_view import NO_MAP
from cohelm.perception import ScanClusters
from cohelm.perception.scan_detection.candidate_features import FEATURES
from cohelm.perception.scan_detection.person_classifier import NO_TREES
from cohelm.recordings import open_recording

MOSTLY, HARDLY = 0.7, 0.2
"""Share of a simulated candidate's returns on people from which it is a person, and up to which it
is none; between them it is left out."""
ON_LABEL = 0.12
"""A candidate with a return this near a label is a person, m."""
STATIC_SHARE, SAME_PLACE, CLEAR_OF_LABELS = 0.5, 0.15, 0.3
"""An unlabelled candidate is no person if some candidate stands within ``SAME_PLACE`` (m) in more
than this share of the frames, and no label ever lies within ``CLEAR_OF_LABELS`` (m)."""


@value
class Samples:
    """n candidates with known classes."""

    features: Annotated[Floats, Shape("n f")]
    """Columns of ``FEATURES``."""
    person: Annotated[Booleans, Shape("n")]

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.person)

    def chosen(self, mask: Booleans) -> Samples:
        """Samples of a mask (n,)."""
        return Samples(features=self.features[mask], person=self.person[mask])


def simulated_samples(seeds: Iterable[int]) -> Samples:
    """Candidates of simulated scenes, one scan each."""
    detector, features, person = (
        ScanClusters(classifier=NO_TREES),
        [_NONE],
        [np.empty(0, dtype=np.bool_)],
    )
    for seed in seeds:
        scene = training_scan(seed)
        seen = detector.candidates(scene.scan, scene.pose, NO_MAP)
        d, own = len(seen.features), seen.body_of_return >= 0
        on = scene.of_people(seen.returns.points)[own]
        returns = np.maximum(np.bincount(seen.body_of_return[own], minlength=d), 1)
        share = np.bincount(seen.body_of_return[own], on, d) / returns
        known = (share > MOSTLY) | (share < HARDLY)
        features.append(seen.features[known])
        person.append(share[known] > MOSTLY)
    return Samples(features=np.concatenate(features), person=np.concatenate(person))


def recorded_samples(file: Path, *, empty: bool) -> Samples:
    """Candidates of a recording with planar scans.

    Args:
        file: recording with labels of legs, or without people.
        empty: True for a recording without people: all its candidates are samples.

    Raises:
        RecordingError: if it cannot be read.
    """
    detector, frames = ScanClusters(classifier=NO_TREES), []
    for placed in map(EgoPoses(), open_recording(file)):
        observation, labels = placed.frame.observation, placed.frame.labels
        truth = np.empty((0, 2)) if labels is None else labels.position
        for scan in observation.scans:
            seen = detector.candidates(scan, observation.pose, NO_MAP)
            near = _labelled(seen.returns.points, seen.body_of_return, truth, len(seen.features))
            frames.append((seen.features, near, seen.bodies.mean, truth))
    features = np.concatenate([_NONE, *(each[0] for each in frames)])
    if empty:
        return Samples(features=features, person=np.zeros(len(features), dtype=np.bool_))
    person = np.concatenate([each[1] for each in frames])
    static = ~person & _static([each[2] for each in frames], np.concatenate([f[3] for f in frames]))
    return Samples(features=features, person=person).chosen(person | static)


_NONE = np.empty((0, len(FEATURES)))


def _labelled(points: Floats, body: Integers, truth: Floats, count: int) -> Booleans:
    """Mask (count,) of candidates with a return near a label."""
    out = np.zeros(count, dtype=np.bool_)
    own = np.flatnonzero(body >= 0)
    if len(truth) and len(own):
        apart = np.hypot(*(points[own, None] - truth[None]).transpose(2, 0, 1)).min(axis=1)
        out[body[own[apart < ON_LABEL]]] = True
    return out


def _static(places: Sequence[Floats], labels: Floats) -> Booleans:
    """Mask (n,) of candidates at places (k, 2) of each frame that are hardly ever empty."""
    at = np.concatenate(places)
    frame = np.repeat(np.arange(len(places)), [len(each) for each in places])
    out = np.zeros(len(at), dtype=np.bool_)
    for i, place in enumerate(at):
        if len(labels) and np.hypot(*(labels - place).T).min() <= CLEAR_OF_LABELS:
            continue
        near = np.hypot(*(at - place).T) < SAME_PLACE
        out[i] = len(np.unique(frame[near])) > STATIC_SHARE * len(places)
    return out
