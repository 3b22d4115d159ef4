import dataclasses
import gc
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from cohelm.arrays import (
    Annotated,
    Booleans,
    Floats,
    Integers,
    Shape,
    empty_for_copies,
    identical,
    lazy_copy,
    read_only,
    replace,
    sealed,
    value,
)


@value
class Tracks:
    id: Annotated[Integers, Shape("n")]
    mean: Annotated[Floats, Shape("n 4")]
    forecast: Annotated[Floats, Shape("n N+1 2")] | None = None
    inputs: Annotated[Floats, Shape("N m")] | None = None
    cloud: Annotated[Floats, Shape("... 3")] | None = None
    free: Annotated[Booleans, Shape("* 2")] | None = None
    name: str = ""


def tracks(n=2, **fields):
    return Tracks(id=np.arange(n), mean=np.zeros((n, 4)), **fields)


def test_a_shape_that_fits_is_kept():
    made = tracks(forecast=np.zeros((2, 6, 2)), inputs=np.zeros((5, 3)), cloud=np.zeros((4, 7, 3)))
    assert made.forecast.shape == (2, 6, 2)


@pytest.mark.parametrize(
    "fields",
    [
        {"mean": np.zeros((2, 3))},  # 4 is exact
        {"mean": np.zeros((3, 4))},  # n is 2 already
        {"mean": np.zeros(4)},  # one axis too few
        {"forecast": np.zeros((2, 5, 2)), "inputs": np.zeros((5, 1))},  # N is 4, and then 5
        {"cloud": np.zeros((4, 2))},  # the last axis is exact, whatever comes first
        {"free": np.zeros((9, 3), dtype=bool)},
    ],
)
def test_a_shape_that_does_not_fit_is_refused_with_the_field_s_name(fields):
    with pytest.raises(ValueError, match=rf"Tracks\.({'|'.join(fields)}) has shape"):
        dataclasses.replace(tracks(), **fields)


def test_nobody_is_an_ordinary_number_of_people():
    assert tracks(0).mean.shape == (0, 4)


def test_elements_become_the_declared_type():
    made = Tracks(id=np.array([1, 2], dtype=np.int8), mean=[[1, 2, 3, 4], [5, 6, 7, 8]])
    assert made.id.dtype == np.int64
    assert made.mean.dtype == np.float64


def test_an_array_cannot_be_written_to():
    made = tracks()
    with pytest.raises(ValueError, match="read-only"):
        made.mean[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.mean = np.zeros((2, 4))


@pytest.mark.parametrize("view", [lambda a: a, lambda a: a[:], lambda a: a.reshape(2, 4)])
def test_what_the_caller_writes_later_does_not_reach_the_value(view):
    mine = np.zeros((2, 4))
    made = dataclasses.replace(tracks(), mean=view(mine))
    mine[:] = 7.0
    assert made.mean.max() == 0.0


def test_a_read_only_array_is_shared_and_not_copied():
    mine = read_only(np.zeros((2, 4)))
    assert dataclasses.replace(tracks(), mean=mine).mean is mine


def test_read_only_leaves_the_original_alone():
    mine = np.zeros(3)
    frozen = read_only(mine)
    mine[0] = 1.0
    assert frozen[0] == 0.0
    assert not frozen.flags.writeable


@pytest.mark.parametrize(
    "mean", [np.zeros((4, 3)).T, np.broadcast_to(np.zeros(4), (3, 4)), np.zeros((3, 8))[:, ::2]]
)
def test_arrays_are_contiguous_so_that_kernels_need_one_version(mean):
    kept = replace(tracks(3), mean=read_only(mean))
    assert kept.mean.flags.c_contiguous
    assert not kept.mean.flags.writeable
    assert np.array_equal(kept.mean, mean)


def test_sealed_tables_are_shared_and_not_copied():
    class Rows(NamedTuple):
        id: Integers
        mean: Floats
        count: int

    rows = sealed(Rows(np.arange(2), np.ones((2, 4)), 2))
    made = Tracks(id=rows.id, mean=rows.mean)
    assert made.mean is rows.mean
    assert made.id is rows.id


def test_replace_is_that_of_dataclasses_and_checks():
    before = tracks(name="before")
    for changes in ({}, {"name": "after"}, {"id": np.arange(2) + 7, "mean": np.ones((2, 4))}):
        after = replace(before, **changes)
        assert identical(after, dataclasses.replace(before, **changes))
        assert type(after) is Tracks
    with pytest.raises(ValueError, match=r"Tracks\.mean has shape"):
        replace(before, mean=np.zeros((2, 3)))
    with pytest.raises(TypeError, match="colour"):
        replace(before, colour="red")


def test_tables_are_identical_by_column_whatever_lies_between_them():
    kind = np.dtype([("flag", np.bool_), ("number", np.float64)], align=True)
    one, other = np.zeros(2, kind), np.full(2 * kind.itemsize, 255, np.uint8).view(kind)
    for name in kind.names:
        other[name] = 0
    assert identical(one, other)
    other["number"][1] = np.nan
    assert not identical(one, other)
    assert identical(other, other.copy())


def test_values_are_records_by_keyword_only():
    with pytest.raises(TypeError):
        Tracks(np.arange(2), np.zeros((2, 4)))


def test_identical_is_reflexive_also_with_nan():
    a = dataclasses.replace(tracks(), mean=np.full((2, 4), np.nan))
    b = dataclasses.replace(tracks(), mean=np.full((2, 4), np.nan))
    assert identical(a, b)
    assert identical(float("nan"), float("nan"))


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (np.zeros(2), np.zeros(3)),
        (np.zeros(2), np.zeros(2, dtype=np.float32)),
        (np.array([0.0]), np.array([-0.0])),  # bit for bit
        (np.array([1.0]), np.array([np.nextafter(1.0, 2.0)])),
        ((1, 2), [1, 2]),
        ((1, 2), (1, 2, 3)),
        ({"a": np.zeros(2)}, {"b": np.zeros(2)}),
        ({"a": np.zeros(2)}, {"a": np.ones(2)}),
        (1, 1.0),
        (tracks(2), tracks(3)),
    ],
)
def test_identical_sees_every_difference(a, b):
    assert not identical(a, b)


