import functools
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from cohelm.robots import Robot, load_robot

from . import made_rides

# The same examples on every machine, and no deadline: the first one may have to compile.
settings.register_profile("cohelm", deadline=None, derandomize=True, print_blob=False)
settings.load_profile("cohelm")

TOGETHER = "tests/page/"
"""Tests that share a chair and a browser, which take long to start."""
FIRST = ("tests/control/baselines/", "tests/planning/")
"""Tests that need few kernels of a ride: those are compiled meanwhile by the chair of the tests
above, and no other worker compiles them too."""


_BEHIND = 10
"""How much more willingly tests that only compute wait for a processor than a chair and a page."""


@functools.cache
def _leave_the_page_its_time():
    os.nice(_BEHIND)


def pytest_runtest_setup(item):
    """From a worker's first test on that is none of ``TOGETHER``, where there are workers."""
    if "PYTEST_XDIST_WORKER" in os.environ and not item.nodeid.startswith(TOGETHER):
        _leave_the_page_its_time()


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: not item.nodeid.startswith(FIRST))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out whole files, so that module fixtures are built once; the page's tests together."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return TOGETHER if nodeid.startswith(TOGETHER) else nodeid.partition("::")[0]

    return ByFile(config, log) if config.getoption("dist") == "load" else None


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder with the outside data sets."""
    folder = os.environ.get("COHELM_DATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs the outside data sets: set COHELM_DATA to their folder")
    return Path(folder)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)


@pytest.fixture(scope="session")
def chair() -> Robot:
    return load_robot("quantum_q6_edge")


@pytest.fixture
def toys(monkeypatch) -> Path:
    """The folder of modules that processes of their own can import by name."""
    folder = Path(__file__).parent / "toys"
    monkeypatch.syspath_prepend(folder)
    return folder


@pytest.fixture
def made_ride():
    """Builds a ride from poses."""
    return made_rides.made_ride
