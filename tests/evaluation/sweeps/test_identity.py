"""Identity of sweeps."""

import enum
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.config import Model
from cohelm.errors import ConfigError
from cohelm.evaluation.code_version import code, code_digest, differences
from cohelm.evaluation.sweeps.identity import (
    canonical_text,
    check_plain,
    task_keys,
)

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.tuples(inner, inner) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@given(PLAIN, PLAIN)
def test_words_are_equal_where_values_are(one, other):
    assert canonical_text(one) == canonical_text(one)
    if canonical_text(one) == canonical_text(other):
        assert one == other


def test_what_a_task_may_be_made_of():
    @dataclass(frozen=True)
    class Ride:
        seed: int

    class Parameters(Model):
        width: float = 1.0

    class Way(enum.Enum):
        LEFT = 1

    values = [Ride(1), Ride(2), Parameters(), Parameters(width=2.0), Way.LEFT, range(2), {1}]
    values += [np.arange(3), np.arange(3.0), Path("a"), None, (), "", 0, False, 0.0]
    assert len({canonical_text(each) for each in values}) == len(values)
    assert canonical_text(np.float64(0.5)) == canonical_text(0.5)
    assert canonical_text({"a": 1, "b": 2}) == canonical_text({"b": 2, "a": 1})
    with pytest.raises(ConfigError, match="object is not a plain value"):
        check_plain([(object(),)])


def test_a_file_counts_with_what_is_in_it(tmp_path):
    file = tmp_path / "ward.yaml"
    unknown = canonical_text(str(file))
    file.write_text("people: {count: 3}")
    before = canonical_text((str(file), 1))
    file.write_text("people: {count: 4}")
    assert len({unknown, before, canonical_text((str(file), 1))}) == 3


def test_tasks_have_keys_of_their_own_that_are_the_same_in_every_run():
    keys = task_keys([(1, "a"), (2, "a"), (1, "a")])
    assert len(set(keys)) == 3
    assert keys == task_keys([(1, "a"), (2, "a"), (1, "a")])
    assert keys[0] == task_keys([(1, "a")])[0]


def test_the_code_is_every_source_but_what_only_shows():
    found = code()
    assert "cohelm/evaluation/episode/episode.py" in found
    assert "cohelm/scenarios/library/crossing.yaml" in found
    assert not any(name.startswith(("cohelm/cli/", "cohelm/plotting/")) for name in found)
    assert {"numpy", "numba", "python"} <= set(found)
    assert len(code_digest()) == 16


def test_differences_name_the_first_few():
    one = {"numpy": "2.0", "a/b.py": "1", "a/c.py": "2", "a/d.py": "3", "x": "0"}
    other = {"numpy": "2.1", "a/b.py": "2", "a/d.py": "4", "x": "0"}
    assert differences(one, other) == "a/b.py, a/c.py, a/d.py and 1 more"
    assert differences({"numpy": "2.0"}, {"numpy": "2.1"}) == "numpy 2.0 → 2.1"
    assert differences(one, one) == ""
