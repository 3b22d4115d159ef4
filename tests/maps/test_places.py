"""Named places: lookup, the point of an area, the sidecar file."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.errors import MapError
from cohelm.geometry import distance_to_polygon
from cohelm.maps import (
    NamedPlace,
    Places,
    innermost_point,
    places_beside,
    read_places,
    write_places,
)

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])


@pytest.fixture
def sidecar(tmp_path):
    file = tmp_path / "floor.places.yaml"
    file.write_text(
        "Reception: [1.5, 2]\n"
        "Ward 3: {polygon: [[0, 0], [4, 0], [4, 4], [0, 4]]}\n"
        "Bay: {polygon: [[0, 0], [2, 0], [2, 2], [0, 2]], point: [0.5, 1.5]}\n"
        "Straße: {point: [7, 7]}\n"
    )
    return file


def test_points_areas_and_areas_with_a_point(sidecar):
    places = read_places(sidecar)
    assert places.names == ("Reception", "Ward 3", "Bay", "Straße")
    assert len(places) == 4
    assert places.find("Reception").point.tolist() == [1.5, 2.0]
    assert places.find("Reception").polygon is None
    assert places.find("Ward 3").point == pytest.approx([2.0, 2.0], abs=0.01)
    assert places.find("Bay").point.tolist() == [0.5, 1.5]
    assert places.find("Straße").point.tolist() == [7.0, 7.0]


@pytest.mark.parametrize("name", ["Ward 3", "ward 3", " WARD  3 ", "wArD 3"])
def test_case_and_spaces_do_not_count(sidecar, name):
    assert read_places(sidecar).find(name).name == "Ward 3"


def test_an_unknown_name_gets_the_nearest_and_the_file(sidecar):
    with pytest.raises(MapError, match="no place 'Receptoin'; did you mean 'Reception'") as caught:
        read_places(sidecar).find("Receptoin")
    assert str(sidecar) in str(caught.value)
    with pytest.raises(MapError, match="known: Bay, Reception, Straße, Ward 3"):
        read_places(sidecar).find("xyz")
    with pytest.raises(MapError, match="has no named places"):
        Places().find("Ward 3")


def test_where_one_is_is_the_smallest_area_around(sidecar):
    places = read_places(sidecar)
    assert places.at([1.0, 1.0]) == "Bay"
    assert places.at([3.0, 1.0]) == "Ward 3"
    assert places.at([5.0, 1.0]) == ""
    assert places.at(np.array([7.0, 7.0])) == ""  # a place that is a point contains nothing
    assert Places().at([0.0, 0.0]) == ""


def test_the_sidecar_is_found_by_the_maps_stem(sidecar):
    assert places_beside(sidecar.parent / "floor.yaml").names[0] == "Reception"
    assert places_beside(sidecar.parent / "floor.pgm").names[0] == "Reception"
    nothing = places_beside(sidecar.parent / "other.yaml")
    assert len(nothing) == 0
    with pytest.raises(MapError, match=r"other.yaml: .*has no named places"):
        nothing.find("Ward 3")


def test_written_places_are_read_back(sidecar, tmp_path):
    places = read_places(sidecar)
    write_places(places, tmp_path / "again.yaml")
    again = read_places(tmp_path / "again.yaml")
    assert again.names == places.names
    for a, b in zip(places, again, strict=True):
        assert a.point.tolist() == b.point.tolist()
        assert np.array_equal(a.polygon, b.polygon)
    with pytest.raises(MapError, match="cannot be written"):
        write_places(places, tmp_path / "none" / "x.yaml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Ward: [1]", "Ward: a point is two finite numbers"),
        ("Ward: [1, .nan]", "Ward: a point is two finite numbers"),
        ("Ward: [1, here]", "Ward: a point is two finite numbers"),
        ("Ward: 3", r"Ward: must be a point \[x, y\]"),
        ("Ward: {}", r"Ward: must be a point \[x, y\]"),
        (
            "Ward: {polygn: [[0, 0], [1, 0], [1, 1]]}",
            "unknown key 'polygn'; did you mean 'polygon'",
        ),
        ("Ward: {polygon: [[0, 0], [1, 0]]}", "three or more points"),
        ("Ward: {polygon: [[0, 0], [1, 0], [1]]}", "three or more points"),
        ("Ward: {polygon: [[0, 0], [1, 1], [2, 2]]}", "no area"),
        ("Ward: {polygon: [[0, 0], [2, 0], [2, 2], [0, 2]], point: [1]}", "two finite numbers"),
        ("Ward: [1, 2]\nward: [3, 4]", "each place needs its own name"),
        ("'': [1, 2]", "each place needs its own name"),
        ("[1, 2]", "must be a mapping"),
        ("Ward: [1, 2", "not YAML"),
    ],
)
def test_a_sidecar_that_says_what_cannot_be(tmp_path, text, says):
    file = tmp_path / "m.places.yaml"
    file.write_text(text)
    with pytest.raises(MapError, match=says) as caught:
        read_places(file)
    assert str(caught.value).startswith(str(file))


def test_no_such_sidecar(tmp_path):
    with pytest.raises(MapError, match="no such file"):
        read_places(tmp_path / "none.yaml")


class TestInnermostPoint:
    def test_of_a_right_triangle_is_its_incentre(self):
        # 3-4-5: the inscribed circle's radius is (3 + 4 − 5)/2 = 1, its centre (1, 1)
        triangle = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])
        assert innermost_point(triangle, precision=1e-4) == pytest.approx([1.0, 1.0], abs=1e-2)

    def test_of_an_l_is_in_it_though_its_centroid_is_not(self):
        # arms 1 m wide, 10 m long: the largest circle sits in the corner, on the diagonal, where
        # distance t√2 … to the reflex corner (1, 1) equals the distance to the outer walls:
        # r = √2·(1 − r)  →  r = √2/(1 + √2) = 0.5858
        ell = np.array([[0, 0], [10, 0], [10, 1], [1, 1], [1, 10], [0, 10]], dtype=float)
        x, y = innermost_point(ell, precision=1e-3)
        assert -distance_to_polygon(ell, x, y) == pytest.approx(0.5858, abs=1e-3)

    def test_of_a_narrow_slanted_strip(self):
        along, across = np.array([30.0, 40.0]), np.array([-0.08, 0.06])  # 50 m by 0.1 m
        strip = np.array([[0.0, 0.0], along, along + across, across])
        x, y = innermost_point(strip, precision=1e-3)
        assert -distance_to_polygon(strip, x, y) == pytest.approx(0.05, abs=1e-3)

    @given(
        radii=st.lists(st.floats(0.2, 5.0), min_size=3, max_size=12),
        x=st.floats(-50.0, 50.0),
        y=st.floats(-50.0, 50.0),
        seed=st.integers(0, 2**32 - 1),
    )
    def test_no_other_point_lies_deeper(self, radii, x, y, seed):
        angle = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
        star = np.array([x, y]) + np.array(radii)[:, None] * np.stack(
            [np.cos(angle), np.sin(angle)], axis=-1
        )
        px, py = innermost_point(star)
        depth = -distance_to_polygon(star, px, py)
        assert depth > 0.0
        others = np.random.default_rng(seed).uniform(star.min(0), star.max(0), size=(200, 2))
        assert max(-distance_to_polygon(star, a, b) for a, b in others) <= depth + 0.01 + 1e-9


def test_a_place_contains_what_is_inside_its_area():
    place = NamedPlace(name="A", point=np.array([2.0, 2.0]), polygon=SQUARE)
    assert place.contains([0.1, 3.9])
    assert not place.contains([4.1, 2.0])


def test_a_place_has_names_in_other_languages_and_is_found_by_each(tmp_path):
    file = tmp_path / "floor.places.yaml"
    file.write_text(
        "Ward 2: {point: [1, 2], names: {de: Station 2}}\nStation 2: [5, 5]\n", encoding="utf-8"
    )
    places = read_places(file)
    ward, station = places
    assert ward.names == {"de": "Station 2"}
    assert places.find("station 2") is station  # the map's own name first
    assert Places(places=(ward,)).find(" Station  2") is ward
    write_places(places, file)
    assert [each.names for each in read_places(file)] == [{"de": "Station 2"}, {}]


@pytest.mark.parametrize("names", ["[a]", "{de: 3}", "{de: ''}", "Station"])
def test_names_that_are_none_are_refused(tmp_path, names):
    file = tmp_path / "floor.places.yaml"
    file.write_text(f"Ward 2: {{point: [1, 2], names: {names}}}\n", encoding="utf-8")
    with pytest.raises(MapError, match="Ward 2: names"):
        read_places(file)
