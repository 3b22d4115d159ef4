"""``cohelm building``: what it prints and writes, and its errors."""

import json
import re
import sys

import numpy as np
import pytest
from PIL import Image
from tests.buildings.authored import Author, two_rooms

from cohelm.cli.app import status
from cohelm.maps import places_beside, read_map


@pytest.fixture
def model(tmp_path):
    author, _ = two_rooms(unit=0.001)
    return author.write(tmp_path / "model.ifc")


def test_files_are_those_that_plan_reads(model, tmp_path, capsys):
    out = tmp_path / "out"
    assert status(["building", str(model), "--out", str(out), "--plot", str(out)]) == 0
    said = capsys.readouterr().out
    assert "Ground Floor: floor at 0.00 m, rooms 2, doors 2" in said
    assert "0.90" in said
    assert sorted(file.name for file in out.iterdir()) == [
        "ground-floor.pgm", "ground-floor.places.yaml", "ground-floor.png",
        "ground-floor.route.geojson", "ground-floor.speed.pgm", "ground-floor.speed.yaml",
        "ground-floor.storey.json", "ground-floor.yaml",
    ]  # fmt: skip
    floor = out / "ground-floor.yaml"
    assert np.array(Image.open(out / "ground-floor.png")).std() > 10.0
    places = places_beside(floor)
    assert places.names == ("Office", "Ward 3")
    grid = read_map(floor)
    assert not any(grid.blocked()[tuple(grid.cells(place.point))] for place in places)
    record = json.loads((out / "ground-floor.storey.json").read_text())
    assert record["map"] == "ground-floor.yaml"
    assert [room["number"] for room in record["rooms"]] == ["101", "102"]
    assert sorted(door["width"] for door in record["doors"]) == pytest.approx([0.9, 1.0], abs=0.01)
    plan = ["plan", str(floor), "--start", "Office", "--goal", "Ward 3", "--json"]
    assert status(plan) == 0
    assert json.loads(capsys.readouterr().out)


def test_json_is_one_object(model, capsys):
    assert status(["building", str(model), "--json"]) == 0
    (storey,) = json.loads(capsys.readouterr().out)["storeys"]
    assert storey["name"] == "Ground Floor"


def test_files_are_not_replaced_unasked(model, tmp_path, capsys):
    command = ["building", str(model), "--out", str(tmp_path / "out")]
    assert status(command) == 0
    assert status(command) == 2
    assert "exists; name another folder, or --overwrite" in capsys.readouterr().err
    assert status([*command, "--overwrite"]) == 0


def test_two_buildings_do_not_share_a_folder(model, tmp_path, capsys):
    out = tmp_path / "out"
    assert status(["building", str(model), "--out", str(out)]) == 0
    (out / "ground-floor.storey.json").rename(out / "attic.storey.json")
    before = sorted(out.iterdir())
    assert status(["building", str(model), "--out", str(out), "--overwrite"]) == 2
    assert "another storey, attic" in capsys.readouterr().err
    assert sorted(out.iterdir()) == before


