"""Leave-one-out test: each recording is scored with a classifier trained without it.

The classifier of scan candidates is trained with scikit-learn, seeded, on one core. Simulated and
recorded samples weigh alike, and so do people and other objects in each of them: the classifier
learns from no sensor that people are frequent.

A simulated scene is a shipped floor, a scanner somewhere on it, furniture and aids of many kinds,
and people. Everything but the walls is a set of discs; see ``planar_bodies``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.ensemble import HistGradientBoostingClassifier
from threadpoolctl import threadpool_limits

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, read_only, value
from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import NONE, Bound, measured, skipped
from cohelm.evaluation.perception.ego_pose import EgoPoses
from cohelm.evaluation.perception.labelled import LabelScores, LabelScoring, RecordingLabels
from cohelm.evaluation.perception.recording_view import NO_MAP, perceive_frames, perception_of
from cohelm.maps import OccupancyGrid, read_floor_plan
from cohelm.messages import Scan
from cohelm.perception import PerceptionParts, ScanClusters
from cohelm.perception.scan_detection.candidate_features import FEATURES
from cohelm.perception.scan_detection.person_classifier import DEPTH, NO_TREES, TreeEnsemble
from cohelm.recordings import open_recording
from cohelm.recordings.outside_data import outside_file
from cohelm.robots import LaserMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import generator
from cohelm.simulation.sensors import BodyKind, outline_of, sweep
from cohelm.simulation.sensors.planar_bodies import RADIUS, rod

FLOORS = ("corridors", "crossroads", "doorway", "hall", "hallway", "hospital", "two-rooms", "ward")
"""Floors that give the walls."""
MAX_FURNITURE, MAX_PEOPLE = 14, 7
NEAR, FAR = 0.5, 9.0
"""Distance of objects from the scanner, m."""
ON_BODY = 0.06
"""A return this near a person's outline is theirs, m."""
KINDS = {
    BodyKind.LEGS: 0.4,
    BodyKind.DISC: 0.3,
    BodyKind.CHILD: 0.08,
    BodyKind.SEATED: 0.07,
    BodyKind.WALKER: 0.05,
    BodyKind.WHEELCHAIR: 0.05,
    BodyKind.TROLLEY: 0.05,
}
"""Shares of outlines among people (assumed)."""


@value
class TrainingScan:
    """A scan, the pose of its robot, and the outlines of people."""

    scan: Scan
    pose: Annotated[Floats, Shape("3")]
    people: Annotated[Floats, Shape("k 3")]
    """Discs x, y, radius, map frame, m."""

    def of_people(self, points: Floats) -> Booleans:
        """Mask (p,) of returns (p, 2) that lie on a person."""
        if not len(self.people):
            return np.zeros(len(points), dtype=np.bool_)
        apart = np.hypot(*(points[:, None] - self.people[None, :, :2]).transpose(2, 0, 1))
        out: Booleans = (apart - self.people[:, 2]).min(axis=1) < ON_BODY
        return out


def training_scan(seed: int) -> TrainingScan:
    """Draw one scene and sweep it once."""
    rng = generator(seed, "training scene")
    grid, free = _floor(FLOORS[int(rng.integers(len(FLOORS)))])
    pose = np.array([*free[rng.integers(len(free))], rng.uniform(-math.pi, math.pi)])
    near = free[np.hypot(*(free - pose[:2]).T) < FAR]
    things = [_furniture(rng, _place(near, pose, rng)) for _ in range(rng.integers(MAX_FURNITURE))]
    if rng.random() < 0.3:
        things.append(_knees(pose, rng))
    people = [_person(rng, _place(near, pose, rng)) for _ in range(rng.integers(MAX_PEOPLE))]
    blank = np.empty((0, 3))
    persons = np.concatenate([blank, *people])
    mount = LaserMount(
        beams=int(rng.integers(300, 1100)),
        field_of_view_deg=float(rng.choice([180.0, 270.0, 360.0])),
        noise=float(rng.uniform(0.003, 0.025)),
        dropout=float(rng.uniform(0.0, 0.03)),
    )
    discs = np.concatenate([persons, *things])
    scan = sweep(mount, grid, discs, pose, time=0.0, rng=rng)
    return TrainingScan(scan=scan, pose=pose, people=persons)


