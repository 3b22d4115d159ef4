"""What the page about the problem says of its parameters is so."""

import re
from pathlib import Path

import pytest

from cohelm.config import Model
from cohelm.control import SsMpcDcbf
from cohelm.control.objective_tables import TERMS
from cohelm.control.stack import TrackingTerms

PAGE = Path(__file__).parents[2] / "docs" / "local-planning.md"
PARAMETERS = SsMpcDcbf.Parameters()
PARTS = {name: getattr(PARAMETERS.terms, name) for name in type(PARAMETERS.terms).model_fields} | {
    name: getattr(PARAMETERS, name) for name in ("clearance", "choice", "sampling", "verification")
}

TEXT = PAGE.read_text(encoding="utf-8")


def told(name):
    """Defaults in each row of that name."""
    rows = re.findall(rf"^\| `{re.escape(name)}` \|.*$", TEXT, flags=re.M)
    return [dict(re.findall(r"`(\w+)` ([\w.]*\w)", row.rsplit("|", 2)[1])) for row in rows]


def defaults(part):
    return {key: str(value) for key, value in part if not isinstance(value, Model)}


@pytest.mark.parametrize("name", PARTS)
def test_every_parameter_is_told_with_its_default(name):
    assert told(name)[0] == defaults(PARTS[name])


@pytest.mark.parametrize("name", ["input_effort", "track_reference"])
def test_every_parameter_of_tracking_planners_is_told_with_its_default(name):
    assert told(name)[-1] == defaults(getattr(TrackingTerms(), name))


def test_every_summand_of_the_objective_is_a_field_of_the_parameters():
    assert set(TERMS) == set(TrackingTerms.model_fields)
    assert set(TERMS) - set(type(PARAMETERS.terms).model_fields) == {"track_reference"}


def test_the_page_tells_how_many_parameters_there_are():
    """Counted are values: a field of fields counts as many as it has."""

    def count(model):
        return sum(count(each) if isinstance(each, Model) else 1 for _, each in model)

    said = re.search(r"`ss_mpc_dcbf` has (\d+) parameters", TEXT)
    assert said
    assert int(said[1]) == count(PARAMETERS)
