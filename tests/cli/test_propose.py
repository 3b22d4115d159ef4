"""``cohelm propose``, ``choose`` and ``preferences``."""

import json

import numpy as np
import pytest
from PIL import Image

from .conftest import mask, write_map

ENDS = ("--start", "-8.5,0", "--goal", "8.5,0")


@pytest.fixture(autouse=True)
def at_home(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data" / "cohelm" / "riders"


@pytest.fixture
def floor(tmp_path):
    """A map file of 20 × 12 m with two blocks in it: three ways from left to right."""
    pixels = np.full((120, 200), 254, dtype=np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    pixels[20:48, 40:160] = pixels[68:96, 30:170] = 0
    Image.fromarray(pixels).save(tmp_path / "room.pgm")
    return write_map(tmp_path / "room.yaml", origin=[-10.0, -6.0, 0.0])


@pytest.fixture
def propose(cohelm, floor):
    def _propose(*more):
        return cohelm("propose", floor, *ENDS, *more)

    return _propose


def proposed(propose, *more):
    code, out, _ = propose("--json", *more)
    assert code == 0
    return json.loads(out)


def test_routes_come_ranked_with_words(propose):
    code, out, err = propose()
    assert (code, err) == (0, "")
    assert "the planner's own" in out
    assert "longer" in out
    assert "no rider is named" in out


def test_json_is_one_object_with_every_figure(propose):
    code, out, _ = propose("--json", "--prefer", "0,5")
    assert code == 0
    assert out.count("\n") == 1
    report = json.loads(out)
    assert len(report["routes"]) > 1
    for each in report["routes"]:
        assert {"length", "time", "minimum_clearance", "crowding", "turns", "doors"} <= set(each)
        assert len(each["closest_to_each"]) == 1
        assert each["overlap"] <= 0.7
    assert report["taken"] is None


def test_nothing_is_chosen_silently(cohelm, propose, at_home):
    for _ in range(7):
        propose("--rider", "ada")
    assert not (at_home / "ada.json").exists()
    code, _, err = cohelm("preferences", "show", "--rider", "ada")
    assert code == 2
    assert "no rider is called 'ada'" in err


def test_choices_are_noted_learned_and_forgotten(cohelm, propose, at_home):
    longest = max(
        range(3), key=lambda i: proposed(propose)["routes"][i]["length"]
    )  # a rider who likes the long way round
    for count in range(1, 6):
        assert propose("--rider", "ada")[0] == 0
        code, out, _ = cohelm("choose", longest + 1, "--rider", "ada")
        assert code == 0
        assert f"{count} choice" in out
    report = proposed(propose, "--rider", "ada")
    assert report["learned"]
    lengths = [each["length"] for each in report["routes"]]
    assert lengths[0] == max(lengths)
    code, out, _ = cohelm("preferences", "show", "--rider", "ada")
    assert code == 0
    assert "longer routes" in out
    assert "100%" in out
    shown = json.loads(cohelm("preferences", "show", "--rider", "ada", "--json")[1])
    assert (shown["choices"], shown["explained"]) == (5, 1.0)
    assert cohelm("preferences", "reset", "--rider", "ada")[0] == 0
    assert not (at_home / "ada.json").exists()
    assert not proposed(propose, "--rider", "ada")["learned"]


def test_take_notes_at_once(propose, at_home):
    code, out, _ = propose("--rider", "ada", "--take", "2")
    assert code == 0
    assert "recorded: route 2" in out
    saved = json.loads((at_home / "ada.json").read_text())
    assert saved["choices"][0]["taken"] == 1


def test_a_choice_is_noted_once(cohelm, propose):
    propose("--rider", "ada")
    assert cohelm("choose", "1", "--rider", "ada")[0] == 0
    code, _, err = cohelm("choose", "1", "--rider", "ada")
    assert code == 2
    assert "nothing was proposed" in err


def test_a_file_of_ones_own(cohelm, propose, tmp_path):
    file = tmp_path / "mine.json"
    assert propose("--rider", file, "--take", "1")[0] == 0
    assert json.loads(file.read_text())["name"] == "mine"
    assert cohelm("preferences", "show", "--rider", file)[0] == 0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--take", "1"), "--take: add --rider"),
        (("--take", "9", "--rider", "ada"), "take 1 to 3"),
        (("--rider", "../ada"), "cannot be the name of a rider"),
        (("--method", "upff"), "did you mean 'upf'"),
        (("--alternatives", "0"), "--alternatives"),
        (("--plot", "routes.txt"), "write a picture as"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(propose, more, said):
    code, _, err = propose(*more)
    assert code == 2
    assert said in err
    assert err.count("\n") == 1


def test_a_slip_in_the_name_is_asked_about(propose):
    propose("--rider", "ada", "--take", "1")
    code, _, err = propose("--rider", "adda")
    assert code == 0
    assert "did you mean 'ada'" in err


def test_a_broken_file_is_named_and_kept(cohelm, propose, at_home):
    at_home.mkdir(parents=True)
    (at_home / "ada.json").write_text("{")
    for command in (
        lambda: propose("--rider", "ada"),
        lambda: cohelm("preferences", "show", "--rider", "ada"),
    ):
        code, _, err = command()
        assert code == 2
        assert "ada.json" in err
        assert "reset" in err
    assert (at_home / "ada.json").read_text() == "{"
    assert cohelm("preferences", "reset", "--rider", "ada")[0] == 0
    assert (at_home / "ada.json.bak").read_text() == "{"


def test_one_way_is_no_choice(cohelm, room):
    code, out, _ = cohelm("propose", room, "--start", "-4,0", "--goal", "4,0", "--rider", "ada")
    assert code == 0
    assert "no other route differs enough" in out
    code, _, err = cohelm("choose", "1", "--rider", "ada")
    assert code == 2
    assert "only one route" in err


def test_all_routes_are_drawn(propose, tmp_path):
    file = tmp_path / "routes.png"
    assert propose("--plot", file, "--prefer", "0,5", "--avoid", "0,0,1")[0] == 0
    with Image.open(file) as picture:
        assert min(picture.size) > 300


def test_it_takes_what_plan_takes_and_says_what_plan_notes(propose, tmp_path):
    line = tmp_path / "line.csv"
    line.write_text("-6,0\n0,0\n6,0\n")
    pixels = np.full((120, 200), 254, dtype=np.uint8)
    keepout = mask(tmp_path, "keepout", pixels, origin=[-10.0, -6.0, 0.0])
    code, out, err = propose(
        "--json", "--prefer=5,0", "--prefer=33,0", "--ordered", "--stroke", line,
        "--keepout", keepout, "--speed-mask", keepout, "--clearance", "0.05",
        "--set", "closeness=1", "--avoid-hard=-8.5,0,0.2",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert json.loads(out)["notes"] == [
        "the start lies inside zone 1, never to enter: the route leads out of it first",
        "point 2 (33, 0) lies off the map",
    ]
