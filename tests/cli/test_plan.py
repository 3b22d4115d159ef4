"""``cohelm plan`` with all of its options."""

import json

import numpy as np
import pytest
import yaml

from cohelm.cli import parsing
from cohelm.cli.parsing import read_stroke, wishes_of
from cohelm.cli.requests import RouteRequest
from cohelm.errors import ConfigError
from cohelm.maps import Places

from .conftest import mask

ENDS = ("--start=-4,-1", "--goal=4,-1")


@pytest.fixture
def plan(cohelm, room):
    """What the JSON of a plan across the room says."""

    def _plan(*options):
        code, out, err = cohelm("plan", room, *ENDS, *options, "--json")
        assert (code, err) == (0, "")
        return json.loads(out)

    return _plan


def highest(report):
    return max(y for _, y in report["points"])


# ---------------------------------------------------------------------------- wishes


def test_a_soft_zone_is_gone_round_where_that_is_cheap(plan):
    report = plan("--avoid", "0,-1,0.5", "--method", "astar")
    assert report["closest_to_zones"][0] > 0.0
    assert report["wishes"][0] == {
        "kind": "avoid", "points": [[0.0, -1.0]], "radius": 0.5, "hard": False
    }  # fmt: skip


def test_a_hard_zone_that_closes_the_room_is_an_error_that_says_so(cohelm, room, tmp_path):
    plot = tmp_path / "no.png"
    wall = ("--avoid-hard", "-0.5,-3 0.5,-3 0.5,3 -0.5,3")
    code, out, err = cohelm("plan", room, *ENDS, *wall, "--plot", plot)
    assert (code, out) == (2, "")
    assert "zones" in err
    assert len(err.splitlines()) == 1
    assert not plot.exists()


def test_a_stroke_is_followed(plan, tmp_path):
    file = tmp_path / "line.csv"
    file.write_text("x,y\n# over the top\n-4,-1\n-2,1.5\n2,1.5\n4,-1\n")
    report = plan("--stroke", file)
    assert highest(report) > 0.5  # straight on it would be −1
    assert len(report["from_strokes"]) == 1


def test_ordered_points_are_one_wish(plan):
    points = ("--prefer=2,1", "--prefer=-2,1", "--set", "closeness=20")
    assert len(plan(*points)["wishes"]) == 2
    ordered = plan(*points, "--ordered")
    assert ordered["wishes"][0]["points"] == [[2.0, 1.0], [-2.0, 1.0]]
    # There and back again costs more than passing them as they lie.
    assert ordered["cost"] > plan(*points)["cost"]


def test_settings_reach_the_planner(plan):
    far = plan("--prefer=0,1.5", "--set", "closeness=0")
    near = plan("--prefer=0,1.5")
    assert far["closest_to_preference"] > near["closest_to_preference"]
    assert far["extra_cost"] == pytest.approx(0.0, abs=1e-9)


def test_alternatives_are_listed_with_their_figures(cohelm, tmp_path):
    pixels = np.full((100, 160), 254, dtype=np.uint8)
    pixels[[0, 1, -1, -2]] = pixels[:, [0, 1, -1, -2]] = 0
    pixels[35:65, 60:100] = 0
    file = mask(tmp_path, "hall", pixels, origin=[0.0, 0.0, 0.0], mode="trinary")
    ends = ("plan", file, "--start=2,4.8", "--goal=14,4.8", "--prefer=8,8", "--alternatives", "3")
    code, out, err = cohelm(*ends, "--json", "--plot", tmp_path / "hall.png")
    assert (code, err) == (0, "")
    report = json.loads(out)
    first, *others = report["alternatives"]
    assert others
    assert first["points"] == report["points"]
    for each in others:
        assert each["overlap"] <= 0.7
        assert each["estimated_time"] > each["length"] / 0.8
    assert "routes to choose from" in cohelm(*ends)[1]


# ---------------------------------------------------------------------------- masks


def test_a_keepout_mask_is_kept_out_of(plan, tmp_path):
    pixels = np.full((60, 100), 254, dtype=np.uint8)
    pixels[20:60, 45:55] = 0  # the lower two thirds; images begin at the top
    assert highest(plan("--keepout", mask(tmp_path, "keep", pixels))) > 1.0


def test_a_speed_mask_costs_time_and_moves_no_route(plan, tmp_path):
    # 100 − 75 = 25 % everywhere: 0.3 m/s of 1.2; 8 m take 8/0.3 − 8/0.8 = 16.7 s more.
    pixels = np.full((60, 100), 75, dtype=np.uint8)
    usual, slow = plan(), plan("--speed-mask", mask(tmp_path, "speed", pixels, mode="raw"))
    assert slow["points"] == usual["points"]
    assert slow["estimated_time"] - usual["estimated_time"] == pytest.approx(16.7, abs=0.6)