def test_identical_can_leave_fields_out_at_any_depth():
    a, b = (tracks(name="first"),), (tracks(name="second"),)
    assert not identical(a, b)
    assert identical(a, b, ignore=frozenset({"name"}))


LARGE = (1500, 1000)
"""Of float32: 6 MB, enough for copies that share memory."""


@pytest.mark.parametrize("shape", [(3, 4), LARGE])
def test_a_lazy_copy_is_a_copy(shape):
    base = empty_for_copies(shape, np.float32)
    base[:] = 1.0
    base.flags.writeable = False
    a, b = lazy_copy(base), lazy_copy(base)
    a[0], b[-1] = 2.0, 3.0
    assert (base == 1.0).all()
    assert (a[0] == 2.0).all()
    assert (a[1:] == 1.0).all()
    assert (b[-1] == 3.0).all()
    assert (b[:-1] == 1.0).all()
    a.flags.writeable = False
    again = lazy_copy(a)  # of a copy: a plain one, which has its changes
    again[1] = 4.0
    assert (again[0] == 2.0).all()
    assert (a[1:] == 1.0).all()


def test_a_lazy_copy_outlives_its_base():
    base = empty_for_copies(LARGE, np.float32)
    base[:] = 1.0
    base.flags.writeable = False
    copy = lazy_copy(base)
    del base
    gc.collect()
    assert (copy == 1.0).all()


def test_of_a_part_or_of_what_can_still_be_written_a_plain_copy_is_made():
    base = empty_for_copies(LARGE, np.float32)
    base[:] = 1.0
    copy = lazy_copy(base)
    base[:] = 2.0
    base.flags.writeable = False
    assert (copy == 1.0).all()
    part = lazy_copy(base[100:200])
    assert part.shape == (100, 1000)
    assert (part == 2.0).all()


def test_without_memory_to_map_again_copies_are_plain(monkeypatch):
    monkeypatch.delattr("os.memfd_create", raising=False)
    base = empty_for_copies(LARGE, np.float32)
    base[:] = 1.0
    base.flags.writeable = False
    copy = lazy_copy(base)
    copy[0] = 2.0
    assert (base == 1.0).all()


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="counts open files in /proc")
def test_copies_leave_no_file_open():
    base = empty_for_copies(LARGE, np.float32)
    base[:] = 1.0
    base.flags.writeable = False
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(50):
        lazy_copy(base)[0] = 2.0
    assert len(list(Path("/proc/self/fd").iterdir())) == before
    del base
    gc.collect()
    assert len(list(Path("/proc/self/fd").iterdir())) < before