def test_a_plain_map_is_a_building_of_one_storey(tmp_path, capsys):
    pixels = np.full((80, 160), 254, dtype=np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    pixels[:30, 80:83] = pixels[50:, 80:83] = 0
    Image.fromarray(pixels).save(tmp_path / "floor.png")
    (tmp_path / "floor.yaml").write_text(
        "image: floor.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    assert status(["building", str(tmp_path / "floor.yaml"), "--json"]) == 0
    (storey,) = json.loads(capsys.readouterr().out)["storeys"]
    assert len(storey["rooms"]) == 2
    (door,) = storey["doors"]
    assert door["width"] == pytest.approx(1.0, abs=0.05)


def test_a_report_says_which_rooms_the_chair_reaches(tmp_path, chair, capsys):
    width = float(np.ptp(chair.outline[:, 1]))
    author, _ = two_rooms(door=width - 0.02)
    space = next(each for each in author.model.by_type("IfcSpace") if each.Name == "102")
    space.LongName = "<script>Ward"
    model, page = author.write(tmp_path / "model.ifc"), tmp_path / "report.html"
    command = ["building", str(model), "--resolution", "0.025", "--report", str(page)]
    assert status(command) == 0
    said = capsys.readouterr().out
    assert f"{chair.name}: 1 of 2 rooms are reached." in said
    assert "0.02 m too narrow" in said
    assert f"written: {page}" in said
    text = page.read_text(encoding="utf-8")
    assert "1 of 2 rooms are reached." in text
    assert "&lt;script&gt;Ward" in text
    assert "<script" not in text
    assert "404.2.3" in text
    assert text.count("<svg") == 1
    assert not re.search(r"""(src|href)=["'](?!#|data:)""", text)  # nothing from elsewhere
    assert status([*command, "--entrance", "102", "--json", "--overwrite"]) == 0
    access = json.loads(capsys.readouterr().out)["access"]
    assert [room["reached"] for room in access["rooms"]] == [False, True]
    (barrier,) = access["barriers"]
    assert (barrier["kind"], barrier["opens"]) == ("width", ["Office"])


def test_errors_of_a_report_are_one_line(model, tmp_path, capsys):
    page = tmp_path / "report.html"

    def said(*words):
        assert status(["building", str(model), *map(str, words)]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        assert not page.exists()
        return text

    assert "no robot is called 'chiar'" in said("--report", page, "--robot", "chiar")
    assert "no folder" in said("--report", tmp_path / "a" / "report.html")
    assert "ends in .html" in said("--report", model)
    (kept := tmp_path / "kept.html").write_text("kept")
    assert "exists" in said("--report", kept)
    assert kept.read_text() == "kept"
    assert "no room or door 'Offce'; did you mean 'Office'?" in said(
        "--report", page, "--entrance", "Offce"
    )
    assert "does not fit at (0.1,0.1)" in said("--report", page, "--entrance", "0.1,0.1")
    assert "--entrance: is an option of --report" in said("--entrance", "Office")


def broken(kind, folder):
    """A model with one defect."""
    file = folder / f"{kind}.ifc"
    author, _ = two_rooms(schema="IFC2X3") if kind != "no-unit" else two_rooms(unit=0.0)
    if kind == "no-storeys":
        author = Author()
    if kind == "no-placement":
        author.storeys[0].ObjectPlacement = None
    text = author.write(file).read_text()
    if kind == "truncated":
        text = text[: len(text) // 2]
    if kind == "old-schema":
        text = text.replace("IFC2X3", "IFC2X_FINAL")
    if kind == "no-ifc":
        text = "hello"
    if kind == "empty":
        text = ""
    if kind == "damaged":
        text = text.replace("IFCEXTRUDEDAREASOLID(", "IFCEXTRUDEDAREASOLID(,,(").replace(
            "=IFC", "=XX", 5
        )
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    ("kind", "problem"),
    [
        ("truncated", "incomplete: END-ISO-10303-21; is missing"),
        ("old-schema", "IFC2X_FINAL"),
        ("no-storeys", "no IfcBuildingStorey"),
        ("no-unit", "no length unit"),
        ("no-ifc", "not an IFC model"),
        ("empty", "not an IFC model"),
    ],
)
def test_a_broken_model_gives_one_line(kind, problem, tmp_path, capsys):
    file = broken(kind, tmp_path)
    assert status(["building", str(file)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {file}: ")
    assert said.count("\n") == 1
    assert problem in said
    if kind == "no-unit":
        assert "IfcProject" in said


@pytest.mark.parametrize("kind", ["no-placement", "damaged"])
def test_a_damaged_model_gives_no_traceback(kind, tmp_path, capsys):
    assert status(["building", str(broken(kind, tmp_path))]) in {0, 2}
    assert capsys.readouterr().err.count("\n") <= 1


def test_other_errors_are_one_line_too(model, tmp_path, capsys, monkeypatch):
    def said(*words):
        assert status(["building", *map(str, words)]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "No such file" in said(tmp_path / "absent.ifc")
    assert "neither an IFC model" in said(tmp_path / "model.rvt")
    assert "no storey 'Roof': there are 1 'Ground Floor'" in said(model, "--storey", "Roof")
    assert "no folder" in said(model, "--out", tmp_path / "a" / "b")
    with monkeypatch.context() as patch:
        patch.setattr(sys, "executable", "/bin/false")  # as if the child process crashed
        assert "ifcopenshell crashes on its geometry" in said(model)
    monkeypatch.setattr("cohelm.buildings.ifc_file.SIZE_LIMIT", 1000)
    assert "more than the limit of 0 MB" in said(model)
    for module in ("ifc_storeys", "ifc_file"):
        monkeypatch.delitem(sys.modules, f"cohelm.buildings.{module}", raising=False)
    monkeypatch.setitem(sys.modules, "ifcopenshell", None)
    assert "pip install 'cohelm[building]'" in said(model)


@pytest.mark.parametrize(("margin", "code"), [(-0.02, 2), (0.1, 0)])
def test_a_door_narrower_than_the_chair_has_no_route(margin, code, tmp_path, chair, capsys):
    width = float(np.ptp(chair.outline[:, 1]))
    author, _ = two_rooms(door=width + margin)
    model = author.write(tmp_path / "model.ifc")
    assert status(["building", str(model), "--out", str(tmp_path), "--resolution", "0.025"]) == 0
    floor = str(tmp_path / "ground-floor.yaml")
    assert status(["plan", floor, "--start", "Office", "--goal", "Ward 3"]) == code
    if code:
        assert "the passage at (4.2" in capsys.readouterr().err
