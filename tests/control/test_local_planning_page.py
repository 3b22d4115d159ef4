"""What the page about the problem says of its parameters is so."""

import re
from pathlib import Path

import pytest

from cohelm.config import Model
from cohelm.control import SsMpcDcbf
from cohelm.control.objective_tables import TERMS

PAGE = Path(__file__).parents[2] / "docs" / "local-planning.md"
PARAMETERS = SsMpcDcbf.Parameters()
PARTS = {name: getattr(PARAMETERS.terms, name) for name in type(PARAMETERS.terms).model_fields} | {
    name: getattr(PARAMETERS, name) for name in ("clearance", "choice", "sampling", "verification")
}
PARTS["verification.drive"] = PARAMETERS.verification.drive


@pytest.mark.parametrize("name", PARTS)
def test_every_parameter_is_told_with_its_default(name):
    row = re.search(rf"^\| `{re.escape(name)}` \|.*$", PAGE.read_text(encoding="utf-8"), flags=re.M)
    assert row
    told = dict(re.findall(r"`(\w+)` ([\w.]*\w)", row[0].rsplit("|", 2)[1]))
    values = {key: value for key, value in PARTS[name] if not isinstance(value, Model)}
    assert told == {key: str(value) for key, value in values.items()}


def test_every_summand_of_the_objective_is_a_field_of_the_parameters():
    assert set(TERMS) == set(type(PARAMETERS.terms).model_fields)