def described(folder, name, **given):
    """A parameter file of Nav2's costmap_filter_info_server."""
    file = folder / name
    file.write_text(yaml.safe_dump({"costmap_filter_info_server": {"ros__parameters": given}}))
    return file


def test_the_numbers_of_masks_come_from_options_or_nav2s_description(plan, tmp_path):
    # All of these make 30 of the pixels mean 0.3 m/s, 25 % of full speed.
    pixels = np.full((60, 100), 30, dtype=np.uint8)
    speed = ("--speed-mask", mask(tmp_path, "speed", pixels, mode="raw"))
    percent = described(tmp_path, "percent.yaml", type=1, base=55.0, multiplier=-1.0)
    absolute = described(tmp_path, "absolute.yaml", type=2, multiplier=0.01)
    keepout = described(tmp_path, "keepout.yaml", type=0, base=100.0, multiplier=-1.0)
    free = np.full((60, 100), 100, dtype=np.uint8)
    free[20:60, 45:55] = 0
    inverted = ("--keepout", mask(tmp_path, "keep", free, mode="raw"))
    slow = plan(*speed, "--speed-base", "55")
    assert slow["estimated_time"] - plan()["estimated_time"] == pytest.approx(16.7, abs=0.6)
    for options in (
        ("--speed-base", "-5", "--speed-multiplier", "1"),
        ("--filter-info", percent),
        ("--filter-info", absolute),
        ("--filter-info", absolute, "--speed-base", "0.15", "--speed-multiplier", "0.005"),
    ):
        assert plan(*speed, *options)["estimated_time"] == pytest.approx(slow["estimated_time"])
    both = plan(*speed, *inverted, "--filter-info", keepout, "--filter-info", percent)
    assert highest(both) > 1.0
    assert both["estimated_time"] > slow["estimated_time"]


def test_a_description_of_no_given_mask_is_refused(cohelm, room, tmp_path):
    info = described(tmp_path, "speed.yaml", type=1, base=100.0, multiplier=-1.0)
    keepout = mask(tmp_path, "keep", np.full((60, 100), 254, dtype=np.uint8))
    for options in ((), ("--keepout", keepout)):
        code, out, err = cohelm("plan", room, *ENDS, "--filter-info", info, *options)
        assert (code, out) == (2, "")
        assert "speed.yaml: --filter-info: describes no mask" in err
    code, _, err = cohelm(
        "plan", room, *ENDS, "--filter-info", info, "--filter-info", info, "--speed-mask", keepout
    )
    assert code == 2
    assert "--filter-info: several describe" in err


@pytest.mark.filterwarnings("default::cohelm.maps.MapWarning")
def test_what_is_left_out_of_a_map_reaches_the_user(cohelm, room, another_map):
    assert room.is_file()
    changed = another_map(map_type="occupancy", width=100)
    code, _, err = cohelm("plan", changed, *ENDS)
    assert code == 0
    assert "warning: " in err
    assert "map_type, width" in err


def test_crowds_are_gone_round(plan, tmp_path):
    pixels = np.full((60, 100), 255, dtype=np.uint8)
    pixels[32:60, 40:60] = 0
    report = plan("--crowding", mask(tmp_path, "crowd", pixels))
    assert highest(report) > highest(plan())


# ---------------------------------------------------------------------------- what is said


def test_every_figure_has_its_key(plan):
    report = plan("--prefer=0,1.5", "--avoid", "2,2,0.3")
    assert {
        "alternatives", "backs_out", "closest_to_each", "closest_to_preference",
        "closest_to_zones", "cost", "crowding", "cusps", "doors", "estimated_time", "extra_cost",
        "extra_length", "from_strokes",
        "gaps_to_zones", "length", "method", "minimum_clearance", "notes", "overlap", "pivots",
        "points", "robot", "speed", "timing", "turns", "versions", "wishes", "without_wishes",
    } == set(report)  # fmt: skip
    # The room is 10 × 6 m with walls of 0.1 m; straight on at y = −1 the wheels' side is 1.6 m off.
    assert 0.0 < report["minimum_clearance"] < 1.9


def test_people_read_what_the_wish_costs(cohelm, room):
    code, out, _ = cohelm("plan", room, *ENDS, "--prefer=0,1.5", "--avoid", "3,2,0.3")
    assert code == 0
    assert "the wish costs +" in out
    assert "point 1 (0, 1.5): the route passes within" in out
    assert "zone 1, to avoid: kept" in out


# ---------------------------------------------------------------------------- words and files


