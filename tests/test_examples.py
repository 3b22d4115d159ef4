"""Every example runs, alone, and says what its docstring promises."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("[0-9]*.py"))


def run(example, folder):
    done = subprocess.run(
        [sys.executable, "-W", "error", str(example)],
        cwd=folder,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


def test_examples_are_numbered_without_a_gap():
    numbers = [int(example.name[:2]) for example in EXAMPLES]
    assert numbers == list(range(1, len(EXAMPLES) + 1))


SAYS = {
    "01_plan_a_path": r"shortest +13\.\d+ m\nby the window .* costs \+\d",
    "02_ride": r"left : reached, passed on the left.*\n.*right: reached, passed on the right",
    "03_add_a_part": r"contract satisfied.*\ncontract violated: the deviation must not decrease",
    "04_wishes": r"soft_via .*\nnot through .*\nalong a line .*\nroutes .*:\n  .* room\n  .* room",
    "05_detect_people": r"told: 6 people, 6 are there\n.*: 0\.[01]\d m\n(together: .*\n){2}",
    "06_keep_right": (
        r"without the term.* [-+]0\.[01]\d m to(.*\n)+keeping right.* \+0\.[2-6]\d m to"
    ),
}


@pytest.mark.parametrize(
    "example",
    [
        pytest.param(each, id=each.stem, marks=[pytest.mark.slow] * (each.stem == "02_ride"))
        for each in EXAMPLES
    ],
)
def test_an_example_runs_and_leaves_no_file(example, tmp_path):
    assert re.search(SAYS[example.stem], run(example, tmp_path))
    assert list(tmp_path.iterdir()) == []