@lru_cache(maxsize=16)
def _floor(name: str) -> tuple[OccupancyGrid, Floats]:
    """Grid, and the centres (k, 2) of its free cells, m."""
    grid = read_floor_plan(floor_file(name)).draw()[0]
    rows, cols = np.nonzero(grid.data == 0)
    centres = (np.column_stack([cols, rows]) + 0.5) * grid.resolution
    c, s = math.cos(grid.X_MG[2]), math.sin(grid.X_MG[2])
    return grid, read_only(centres @ np.array([[c, s], [-s, c]]) + grid.X_MG[:2])


def _place(free: Floats, pose: Floats, rng: np.random.Generator) -> Floats:
    """Pose (3,) of an object, at least ``NEAR`` from the scanner."""
    at = free[rng.integers(len(free), size=20)]
    away = at[np.hypot(*(at - pose[:2]).T) > NEAR + 0.4]
    at = away[0] if len(away) else pose[:2] + 2.0
    return np.array([*at, rng.uniform(-math.pi, math.pi)])


def _at(pose: Floats, discs: Floats) -> Floats:
    """Discs of an object at its pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y, r = discs.T
    return np.column_stack([pose[0] + c * x - s * y, pose[1] + s * x + c * y, r])


def _person(rng: np.random.Generator, pose: Floats) -> Floats:
    kind = rng.choice(len(KINDS), p=list(KINDS.values()))
    chosen = list(KINDS)[kind]
    swing = float(rng.choice([0.0, 1.0]) * rng.uniform(-0.35, 0.35))
    discs = outline_of(chosen, swing, RADIUS[chosen] * float(rng.uniform(0.75, 1.15)))
    if chosen is not BodyKind.DISC:
        legs = discs[:, 2] > 0.03
        discs = discs * np.where(legs[:, None], [1.0, 1.0, rng.uniform(0.75, 1.4)], 1.0)
    return _at(pose, discs)


def _knees(pose: Floats, rng: np.random.Generator) -> Floats:
    """Knees and feet of the rider in front of a scanner behind them."""
    ahead, apart = rng.uniform(0.15, 0.4), rng.uniform(0.06, 0.15)
    return _at(pose, np.array([[ahead, apart, 0.06], [ahead, -apart, 0.06]]))


def _furniture(rng: np.random.Generator, pose: Floats) -> Floats:
    make: Sequence[Callable[[np.random.Generator], Floats]] = (
        _chair, _chair, _table, _stool, _post, _post, _box, _box, _leaf, _pram, _empty_aid,
        _clutter,
    )  # fmt: skip
    return _at(pose, make[int(rng.integers(len(make)))](rng))


def _corners(length: float, width: float, radius: float) -> Floats:
    half = [(sx * length / 2, sy * width / 2, radius) for sx in (1, -1) for sy in (1, -1)]
    return np.array(half)


def _chair(rng: np.random.Generator) -> Floats:
    side = rng.uniform(0.36, 0.5)
    return _corners(side, side * rng.uniform(0.9, 1.1), rng.uniform(0.01, 0.03))


def _table(rng: np.random.Generator) -> Floats:
    return _corners(rng.uniform(0.7, 1.8), rng.uniform(0.5, 0.9), rng.uniform(0.015, 0.05))


def _stool(rng: np.random.Generator) -> Floats:
    """Office chair: a post and five casters."""
    turn = np.arange(5) * 2.0 * math.pi / 5.0
    feet = np.column_stack([0.3 * np.cos(turn), 0.3 * np.sin(turn), np.full(5, 0.025)])
    return np.vstack([feet, [0.0, 0.0, rng.uniform(0.02, 0.05)]])


def _post(rng: np.random.Generator) -> Floats:
    """Post, bin, plant or column."""
    return np.array([[0.0, 0.0, rng.choice([0.03, 0.06, 0.1, 0.15, 0.35]) * rng.uniform(0.8, 1.2)]])


def _box(rng: np.random.Generator) -> Floats:
    """Cupboard, radiator, bed end or bag."""
    x, y = rng.uniform(0.1, 1.2) / 2.0, rng.uniform(0.1, 0.6) / 2.0
    ring = [(x, y), (-x, y), (-x, -y), (x, -y), (x, y)]
    return np.concatenate([rod(a, b) for a, b in pairwise(ring)])


def _leaf(rng: np.random.Generator) -> Floats:
    """Leaf of a door, or a panel."""
    return rod((0.0, 0.0), (rng.uniform(0.3, 1.0), 0.0))


def _pram(rng: np.random.Generator) -> Floats:
    wheels = _corners(rng.uniform(0.5, 0.8), rng.uniform(0.4, 0.6), 0.05)
    return (
        np.concatenate([wheels, rod((-0.3, 0.2), (-0.3, -0.2))]) if rng.random() < 0.5 else wheels
    )


def _empty_aid(rng: np.random.Generator) -> Floats:
    """Rollator, wheelchair or trolley without its user."""
    kinds = (BodyKind.WALKER, BodyKind.WHEELCHAIR, BodyKind.TROLLEY)
    return outline_of(kinds[int(rng.integers(3))], 0.0, 0.25)[2:]


def _clutter(rng: np.random.Generator) -> Floats:
    """Things lying about: up to eight small ones within half a metre."""
    n = int(rng.integers(2, 9))
    return np.column_stack([rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(0.01, 0.08, n)])


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


TREES = 50
SCENES = 4000
"""Simulated scenes of the shipped model."""
SIMULATED_WEIGHT = 1.0
"""Total weight of the simulated samples beside that of all recorded ones."""


def train(simulated: Samples, recorded: Sequence[Samples]) -> TreeEnsemble:
    """Fit the ensemble to simulated samples and to those of some recordings.

    Deterministic: the same samples give the same trees.
    """
    parts = [simulated, *recorded]
    x = np.concatenate([each.features for each in parts])
    y = np.concatenate([each.person for each in parts])
    model = HistGradientBoostingClassifier(
        max_iter=TREES,
        max_depth=DEPTH,
        learning_rate=0.15,
        l2_regularization=5.0,
        min_samples_leaf=40,
        max_bins=64,
        early_stopping=False,
        random_state=0,
    )
    with threadpool_limits(limits=1):
        model.fit(x, y, sample_weight=_weights(simulated, recorded))
    return _ensemble(model)


def save(trees: TreeEnsemble, file: Path) -> None:
    """Write the ensemble as plain arrays, in single precision."""
    np.savez_compressed(
        file,
        feature=trees.feature.astype(np.int8),
        threshold=trees.threshold.astype(np.float32),
        leaf=trees.leaf.astype(np.float32),
        offset=np.float32(trees.offset),
    )


def _weights(simulated: Samples, recorded: Sequence[Samples]) -> Floats:
    """Weight of each sample.

    Recordings share the weight of people by their counts, and that of other objects evenly.
    """
    people = sum(int(each.person.sum()) for each in recorded)
    rows = [SIMULATED_WEIGHT * _shares(simulated)]
    for each in recorded:
        objects = len(recorded) * max(int((~each.person).sum()), 1)
        rows.append(np.where(each.person, 1.0 / max(people, 1), 1.0 / objects))
    weight = np.concatenate(rows)
    out: Floats = weight * len(weight) / weight.sum()
    return out


def _shares(samples: Samples) -> Floats:
    count = max(int(samples.person.sum()), 1), max(int((~samples.person).sum()), 1)
    return np.where(samples.person, 1.0 / count[0], 1.0 / count[1])


def _ensemble(model: Any) -> TreeEnsemble:
    """Plain arrays of a fitted model; a leaf above the last level fills its whole subtree."""
    inner = 2**DEPTH - 1
    trees = [rows[0].nodes for rows in model._predictors]
    feature = np.zeros((len(trees), inner), dtype=np.int64)
    threshold, leaf = np.zeros((len(trees), inner)), np.zeros((len(trees), inner + 1))
    for t, nodes in enumerate(trees):
        at = [0] * (2 * inner + 1)
        for k in range(2 * inner + 1):
            node = nodes[at[k]]
            if k >= inner:
                leaf[t, k - inner] = node["value"]
                continue
            if node["is_leaf"]:
                at[2 * k + 1] = at[2 * k + 2] = at[k]
                continue
            feature[t, k], threshold[t, k] = node["feature_idx"], node["num_threshold"]
            at[2 * k + 1], at[2 * k + 2] = node["left"], node["right"]
    # Single precision as in the file, so that a saved model equals the trained one.
    return TreeEnsemble(
        read_only(feature),
        read_only(threshold.astype(np.float32).astype(float)),
        read_only(leaf.astype(np.float32).astype(float)),
        float(np.float32(np.ravel(model._baseline_prediction)[0])),
    )


PART = "held-out recordings"
LABELLED = tuple(f"legtracker_positive_{k}_extracted.bag" for k in (1, 2, 3))
EMPTY = ("legtracker_negative_2_first28s.bag",)
SCANNERS = (None, "/left_scan", "/rear_scan", "/right_scan")
"""Topics of the empty rooms. None: all at once; their mounts are not recorded, so that each is
tracked by itself."""
LEAST_FOUND, MOST_UNLABELLED = Bound(low=0.92), Bound(high=1.2)
MEAN_FOUND, MEAN_UNLABELLED = Bound(low=0.95), Bound(high=0.7)
"""Bounds of each recording, and of the mean over the recordings."""


def held_out(settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Train without each recording in turn, and score the pipeline on it."""
    files = {name: outside_file("lidar", name) for name in (*LABELLED, *EMPTY)}
    for name in (name for name, file in files.items() if file is None):
        yield skipped(PART, name, missing_data("lidar", name))
    known = {name: file for name, file in files.items() if file is not None}
    if not known:
        return
    simulated = simulated_samples(range(SCENES))
    samples = {n: recorded_samples(file, empty=n in EMPTY) for n, file in known.items()}
    parts, found = perception_of(settings), []
    for name, file in known.items():
        trees = train(simulated, [each for other, each in samples.items() if other != name])
        detector = ScanClusters(getattr(parts.detector, "parameters", None), trees)
        judged = replace(parts, detector=detector)
        if name in EMPTY:
            yield from (_empty(file, topic, judged) for topic in SCANNERS)
            continue
        scores = _scores(file, judged)
        found.append((scores.found, scores.unlabelled))
        said = f"{scores.labels} labels in {scores.instants} frames of {name}"
        yield measured(PART, "labels found", scores.found, bound=LEAST_FOUND, remark=said)
        yield measured(
            PART, "people per frame without a label", scores.unlabelled, bound=MOST_UNLABELLED,
            remark=f"worst frame: {scores.unlabelled_most}",
        )  # fmt: skip
    if found:
        recall, extra = np.mean(found, axis=0)
        yield measured(PART, "labels found, mean", float(recall), bound=MEAN_FOUND)
        yield measured(PART, "people without a label, mean", float(extra), bound=MEAN_UNLABELLED)


def _empty(file: Path, topic: str | None, parts: PerceptionParts) -> dict[str, Any]:
    """Row of a recording without people, by one scanner or by all."""
    frames, busy, ids = 0, 0, set()
    for seen in perceive_frames(open_recording(file, topic=topic), parts):
        frames += 1
        busy += len(seen.perceived.people) > 0
        ids |= set(seen.perceived.people.id.tolist())
    remark = f"of {frames} frames of {file.name}, {topic or 'all scanners'}; {len(ids)} ids"
    name = "frames of empty rooms with a detected person"
    return measured(PART, name, busy, bound=NONE, remark=remark)


def _scores(file: Path, parts: PerceptionParts) -> LabelScores:
    scoring = LabelScoring(RecordingLabels())
    for seen in perceive_frames(open_recording(file), parts):
        scoring(seen)
    return scoring.scores()
