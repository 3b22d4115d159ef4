"""What a wish would cost is known at once, the first time too."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module

import pytest


@pytest.mark.slow
def test_nothing_is_left_to_compile_once_it_is_warm(toys):
    """Neither for a place far off the way nor for a line or a zone, among things and people."""
    first_route_preview = import_module("first_route_preview")
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as restart:
        prices, kernels = restart.submit(first_route_preview.priced).result()
    assert [(length > 1.0, trouble) for length, trouble in prices] == 6 * [(True, "")]
    assert kernels == []
