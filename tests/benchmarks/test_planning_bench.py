"""The benchmark of planning: its sizes, its map, and memory that is counted whole."""

import warnings

import numpy as np
import pytest

from cohelm.benchmarks import planning, planning_maps
from cohelm.benchmarks.planning import peak_memory
from cohelm.maps import FREE, OccupancyGrid, write_map

MEGABYTE = 2**20


def test_sizes_are_taken_once_each_in_their_order():
    assert planning.create(None, [1000, 384, 1000]).tasks(range(2)) == [
        (384, 0), (384, 1), (1000, 0), (1000, 1),
    ]  # fmt: skip


def test_all_sizes_where_none_is_given():
    assert planning.create(None, []) == planning.create()


def test_a_map_is_measured_once_for_all_seeds_and_warned_of_once(tmp_path):
    grid = OccupancyGrid(
        data=np.full((20, 30), FREE, dtype=np.int8), resolution=0.05, X_MG=np.zeros(3)
    )
    file = tmp_path / "floor.yaml"
    write_map(grid, file)
    (tmp_path / "floor.yaml").write_text(file.read_text().replace("floor.pgm", "gone/floor.pgm"))
    with pytest.warns(UserWarning, match="was read"):
        bench = planning.create(file, [64])
    assert bench.tasks(range(3)) == [(64, str(file))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert planning_maps.scaled(file, 64).shape == (64, 64)


def test_memory_that_was_freed_just_before_counts_again():
    def call() -> int:
        # Blocks small enough that the allocator keeps them when they are freed.
        return sum(len(part) for part in [np.ones(8192) for _ in range(512)])

    call()
    found = peak_memory(call)
    if np.isnan(found):
        pytest.skip("this system does not say how much memory a process takes")
    # 512 × 64 KiB = 32 MiB
    assert found == pytest.approx(32 * MEGABYTE, rel=0.25)
