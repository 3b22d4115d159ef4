"""What the page about the problem says of its parameters is so."""

import re
from pathlib import Path

import pytest

from cohelm.control import SsMpcDcbf

PAGE = Path(__file__).parents[2] / "docs" / "local-planning.md"
PLANNER = SsMpcDcbf()
PARTS = [*PLANNER.control.costs, *PLANNER.control.constraints]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_every_parameter_is_told_with_its_default(part):
    row = re.search(rf"^\| `{part.name}` \|.*$", PAGE.read_text(encoding="utf-8"), flags=re.M)
    assert row
    told = dict(re.findall(r"`(\w+)` ([\w.]*\w)", row[0].rsplit("|", 2)[1]))
    fields = type(part).Parameters.model_fields
    assert told == {name: str(field.default) for name, field in fields.items()}
