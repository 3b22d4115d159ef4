"""What breaks programs: values YAML cannot hold, names no file can have, streams nobody reads."""

import os
import subprocess
import sys

import pytest

ENDS = ("--start=-4,0", "--goal=4,0")
SHORT = ("run", "empty", "--set", "time_limit=0.2", "-q")


@pytest.fixture
def refused(cohelm):
    def _refused(*arguments):
        code, out, err = cohelm(*arguments)
        assert (code, out, len(err.splitlines())) == (2, "", 1), err
        assert err.startswith("error: ")
        return err

    return _refused


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("image: 2020-99-99", "is no timestamp"),
        ("image: !!int x", "is no int"),
        ("image: !!bool x", "is no bool"),
        ("image: !!timestamp x", "is no timestamp"),
        ("resolution: 0x_", "is no int"),
        ("resolution: " + "9" * 5000, "is no int"),
        ("[" * 3000, "nested too deeply"),
        ("&a\n<<: *a", "merging"),
        ("image: " + "a" * 5000 + "\nresolution: 1\norigin: [0, 0, 0]\n", "occupied_thresh"),
    ],
)
def test_yaml_that_is_none(refused, tmp_path, text, says):
    file = tmp_path / "map.yaml"
    file.write_text(text)
    line = refused("plan", file, *ENDS)
    assert says in line
    assert len(line) < 400


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"image": "a" * 5000}, "image"),
        ({"resolution": 1e-300}, "resolution"),
        ({"resolution": 1e300}, "resolution"),
        ({"origin": [1e300, 0, 0]}, "origin"),
    ],
)
def test_maps_beyond_all_measure(refused, room, another_map, changes, says):
    assert says in refused("plan", another_map(**changes), *ENDS)


def test_a_folder_is_no_building_and_no_scenario(refused, tmp_path):
    (tmp_path / "x.yaml").mkdir()
    for arguments in (("plan", tmp_path), ("plan", tmp_path / "x.yaml")):
        assert "no storey" in refused(*arguments, *ENDS)
    assert "is a folder" in refused("run", tmp_path / "x.yaml")


def test_a_map_too_large_to_people(refused, room, another_map):
    ride = ("run", "empty", "--map", another_map(resolution=100.0))
    assert "too large" in refused(*ride, "--start=2000,2000", "--goal=2500,2000")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("A: [1.0e+300, 0]", "finite"),
        ("A: {polygon: [[0, 0], [1.0e+300, 0], [0, 1.0e+300]]}", "polygon"),
    ],
)
def test_places_beyond_all_measure(refused, room, text, says):
    room.with_name("room.places.yaml").write_text(text)
    assert says in refused("plan", room, *ENDS)


def test_a_place_as_thin_as_a_thread_is_found(cohelm, room):
    text = "Thread: {polygon: [[0, 0], [1000000, 0], [0, 0.01]]}"
    room.with_name("room.places.yaml").write_text(text)
    assert cohelm("plan", room, *ENDS)[0] == 0


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("people.count=2020-99-99", "not a YAML value"),
        ("people.count=" + "[" * 2000, "not a YAML value"),
        ("start=[1.0e+308, 1]", "is not a plausible number"),
        ("start=[.nan, 1]", "must lie within"),
        ("people.pedestrians=[{points: [[1.0e+300, 1]]}]", "people.pedestrians.0.points.0.0"),
        ("obstacles=[{at: [7, 7], size: [-1, 1]}]", "obstacles.0.size.0"),
        ("obstacles=[{at: [7, 7], radius: 1.0e+300}]", "obstacles.0.radius"),
        ("people=3", "must be a mapping"),
        ("people.pedestrians=3", "must be a list"),
        ("people.pedestrians=[{pints: 3}]", "did you mean 'points'"),
        ("rider.foo=1", "nothing to set"),
        ("people.model.foo=1", "people.model.foo: unknown"),
    ],
)
def test_settings_beyond_all_measure(refused, setting, says):
    line = refused("run", "empty", "--set", setting)
    assert says in line
    assert len(line) < 400


@pytest.mark.parametrize("option", ["--start", "--goal", "--prefer"])
def test_points_beyond_all_measure(refused, option):
    assert option in refused("run", "empty", f"{option}=1e308,0")


@pytest.mark.parametrize("option", ["--plot", "--animate"])
def test_a_file_that_takes_nothing(refused, tmp_path, option):
    suffix = ".png" if option == "--plot" else ".gif"
    long = tmp_path / f"{'a' * 300}{suffix}"
    assert option in refused(*SHORT, option, long)
    (tmp_path / f"full{suffix}").symlink_to("/dev/full")
    assert "cannot be written" in refused(*SHORT, option, tmp_path / f"full{suffix}")


def test_a_report_that_cannot_be_written(refused, tmp_path):
    (tmp_path / "ride.json").mkdir()
    assert "--out" in refused(*SHORT, "--out", tmp_path)


@pytest.mark.parametrize("name", ["[bold]x[/no]", r"$\frac$", "Krankenhaus 😀"])
@pytest.mark.filterwarnings("ignore:Glyph")
def test_a_name_is_only_a_name(cohelm, tmp_path, name):
    code, out, err = cohelm(*SHORT[:-1], "--set", f"name='{name}'", "--plot", tmp_path / "x.png")
    assert (code, "Traceback" in err) == (1, False)
    assert out.splitlines()[0] == f"{name}, seed 0"


def test_an_empty_robot_is_not_the_default(refused, room):
    assert "no robot" in refused("plan", room, *ENDS, "--robot", "")


COMMAND = (sys.executable, "-c", "from cohelm.cli import main; main()")


@pytest.mark.parametrize(
    ("redirection", "status", "lines"),
    [
        ("--version >&-", 0, 0),
        ("--version > /dev/full", 2, 1),
        pytest.param("plugins >&-", 0, 0, marks=pytest.mark.slow),
        pytest.param("plugins > /dev/full", 2, 1, marks=pytest.mark.slow),
        pytest.param("run nope 2>&-", 2, 0, marks=pytest.mark.slow),
        ("run nope 2> /dev/full", 2, 0),
    ],
)
def test_streams_that_are_closed_or_full(redirection, status, lines):
    command = ["/bin/sh", "-c", f'"$@" {redirection}', "sh", *COMMAND]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (status, lines), done.stderr


def test_nobody_reads_on():
    command = [*COMMAND, "plugins"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        child.stdout.close()
        assert child.stderr.read() == b""
    assert child.returncode == 141


def test_an_interrupt_is_said_in_one_line(cohelm, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("cohelm.cli.run.run", interrupted)
    code, out, err = cohelm("run", "empty")
    assert (code, out, err.strip()) == (130, "", "interrupted")


def test_an_output_that_lacks_letters():
    command = [*COMMAND, "scenarios"]
    letters = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, env=letters, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
