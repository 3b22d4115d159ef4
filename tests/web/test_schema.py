import json

import jsonschema_rs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.live.messages import FROM_PAGE, ChairState, Heartbeat, Limits
from cohelm.web.schema import FILE, MEASURES, as_text, measures_as_text, messages_schema

SCHEMA = json.loads(as_text())


def validator(name):
    return jsonschema_rs.Draft7Validator(
        {**SCHEMA["properties"][name], "definitions": SCHEMA["definitions"]}
    )


def test_the_file_is_current():
    assert FILE.read_text(encoding="utf-8") == as_text(), "run: python -m cohelm.web.schema"


def test_the_table_of_measures_is_the_one_of_the_reports():
    assert MEASURES.read_text(encoding="utf-8") == measures_as_text(), "run: make schema"


def test_it_is_a_schema():
    assert jsonschema_rs.meta.is_valid(SCHEMA)


def test_a_page_may_leave_out_what_has_a_default_and_never_the_type():
    beat = messages_schema()["definitions"]["Heartbeat"]
    assert beat["required"] == ["type", "seq", "sent"]
    assert not validator("fromPage").is_valid({"seq": 0, "sent": 0.0})


def test_a_state_comes_whole():
    state = messages_schema()["definitions"]["ChairState"]
    assert set(state["required"]) == set(ChairState.model_fields)


@given(
    st.builds(
        Heartbeat,
        seq=st.integers(0, 2**53 - 1),
        sent=st.floats(0.0, 1e15),
        forward=st.floats(-1.0, 1.0),
        left=st.floats(-1.0, 1.0),
    )
)
def test_what_is_a_message_keeps_to_it(beat):
    assert validator("fromPage").is_valid(json.loads(beat.model_dump_json()))


@pytest.mark.parametrize(
    "wrong", [{"forward": 1.1}, {"seq": -1}, {"seq": 0.5}, {"more": 1}, {"device": "mind"}]
)
def test_what_is_none_does_not(wrong):
    message = {"type": "heartbeat", "seq": 0, "sent": 0.0, **wrong}
    assert not validator("fromPage").is_valid(message)
    with pytest.raises(ValueError, match="validation error"):
        FROM_PAGE.validate_python(message)


def test_limits_are_bounded_in_both():
    bounds = SCHEMA["definitions"]["Limits"]["properties"]["max_speed"]
    assert (bounds["minimum"], bounds["maximum"]) == (0.1, 3.0)
    with pytest.raises(ValueError, match="max_speed"):
        Limits(max_speed=3.1, max_acceleration=0.5, min_distance=0.3)
