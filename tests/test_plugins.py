import sys
from importlib.metadata import EntryPoint

import pytest

from cohelm import plugins
from cohelm.config import Model
from cohelm.errors import ConfigError, PluginError, ScenarioError


class Greeter:
    class Parameters(Model):
        word: str = "hello"

    def __init__(self, parameters):
        self.parameters = parameters


class Bare:
    """No parameter model."""


@pytest.fixture
def installed(monkeypatch):
    """Four parts of kind ``riders``, as if distributions had brought them."""
    here = __name__
    monkeypatch.setitem(sys.modules, here, sys.modules[__name__])
    entries = [
        EntryPoint(name=name, value=value, group="cohelm.riders")
        for name, value in {
            "greeter": f"{here}:Greeter",
            "bare": f"{here}:Bare",
            "gone": "no_such_module_at_all:Rider",
            "renamed": f"{here}:NoSuchClass",
        }.items()
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: entries)


@pytest.mark.usefixtures("installed")
class TestLookup:
    def test_names_are_sorted_and_import_nothing(self):
        assert plugins.names("riders") == ("bare", "gone", "greeter", "renamed")
        assert "no_such_module_at_all" not in sys.modules

    def test_an_unknown_name_names_the_nearest(self):
        with pytest.raises(
            PluginError, match="no rider is called 'greter'; did you mean 'greeter'"
        ):
            plugins.load("riders", "greter")

    def test_an_unknown_name_far_from_all_lists_them(self):
        with pytest.raises(PluginError, match="known: bare, gone, greeter, renamed"):
            plugins.load("riders", "zzzzzz")

    @pytest.mark.parametrize(
        ("name", "cause"), [("gone", ModuleNotFoundError), ("renamed", AttributeError)]
    )
    def test_a_part_that_does_not_import_says_why(self, name, cause):
        with pytest.raises(PluginError, match=f"does not import: {cause.__name__}") as raised:
            plugins.load("riders", name)
        assert isinstance(raised.value.__cause__, cause)

    def test_a_part_without_parameters_is_refused(self):
        with pytest.raises(PluginError, match="no nested Parameters model"):
            plugins.load("riders", "bare")

    def test_build_takes_a_name_or_a_mapping(self):
        assert plugins.build("riders", "greeter").parameters.word == "hello"
        built = plugins.build("riders", {"use": "greeter", "word": "good day"})
        assert built.parameters.word == "good day"

    def test_build_leaves_the_mapping(self):
        spec = {"use": "greeter"}
        plugins.build("riders", spec)
        assert spec == {"use": "greeter"}

    def test_a_wrong_parameter_is_named_with_its_place(self):
        with pytest.raises(ScenarioError) as raised:
            plugins.build(
                "riders",
                {"use": "greeter", "wort": "x"},
                file="a.yaml",
                key="rider",
                error=ScenarioError,
            )
        assert str(raised.value) == "a.yaml: rider.wort: unknown; did you mean 'word'?"

    @pytest.mark.parametrize("spec", [{}, {"use": 3}, {"word": "x"}])
    def test_a_mapping_must_say_which(self, spec):
        with pytest.raises(ConfigError, match="say which one with 'use'"):
            plugins.build("riders", spec)


def test_origin_names_class_and_distribution():
    assert plugins.origin("kinematics", "unicycle") == ("cohelm.robots:Unicycle", "cohelm")
