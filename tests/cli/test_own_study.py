"""A study in a file of one's own, as ``docs/results.md`` shows it, and files that are none."""

import re
import sys
from pathlib import Path

import pytest

from cohelm.cli.options import Options

DOCS = Path(__file__).parents[2] / "docs" / "results.md"
STUDY = re.search(r"## Your own study.*?```python\n(.*?)```", DOCS.read_text(), re.DOTALL)[1]


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Write a file of its own name in a folder; its text is the example with some changes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])

    def written(name, *changes):
        monkeypatch.delitem(sys.modules, Path(name).stem, raising=False)  # of another test
        text = STUDY
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        Path(name).write_text(text)
        return name

    return written


def test_the_example_of_the_guide_rides(cohelm, study):
    file = study("door_study.py")
    code, out, err = cohelm("bench", file, "--help")
    assert code == 0, err
    assert "Two planners at a narrow door and in a hall." in out
    assert "--width" in out
    code, out, err = cohelm(
        "bench", file, "--seeds", 1, "--workers", 1, "--set", "time_limit=0.3", "--width", 0.9
    )
    assert code == 0, err
    assert "door, 0.9 m" in out
    assert Path("benches/door_study/rows.csv").is_file()
    code, _, err = cohelm("bench", file, "--resume", "--width", 0.8, "--set", "time_limit=0.3")
    assert code == 2
    assert "other options" in err


def test_a_study_that_has_changed_is_not_resumed(cohelm, study):
    short = ("--seeds", 1, "--workers", 1, "--set", "time_limit=0.2")
    assert cohelm("bench", study("changed_study.py"), *short)[0] == 0
    study("changed_study.py", ("TITLE = ", "# another program\nTITLE = "))
    code, _, err = cohelm("bench", "changed_study.py", *short[2:], "--seeds", 2, "--resume")
    assert code == 2
    assert "other code" in err


@pytest.mark.parametrize(
    ("name", "changes", "options", "says"),
    [
        ("s1.py", [('("reached"', '("arrived"')], (), "no figure is called 'arrived'"),
        ("s2.py", [("def create", "def made")], (), "cannot be used as a study"),
        ("s3.py", [("def create(", "def create(:")], (), "cannot be used as a study"),
        ("s4.py", [("width: float = 0.84", "width=0.84")], (), "'width' of create needs a type"),
        ("s5.py", [("width: float = 0.84", "seeds: int = 1, width: float = 0.84")], (), "rename"),
        ("s6.py", [("    return Study(", "    Study(")], (), "which is no study"),
        ("s7.py", [('scene_of("crossing")', 'scene_of("crosing")')], (), "did you mean"),
        ("s8.py", [('"ss_mpc_dcbf", "dwa"]', '"ss_mpc_dcfb", "dwa"]')], (), "did you mean"),
        ("s9.py", [("(places, common", "(common")], (), "one axis of a study names a scenario"),
        ("s10.py", [], ("--set", "floor_plan.doors.0.width=1.4"), "is set by 'door, 0.84 m'"),
        ("s13.py", [(".checked()", "")], ("--set", "floor_plan.doors.0.width=1.4"), "is set by"),
        ("s11.py", [], ("--set", "local_planner.use=mpc"), "is set by --planners"),
        ("s12.py", [("report = partial(ride_report", "report = lambda r, f: (partial(ride_report"),
                    ("claims=CLAIMS))", "claims=CLAIMS)))")],
         ("--workers", "2"), "cannot be sent to worker processes"),
        ("rides.py", [], (), "is the name of something else"),
        ("json.py", [], (), "is the name of something else"),
        ("my.study.py", [], (), "is the name of something else"),
    ],
)  # fmt: skip
def test_a_fault_in_a_study_is_said_in_one_line(cohelm, study, name, changes, options, says):
    code, out, err = cohelm("bench", study(name, *changes), *options)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert says in err


def test_a_list_of_options_without_a_default_may_be_empty():
    def create(settings: tuple[str, ...], speeds: tuple[float, ...] = (1.0,)):
        return settings, speeds

    given = Options(create).values({"settings": None, "speeds": []})
    assert create(**given) == ((), (1.0,))


def test_a_name_that_is_none(cohelm, study):
    study("mine.py")
    for name, says in (
        ("mine", "is named mine.py"),
        ("none.py", "no such file"),
        ("ridse", "rides"),
    ):
        code, _, err = cohelm("bench", name)
        assert code == 2
        assert says in err
