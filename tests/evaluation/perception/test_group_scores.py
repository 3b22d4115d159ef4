import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.evaluation.perception.group_scores import GroupScores, followed, group_scores
from cohelm.messages import Groups
from cohelm.perception import Affinity, NoGroups
from cohelm.recordings import read_trajectories


class Told:
    """Finds the same groups, by ids of people, whatever happens."""

    def __init__(self, *groups):
        self._of = {each: k for k, members in enumerate(groups) for each in members}
        self._ids = np.arange(len(groups))

    def group(self, people, memory):
        member = np.array([self._of.get(each, -1) for each in people.id.tolist()], dtype=int)
        return Groups(id=self._ids, member=member), None


@pytest.fixture
def walks(tmp_path):
    """Four walkers for two seconds; 4 comes when 1 is gone. Lists repeat a member and overlap."""
    rows = []
    for frame in range(0, 60, 6):
        for who, y in ((1, 0.0), (2, 0.7), (3, 4.0)):
            if who != 1 or frame < 30:
                rows.append((frame, who, 0.08 * frame, 0, y, 0, 0, 0))
        if frame >= 30:
            rows.append((frame, 4, 0.08 * frame, 0, 0.2, 0, 0, 0))
    file = tmp_path / "obsmat.txt"
    np.savetxt(file, rows)
    (tmp_path / "groups.txt").write_text("1 2 2\n2 1\n\n1 4\n2 9\n")
    return read_trajectories(file)


def test_counts_pairs_once_and_those_never_together_as_missed(walks):
    # 1-2, 1-4, 2-9 are noted: 1 and 4 share no frame, 9 is nobody
    scores = group_scores(walks, walks.groups, Told((1, 2), (3, 4)))
    assert (scores.annotated, scores.apart, scores.found, scores.right) == (3, 2, 2, 1)
    assert scores.precision == 1 / 2
    assert scores.recall == 1 / 3
    assert scores.f1 == pytest.approx(2 * 1 / (2 + 3))
    low, high = scores.interval()
    assert 0.0 < low < scores.f1 < high < 1.0


def test_alone_finds_none(walks):
    scores = group_scores(walks, walks.groups, NoGroups())
    assert (scores.found, scores.right, scores.recall, scores.f1) == (0, 0, 0.0, 0.0)
    assert np.isnan(scores.precision)
    assert np.isnan(GroupScores(annotated=0, apart=0, found=0, right=0).f1)


def test_velocities_know_nothing_of_the_future(walks):
    whole = list(followed(walks))
    assert [len(each) for each in whole] == [3] * 10
    assert whole[0].mean[:, 2:] == pytest.approx(0.0)  # seen once: no velocity yet
    # 0.48 m in 0.4 s
    assert whole[-1].mean[1, 2:] == pytest.approx([1.2, 0.0], abs=0.01)
    noisy = list(followed(walks, noise=0.08, seed=1))
    again = list(followed(walks, noise=0.08, seed=1))
    for one, other, plain in zip(noisy, again, whole, strict=True):
        assert (one.mean == other.mean).all()
        assert np.abs(one.mean[:, :2] - plain.mean[:, :2]).max() > 0.0


@pytest.mark.data
@pytest.mark.parametrize("noise", [0.0, 0.08])
@pytest.mark.parametrize("name", ["eth", "zara01"])
def test_four_pairs_in_five_of_filmed_crowds(name, noise):
    data = os.environ.get("COHELM_DATA")
    if not data:
        pytest.skip("COHELM_DATA names no folder with pedestrians/*_obsmat.txt")
    walks = read_trajectories(Path(data) / "pedestrians" / f"{name}_obsmat.txt")
    scores = group_scores(walks, walks.groups, Affinity(), noise=noise)
    assert scores.f1 >= (0.80 if noise == 0.0 else 0.77)
