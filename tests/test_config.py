import numpy as np
import pytest
from pydantic import Field

from cohelm.config import Model, load, nearest, number_record, override, read_yaml, validate
from cohelm.errors import ConfigError, ScenarioError


class Planner(Model):
    horizon: float = Field(2.5, gt=0.0)
    steps: int = 25


class Scenario(Model):
    name: str
    planner: Planner = Planner()
    planners: tuple[Planner, ...] = ()
    spare: Planner | None = None


def fault(data, **options):
    with pytest.raises(ConfigError) as raised:
        validate(Scenario, data, **options)
    return raised.value


@pytest.mark.parametrize(
    ("data", "key", "says"),
    [
        ({"nam": "x"}, "nam", "unknown; did you mean 'name'?"),
        ({"name": "x", "planner": {"horizonn": 1.0}}, "planner.horizonn", "'horizon'"),
        ({"name": "x", "spare": {"stepps": 1}}, "spare.stepps", "'steps'"),
        ({"name": "x", "qqq": 1}, "qqq", "known: name, planner, planners, spare"),
        ({"name": "x", "planner": {"horizon": -1.0}}, "planner.horizon", "greater than 0"),
        ({"name": "x", "planner": {"horizon": "long"}}, "planner.horizon", "got 'long'"),
        ({"name": "x", "planner": {"horizon": float("nan")}}, "planner.horizon", "finite"),
        ({"name": "x", "planner": {"steps": 2.5}}, "planner.steps", "got 2.5"),
        ({}, "name", "missing, and it has no default"),
    ],
)
def test_a_fault_is_named_by_its_dotted_key_and_what_to_do(data, key, says):
    error = fault(data)
    assert error.key == key
    assert says in error.problem
    assert "\n" not in str(error)


def test_an_unknown_key_is_reported_before_what_it_causes():
    """A misspelt required key is also a missing one; the misspelling is the useful half."""
    assert "did you mean 'name'" in str(fault({"nmae": "x"}))


def test_file_and_prefix_stand_in_front():
    error = fault({"name": "x", "planner": {"stps": 1}}, file="a.yaml", prefix="ride")
    assert str(error) == "a.yaml: ride.planner.stps: unknown; did you mean 'steps'?"


def test_a_part_of_a_list_is_named_by_its_index():
    assert fault({"name": "x", "planners": [{}, {"horizon": 0.0}]}).key == "planners.1.horizon"


def test_the_wanted_type_is_raised():
    with pytest.raises(ScenarioError):
        validate(Scenario, {}, error=ScenarioError)


def test_a_model_is_frozen():
    with pytest.raises(ValueError, match="frozen"):
        Planner().horizon = 3.0


def write(folder, text):
    file = folder / "scenario.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def test_load_reads_what_was_written(tmp_path):
    file = write(tmp_path, "name: hall\nplanner: {horizon: 1e-1}\n")
    assert load(Scenario, file) == Scenario(name="hall", planner=Planner(horizon=0.1))


def test_an_empty_file_is_an_empty_mapping(tmp_path):
    assert read_yaml(write(tmp_path, "# nothing\n")) == {}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name: a\nname: b\n", "line 2: the key 'name' is given twice"),
        ("planner: {steps: 1, steps: 2}\n", "'steps' is given twice"),
        ("name: [\n", "not YAML: line 2"),
        ("- a\n- b\n", "must be a mapping"),
        ("just words\n", "must be a mapping"),
        ("? [a]\n: b\n", "a key must be a word"),
        ("name: !!python/object/apply:os.getcwd []\n", "not YAML"),
    ],
)
def test_a_bad_file_is_a_one_line_error_with_the_file(tmp_path, text, says):
    file = write(tmp_path, text)
    with pytest.raises(ConfigError) as raised:
        read_yaml(file)
    assert str(raised.value).startswith(f"{file}: ")
    assert says in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.yaml: no such file"):
        read_yaml(tmp_path / "none.yaml")


def test_a_file_that_is_not_text_says_so(tmp_path):
    file = tmp_path / "image.yaml"
    file.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ConfigError, match="cannot be read as text"):
        read_yaml(file)


def test_a_folder_is_not_a_file(tmp_path):
    with pytest.raises(ConfigError, match="is a folder"):
        read_yaml(tmp_path)


