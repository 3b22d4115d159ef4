"""Every local planner has a page, and what the pages say of parameters is so."""

import math
import re
from pathlib import Path

import pytest

from cohelm import plugins

DOCS = Path(__file__).parents[2] / "docs"
NAMES = plugins.names("local_planners")
ROW = re.compile(r"^\| ((?:`[\w.]+`(?:, )?)+) \| ([^|]+) \|", flags=re.M)


def page(name):
    return (DOCS / f"planners/{name}.md").read_text(encoding="utf-8")


def told(name):
    """(parameter, its default in words) of the tables; ``distance.l1`` leads on to ``l2``."""
    for keys, values in ROW.findall(page(name)):
        folder, words = "", [each.strip() for each in values.split(",")]
        every = re.findall(r"`([\w.]+)`", keys)
        if len(every) == 1:
            words = [values.strip()]
        for key, word in zip(every, words, strict=False):
            folder = key.rpartition(".")[0] or folder
            yield f"{folder}.{key}" if folder and "." not in key else key, word


def default(name, key):
    found = plugins.load("local_planners", name).Parameters()
    for part in key.split("."):
        found = getattr(found, part, None)
    return found


def figures(word):
    """The numbers in a default as it is told, units left out; ``2π`` is one."""
    found = re.findall(r"-?\d+(?:\.\d+)?(?=π| |$|,)", word)
    return [float(x) * (math.pi if "π" in word else 1.0) for x in found]


@pytest.mark.parametrize("name", NAMES)
def test_it_has_a_page_with_a_picture_and_says_when_not_to_use_it(name):
    text = page(name)
    assert re.search(r"^!\[", text, flags=re.M)
    assert "## When not to use it" in text or "no way to drive" in text
    assert f"planners/{name}.md" in (DOCS / "local-planners.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_defaults_are_those_of_the_code(name):
    checked = 0
    for key, word in told(name):
        value = default(name, key)
        if isinstance(value, bool) or not isinstance(value, int | float | tuple):
            continue
        wanted = list(value) if isinstance(value, tuple) else [value]
        assert figures(word) == pytest.approx([float(x) for x in wanted]), key
        checked += 1
    assert checked >= (0 if name in {"ss_mpc_dcbf", "path_follower"} else 5)
