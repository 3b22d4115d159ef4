"""Bad input of every kind: one line that says what to do, exit status 2, no traceback."""

import pytest

ENDS = ("--start=-4,0", "--goal=4,0")


@pytest.fixture
def refused(cohelm):
    def _refused(*arguments):
        code, out, err = cohelm(*arguments)
        lines = err.splitlines()
        assert code == 2, err
        assert out == ""
        assert len(lines) == 1, err
        assert lines[0].startswith("error: ")
        assert "Traceback" not in err
        return lines[0]

    return _refused


# ---------------------------------------------------------------------------- options


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("run", "hospitl"), "did you mean 'hospital'"),
        (("run", "no/such/scenario.yaml"), "no such file"),
        (("run", "empty", "--seed", "-1"), "--seed"),
        (("run", "empty", "--seed", "one"), "--seed"),
        (("run", "empty", "--people", "1.5"), "--people"),
        (("run", "empty", "--mode", "automatic"), "autonomous"),
        (("run", "empty", "--planner", "ss_mpc"), "did you mean 'ss_mpc_dcbf'"),
        (("run", "empty", "--planner", "dwaa"), "error: --planner: "),
        (("run", "empty", "--method", "a*"), "astar"),
        (("run", "empty", "--rider", "nudg"), "did you mean 'nudge'"),
        (("run", "empty", "--robot", "quantum_q6"), "did you mean 'quantum_q6_edge'"),
        (("run", "empty", "--robot", "no_such.yaml"), "no such file"),
        (("run", "empty", "--start", "1;2"), "x,y"),
        (("run", "empty", "--start", "nan,2"), "x,y"),
        (("run", "empty", "--start", "0,0"), "clearance"),
        (("run", "empty", "--goal", "100,7"), "outside the map"),
        (("run", "empty", "--goal", "1,2,3"), "x,y"),
        (("run", "empty", "--goal", "Est"), "did you mean 'East'"),
        (("run", "empty", "--prefer", "here"), "--prefer"),
        (("run", "empty", "--set", "people.count"), "key=value"),
        (("run", "empty", "--set", "peple.count=3"), "did you mean 'people'"),
        (("run", "empty", "--set", "time_limit=soon"), "time_limit"),
        (("run", "empty", "--set", "local_planner.horizn=2"), "local_planner.horizn"),
        (("run", "empty", "--people", "300"), "--people: there is space for"),
        (("run", "empty", "--plot", "ride.docx"), ".png"),
        (("run", "empty", "--animate", "ride.avi"), ".gif"),
        (("run", "empty", "--no-such-option"), "--no-such-option"),
        (("ride", "empty"), "ride"),
        (("bench", "rides", "--scenes", ""), "--scenes"),
        (("bench", "rides", "--planners", ","), "--planners"),
        (("bench", "ablation", "--scenes", " , "), "--scenes"),
        (("bench", "barn", "--worlds", ""), "--worlds"),
        (("bench", "barn", "--planners", ","), "--planners"),
        (("bench", "crowdnav", "--layout", "circle", "--caution", "nan"), "caution"),
        (("bench", "crowdnav", "--layout", "circle", "--caution", "-5"), "caution"),
        (("plan", "no_such.yaml", *ENDS), "no_such.yaml"),
        (("plan", "no_such.yaml", "--goal", "1,2"), "--start"),
    ],
)
def test_wrong_options(refused, arguments, says):
    assert says in refused(*arguments)


# ---------------------------------------------------------------------------- maps


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"image": "no_such.pgm"}, "no_such.pgm"),
        ({"resolution": 0}, "resolution"),
        ({"resolution": None}, "resolution"),
        ({"occupied_thresh": 0.1}, "thresh"),
        ({"origin": [0, 0]}, "origin"),
        ({"orign": [0, 0, 0]}, "orign"),
        ({"mode": "quaternary"}, "mode"),
        ({"negate": 7}, "negate"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_wrong_maps(refused, another_map, room, changes, says):
    file = another_map(**changes)
    for command in (("plan", file), ("run", "empty", "--map", file)):
        line = refused(*command, *ENDS)
        assert says in line
        assert str(file) in line


def test_a_map_that_is_not_yaml(refused, tmp_path):
    file = tmp_path / "map.yaml"
    file.write_text("image: [")
    assert "not YAML" in refused("plan", file, *ENDS)


def test_an_image_that_is_none(refused, another_map, tmp_path):
    (tmp_path / "room.pgm").write_text("not an image")
    assert "room.pgm" in refused("plan", another_map(), *ENDS)


def test_a_map_of_ones_own_needs_both_ends(refused, room):
    assert "--map: no file missing.yaml" in refused("run", "hospital", "--map", "missing.yaml")
    assert "--start" in refused("run", "hospital", "--map", room)
    assert "--goal" in refused("run", "hospital", "--map", room, "--start=-4,0")


def test_a_place_on_a_map_that_names_none(refused, room):
    assert "has no named places" in refused("plan", room, "--start", "Ward 3", "--goal", "4,0")


# ---------------------------------------------------------------------------- robots and scenarios


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name: x", "missing"),
        ("nme: x", "did you mean 'name'"),
        ("{name: x, footprint: [[0, 0]], max_speed: 1}", "footprint"),
        ("- 1", "mapping"),
        ("name: x\nname: y", "twice"),
    ],
)
def test_wrong_robots(refused, tmp_path, text, says):
    file = tmp_path / "chair.yaml"
    file.write_text(text)
    line = refused("run", "empty", "--robot", file)
    assert says in line
    assert str(file) in line


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{floor: hall, start: [2, 7]}", "goal"),
        ("{floor: hall, start: [2, 7], goal: [12, 7], foo: 1}", "foo: unknown"),
        ("{floor: hal, start: [2, 7], goal: [12, 7]}", "did you mean 'hall'"),
        ("{map: no_such.yaml, start: [2, 7], goal: [12, 7]}", "no_such.yaml"),
        ("{start: [2, 7], goal: [12, 7]}", "floor"),
        ("a: b: c", "not YAML"),
    ],
)
def test_wrong_scenarios(refused, tmp_path, text, says):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    assert says in refused("run", file)


def test_a_folder_in_the_place_of_a_file(refused, tmp_path):
    (tmp_path / "x.png").mkdir()
    assert "is a folder" in refused("run", "empty", "--plot", tmp_path / "x.png")


def test_an_output_folder_that_cannot_be(refused, tmp_path):
    (tmp_path / "taken").write_text("")
    assert "--out" in refused("run", "empty", "--out", tmp_path / "taken" / "below")
    assert "--plot" in refused("run", "empty", "--plot", tmp_path / "taken" / "x.png")


@pytest.mark.parametrize(("option", "name"), [("--plot", "x.png"), ("--animate", "x.gif")])
def test_a_picture_that_cannot_be_written_is_refused_before_the_ride(
    refused, tmp_path, option, name
):
    (tmp_path / name).symlink_to(tmp_path / "no" / "such" / "folder")
    assert f"{name} cannot be written" in refused("run", "empty", option, tmp_path / name)