def test_override_goes_deep_and_leaves_the_original():
    data = {"people": {"count": 12, "speed": 1.2}, "name": "x"}
    got = override(data, ["people.count=5", "people.see_robot=false", "local.planner.use=dwa"])
    assert got["people"] == {"count": 5, "speed": 1.2, "see_robot": False}
    assert got["local"] == {"planner": {"use": "dwa"}}
    assert data == {"people": {"count": 12, "speed": 1.2}, "name": "x"}


@pytest.mark.parametrize(
    ("text", "means"),
    [
        ("3", 3),
        ("1e-3", 1e-3),
        ("true", True),
        ("left", "left"),
        ("[1, 2]", [1, 2]),
        ("a=b", "a=b"),
    ],
)
def test_an_override_is_read_as_yaml(text, means):
    assert override({}, [f"key={text}"]) == {"key": means}


def test_a_later_override_wins():
    assert override({}, ["a=1", "a=2"]) == {"a": 2}


@pytest.mark.parametrize("setting", ["people", "=3", "people.=3", ".count=3", "a..b=3"])
def test_a_setting_that_is_none_says_how_to_write_it(setting):
    with pytest.raises(ConfigError, match="key=value"):
        override({}, [setting])


def test_a_setting_cannot_go_through_a_value():
    with pytest.raises(ConfigError, match="'name' holds a value"):
        override({"name": "x"}, ["name.first=3"])


def test_a_setting_that_is_no_yaml_says_so():
    with pytest.raises(ConfigError, match="not a YAML value"):
        override({}, ["a=[1,"])


def test_nearest_says_the_near_one_or_all():
    assert nearest("hospitl", ["hospital", "crossing"]) == "; did you mean 'hospital'?"
    assert nearest("zzz", ["b", "a"]) == "; known: a, b"
    assert nearest("zzz", []) == ""


class Price(Model):
    weight: float = 1.0
    square: float = 2.0


class Stack(Model):
    near: Price = Price(weight=5.0)
    far: Price = Price()


class Controller(Model):
    stack: Stack = Stack(far=Price(square=9.0))


@pytest.mark.parametrize("build", [Controller.model_validate, lambda data: Controller(**data)])
def test_what_a_nested_setting_does_not_name_keeps_the_fields_own_default(build):
    found = build({"stack": {"near": {"square": 0.5}, "far": {"weight": 3.0}}})
    assert found.stack.near == Price(weight=5.0, square=0.5)
    assert found.stack.far == Price(weight=3.0, square=9.0)
    assert build({}) == Controller()
    assert build({"stack": Stack()}).stack == Stack()


def test_a_misspelt_nested_key_is_named_in_full():
    with pytest.raises(ConfigError, match="weight") as caught:
        validate(Controller, {"stack": {"near": {"wieght": 0.5}}})
    assert caught.value.key == "stack.near.wieght"


def test_a_number_record_has_the_numbers_of_a_model_by_name():
    class Mixed(Model):
        share: float = 0.5
        hits: int = 3
        on: bool = True
        name: str = "tracker"

    record = number_record(Mixed(share=0.25))
    assert (record.dtype.names, record["share"], record["hits"]) == (("share", "hits"), 0.25, 3)
    assert [record.dtype[name] for name in record.dtype.names] == [np.float64, np.int64]


@pytest.mark.parametrize(
    "text",
    [
        "x: &x [*x]",
        "x: &x {y: *x}",
        "\n".join(
            [
                "a0: &a0 [1]",
                *(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 9)),
            ]
        ),
    ],
)
def test_aliases_that_unfold_without_end_are_refused(tmp_path, text):
    file = tmp_path / "x.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"x\.yaml: not YAML: too many values"):
        read_yaml(file)
    with pytest.raises(ConfigError, match="too many values"):
        override({}, [f"a={{{', '.join(text.splitlines())}}}"])


def test_an_alias_of_use_is_read(tmp_path):
    file = tmp_path / "x.yaml"
    file.write_text("a: &a [1, 2]\nb: *a\n")
    assert read_yaml(file) == {"a": [1, 2], "b": [1, 2]}


def test_an_integer_beyond_all_use_is_refused():
    assert "is not a plausible number" in str(fault({"name": "x", "planner": {"steps": 10**400}}))