@pytest.mark.parametrize(
    ("text", "corners", "radius"),
    [
        ("1,2", [(1, 2)], parsing.ZONE_RADIUS),
        ("-1,2,1.5", [(-1, 2)], 1.5),
        ("0,0 4,0,0.3", [(0, 0), (4, 0)], 0.3),
        ("0,0 4,0 4,3", [(0, 0), (4, 0), (4, 3)], 0.0),
        ("0,0 4,0 4,3 0,3,0.2", [(0, 0), (4, 0), (4, 3), (0, 3)], 0.2),
    ],
)
def test_zones(text, corners, radius):
    assert parsing.zone(text, "--avoid") == (corners, radius)


@pytest.mark.parametrize(
    "text", ["", "1", "1,2,3,4", "1,2,0", "1,2,-1", "a,b", "1,2,3 4,5", "nan,0", "1,1 1,1 2,2"]
)
def test_what_is_no_zone(text):
    with pytest.raises(ConfigError, match="--avoid"):
        parsing.zone(text, "--avoid")


def test_wishes_keep_their_order(tmp_path):
    file = tmp_path / "line.json"
    file.write_text("[[0, 0], [1, 1]]")
    request = RouteRequest(
        map="room.yaml", start="0,0", goal="1,1", prefer=("1,2", "3,4"), avoid=("0,0",),
        avoid_hard=("5,5,1",), stroke=(file,),
    )  # fmt: skip
    kinds = [(wish.kind, wish.hard) for wish in wishes_of(request, Places())]
    assert kinds == [
        ("attract", False), ("attract", False), ("stroke", False), ("avoid", False),
        ("avoid", True),
    ]  # fmt: skip


LINE = '{"type": "LineString", "coordinates": [[0, 0], [1, 1, 5]]}'


@pytest.mark.parametrize(
    "text",
    [
        "0,0\n1,1\n",
        "x,y\n0,0\n\n# a note\n1, 1\n",
        "\ufeff0,0\r\n1,1\r\n",
        "[[0, 0], [1, 1]]",
        LINE,
        f'{{"type": "Feature", "geometry": {LINE}}}',
        f'{{"type": "FeatureCollection", "features": [{{"type": "Feature", "geometry": {LINE}}}]}}',
    ],
)
def test_a_stroke_in_every_form(tmp_path, text):
    file = tmp_path / "line"
    file.write_text(text, encoding="utf-8")
    assert read_stroke(file).tolist() == [[0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "at least two points"),
        ("0,0\n", "at least two points"),
        ("0,0\n1;1\n", "line 2"),
        ("0,0\n1\n", "line 2"),
        ("0,0\nnan,1\n", "metres"),
        ("0,0\n1e300,1\n", "metres"),
        ("[[0, 0], [1, 1]", "not JSON"),
        ("[[0, 0], [true, 1]]", "metres"),
        ('[[0, 0], ["1", 1]]', "metres"),
        ("[[0, 0], [1]]", "metres"),
        ("[0, 1]", "no list"),
        ("{}", "no GeoJSON LineString"),
        ('{"type": "Feature", "geometry": null}', "no GeoJSON LineString"),
        ("[" * 100_000, "not JSON"),
    ],
)
def test_what_is_no_stroke(tmp_path, text, says):
    file = tmp_path / "line"
    file.write_text(text)
    with pytest.raises(ConfigError, match=says) as refused:
        read_stroke(file)
    assert str(file) in str(refused.value)
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--avoid", "here"), "--avoid"),
        (("--avoid-hard", "1,2,0"), "--avoid-hard"),
        (("--stroke", "no_such.csv"), "no_such.csv"),
        (("--stroke", "."), "--stroke"),
        (("--keepout", "no_such.yaml"), "no_such.yaml"),
        (("--speed-mask", "no_such.yaml"), "no_such.yaml"),
        (("--crowding", "no_such.yaml"), "no_such.yaml"),
        (("--alternatives", "0"), "--alternatives"),
        (("--clearance", "-1"), "--clearance"),
        (("--clearance", "nan"), "clearance"),
        (("--speed", "0"), "--speed"),
        (("--method", "softvia"), "did you mean 'soft_via'"),
        (("--set", "closenes=1"), "did you mean 'closeness'"),
        (("--set", "closeness=-1"), "closeness"),
        (("--set", "closeness"), "key=value"),
        (("--set", "use=upf"), "--method"),
    ],
)
def test_wrong_options_in_one_line(cohelm, room, tmp_path, options, says):
    plot = tmp_path / "no.png"
    code, out, err = cohelm("plan", room, *ENDS, *options, "--plot", plot)
    assert (code, out, len(err.splitlines())) == (2, "", 1), err
    assert says in err
    assert not plot.exists()
