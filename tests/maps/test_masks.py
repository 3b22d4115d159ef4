"""Masks in Nav2's costmap-filter semantics: what is closed, how fast, and how they are read."""

import warnings

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from cohelm.errors import MapError
from cohelm.geometry import compose
from cohelm.maps import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    CostmapFilter,
    MapWarning,
    OccupancyGrid,
    closed_cells,
    read_crowding,
    read_filter_info,
    read_mask,
    speed_limit_at,
)


def grid_of(data, resolution=0.1, X_MG=(0.0, 0.0, 0.0)):
    return OccupancyGrid(data=np.asarray(data), resolution=resolution, X_MG=np.array(X_MG))


def write(folder, pixels, **about):
    """A map YAML and its image; the pixels' last row is the map's first."""
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(folder / "mask.pgm")
    keys = {
        "image": "mask.pgm",
        "mode": "scale",
        "resolution": 0.5,
        "origin": [1.0, 2.0, 0.0],
        "negate": 0,
        "occupied_thresh": 1.0,
        "free_thresh": 0.0,
        **about,
    }
    file = folder / "mask.yaml"
    file.write_text(yaml.safe_dump(keys), encoding="utf-8")
    return file


def test_a_mask_is_read_with_its_shades(tmp_path):
    # 255 is free, 0 closed, 102 is p = 0.6; the image's rows are upside down.
    mask = read_mask(write(tmp_path, [[255, 0], [102, 255]]), type="keepout")
    assert mask.mask.data.tolist() == [[60, 0], [0, 100]]
    assert (mask.base, mask.multiplier) == (0.0, 1.0)


def test_a_shade_of_a_speed_mask_is_subtracted_from_full_speed_as_in_nav2(tmp_path):
    # Nav2's samples: limit = 100 − value. Value 25 is 75 %, 100 is 0 %, which is no limit.
    mask = read_mask(write(tmp_path, [[0, 25, 90, 100]], mode="raw"), type="speed_percent")
    limits = [speed_limit_at((mask,), np.array([1.25 + 0.5 * k, 2.25]), 1.0) for k in range(4)]
    assert limits == pytest.approx([1.0, 0.75, 0.1, 1.0])


def test_a_given_number_is_used_in_place_of_nav2s(tmp_path):
    file = write(tmp_path, [[25]], mode="raw")
    mask = read_mask(file, type="speed_percent", base=0.0, multiplier=1.0)
    assert speed_limit_at((mask,), np.array([1.25, 2.25]), 1.0) == pytest.approx(0.25)
    absolute = read_mask(file, type="speed_absolute", multiplier=0.01)
    assert speed_limit_at((absolute,), np.array([1.25, 2.25]), 1.0) == pytest.approx(0.25)
    with pytest.raises(MapError, match=r"mask\.yaml: .*speed_absolute needs a multiplier"):
        read_mask(file, type="speed_absolute")


def test_values_that_are_no_limit_are_told(tmp_path):
    file = write(tmp_path, [[0, 25, 50]], mode="raw")
    with pytest.warns(MapWarning, match=r"value 25 gives 125 %.*no limit; so do 1 other"):
        read_mask(file, type="speed_percent", multiplier=1.0)


SERVER = {"use_sim_time": True, "filter_info_topic": "/i", "mask_topic": "/m"}


@pytest.mark.parametrize(
    "wrap",
    [
        lambda given: {"costmap_filter_info_server": {"ros__parameters": given}},
        lambda given: {"speed_costmap_filter_info_server": {"ros__parameters": given}, "amcl": {}},
        lambda given: {"ward": {"costmap_filter_info_server": {"ros__parameters": given}}},
        lambda given: {"/**": {"ros__parameters": given}, "map_server": {"ros__parameters": {}}},
        lambda given: given,
    ],
)
def test_nav2s_parameters_describe_a_mask(tmp_path, wrap):
    file = tmp_path / "params.yaml"
    given = {**SERVER, "type": 2, "base": 0.1, "multiplier": 0.01}
    file.write_text(yaml.safe_dump(wrap(given)))
    info = read_filter_info(file)
    assert (info.filter_type, info.base, info.multiplier) == ("speed_absolute", 0.1, 0.01)
    mask = read_mask(write(tmp_path, [[25]], mode="raw"), info=info)
    assert speed_limit_at((mask,), np.array([1.25, 2.25]), 1.0) == pytest.approx(0.35)


def test_of_several_descriptions_the_one_of_the_type_counts(tmp_path):
    file = tmp_path / "params.yaml"
    both = {
        "keepout_costmap_filter_info_server": {"type": 0, "base": 0.0, "multiplier": 1.0},
        "speed_costmap_filter_info_server": {"type": 1, "base": 100.0, "multiplier": -1.0},
        "binary_costmap_filter_info_server": {"type": 3, "base": 0.0, "multiplier": 1.0},
    }
    file.write_text(yaml.safe_dump({k: {"ros__parameters": v} for k, v in both.items()}))
    assert read_filter_info(file, types=("keepout",)).base == 0.0
    assert read_filter_info(file, types=("speed_percent", "speed_absolute")).base == 100.0
    assert read_filter_info(file, types=("speed_absolute",)) is None
    with pytest.raises(MapError, match="describes 2 such masks"):
        read_filter_info(file)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("amcl: {ros__parameters: {alpha1: 0.2}}", "costmap_filter_info_server"),
        ("{type: 1, base: 100, multiplyer: -1}", "did you mean 'multiplier'"),
        ("{type: speed, base: 100, multiplier: -1}", "type: "),
        ("{type: 1, base: .nan, multiplier: -1}", "base: "),
        ("", "costmap_filter_info_server"),
    ],
)
def test_a_description_that_is_none_names_the_file(tmp_path, text, says):
    (tmp_path / "params.yaml").write_text(text)
    with pytest.raises(MapError, match=rf"params\.yaml: .*{says}"):
        read_filter_info(tmp_path / "params.yaml")


def test_nav2s_own_masks_slow_and_close_where_nav2_does(data):
    folder = data / "ros_maps"
    speed = read_mask(folder / "nav2_depot_speed.yaml", type="speed_percent")
    values, limits = np.unique(speed.mask.data), {}
    for value in values:
        row, col = np.argwhere(speed.mask.data == value)[0]
        point = speed.mask.centres(np.array([row, col]))
        limits[int(value)] = speed_limit_at((speed,), point, 1.0)
    # shades 254, 205, 191, 127 and 0; (255 − 191) / 255 = 25 % of grey leave 75 % of the speed
    assert limits == pytest.approx({0: 1.0, 20: 0.8, 25: 0.75, 50: 0.5, 100: 1.0})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)  # shade 205
        keepout = read_mask(folder / "nav2_depot_keepout.yaml", type="keepout")
    assert closed_cells((keepout,), keepout.mask).sum() == 31_213  # pixels of shade 0


def test_an_error_names_the_file(tmp_path):
    file = write(tmp_path, [[255]])
    with pytest.raises(MapError, match=r"mask\.yaml: .*'keep_out'.*keepout"):
        read_mask(file, type="keep_out")
    with pytest.raises(MapError, match=r"mask\.yaml: .*finite"):
        read_mask(file, type="keepout", base=float("nan"))
    with pytest.raises(MapError, match=r"nothing\.yaml"):
        read_mask(tmp_path / "nothing.yaml", type="keepout")


def test_a_heat_map_is_people_per_square_metre(tmp_path):
    file = write(tmp_path, [[255, 0], [102, 255]])
    crowding = read_crowding(file, people_per_m2_at_full=0.5)
    assert crowding.density == pytest.approx(np.array([[0.3, 0.0], [0.0, 0.5]]))
    assert crowding.resolution == 0.5
    assert crowding.X_MG.tolist() == [1.0, 2.0, 0.0]


def test_a_heat_map_may_have_keys_that_nav2_ignores(tmp_path):
    file = write(tmp_path, [[255]], map_type="occupancy", mode="SCALE")
    with pytest.warns(MapWarning, match="map_type"):
        assert read_crowding(file).density.tolist() == [[0.0]]


def test_where_a_heat_map_is_unknown_nobody_is(tmp_path):
    # In mode raw 255 is no occupancy, hence unknown.
    crowding = read_crowding(write(tmp_path, [[50, 255]], mode="raw"))
    assert crowding.density == pytest.approx(np.array([[0.5, 0.0]]))


@pytest.mark.parametrize("full", [0.0, -1.0, float("inf"), float("nan")])
def test_full_must_be_a_density(tmp_path, full):
    with pytest.raises(MapError, match=r"mask\.yaml: people_per_m2_at_full"):
        read_crowding(write(tmp_path, [[255]]), people_per_m2_at_full=full)


def test_a_heat_map_without_shades_is_refused(tmp_path):
    with pytest.raises(MapError, match=r"mask\.yaml: mode: .*scale or raw"):
        read_crowding(write(tmp_path, [[255]], mode="trinary", free_thresh=0.1))
    with pytest.raises(MapError, match=r"mask\.pgm: .*YAML"):
        read_crowding(tmp_path / "mask.pgm")


def test_closed_is_the_number_100():
    data = [[OCCUPIED, 99, FREE, UNKNOWN]]
    mask = CostmapFilter(type="keepout", mask=grid_of(data))
    assert closed_cells((mask,), mask.mask).tolist() == [[True, False, False, False]]
    # −1·50 + 150 = 100: base and multiplier decide what the numbers are.
    turned = CostmapFilter(type="keepout", mask=grid_of([[50, 51]]), base=150.0, multiplier=-1.0)
    assert closed_cells((turned,), turned.mask).tolist() == [[True, False]]


def test_speed_masks_close_nothing():
    mask = CostmapFilter(type="speed_percent", mask=grid_of([[100]]))
    assert not closed_cells((mask,), mask.mask).any()


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_mask_of_any_pose_and_resolution_closes_what_lies_under_it(seed):
    """The cell of the mask that holds a cell's middle speaks for it; beyond it nothing does."""
    rng = np.random.default_rng(seed)
    mask = grid_of(
        rng.choice([FREE, OCCUPIED, UNKNOWN], size=(6, 7)),
        rng.uniform(0.05, 0.4),
        [*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)],
    )
    grid = grid_of(
        np.zeros((15, 20)), rng.uniform(0.05, 0.2), [*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)]
    )
    rows, cols = np.indices(grid.shape)
    at = mask.cells(grid.centres(np.stack([rows, cols], axis=-1)))
    inside = ((at >= 0) & (at < mask.shape)).all(axis=-1)
    expected = np.zeros(grid.shape, dtype=bool)
    expected[inside] = mask.data[at[inside, 0], at[inside, 1]] == OCCUPIED
    found = closed_cells((CostmapFilter(type="keepout", mask=mask),), grid)
    assert np.array_equal(found, expected)


def test_the_least_speed_limit_counts():
    percent = CostmapFilter(type="speed_percent", mask=grid_of([[40, 80, 0, UNKNOWN]], 1.0))
    absolute = CostmapFilter(
        type="speed_absolute", mask=grid_of([[60, 60, 60, UNKNOWN]], 1.0), multiplier=0.01
    )
    # Full speed 1.0: 40 % is 0.4, 80 % is 0.8, 0 is none; 0.6 m/s everywhere that is known.
    limits = [
        speed_limit_at((percent, absolute), np.array([x, 0.5]), 1.0) for x in (0.5, 1.5, 2.5, 3.5)
    ]
    assert limits == pytest.approx([0.4, 0.6, 0.6, 1.0])
    assert speed_limit_at((percent, absolute), np.array([9.0, 0.5]), 1.0) == 1.0


@pytest.mark.parametrize(
    ("kind", "number"),
    [("speed_percent", 120.0), ("speed_percent", -5.0), ("speed_absolute", -0.1)],
)
def test_a_limit_that_cannot_be_is_none(kind, number):
    mask = CostmapFilter(type=kind, mask=grid_of([[0]], 1.0), base=number)
    assert speed_limit_at((mask,), np.array([0.5, 0.5]), 0.8) == 0.8


def test_a_limit_above_full_speed_changes_nothing():
    mask = CostmapFilter(type="speed_absolute", mask=grid_of([[0]], 1.0), base=3.0)
    assert speed_limit_at((mask,), np.array([0.5, 0.5]), 0.8) == 0.8


def test_keepout_masks_set_no_speed():
    mask = CostmapFilter(type="keepout", mask=grid_of([[50]], 1.0))
    assert speed_limit_at((mask,), np.array([0.5, 0.5]), 0.8) == 0.8


@given(x=st.floats(-3, 3), y=st.floats(-3, 3), yaw=st.floats(-np.pi, np.pi))
def test_turning_world_and_mask_turns_the_limit(x, y, yaw):
    data = np.arange(1, 13).reshape(3, 4)
    mask = grid_of(data, 0.7, [-1.0, -1.0, 0.3])
    X = np.array([0.4, -0.2, yaw])
    turned = grid_of(data, 0.7, compose(X, mask.X_MG))
    point = compose(X, np.array([x, y, 0.0]))[:2]
    cells = (mask.cells(np.array([x, y])) + 0.5 - mask.cells(np.array([x, y]))).tolist()
    assert cells == [0.5, 0.5]
    here = speed_limit_at((CostmapFilter(type="speed_percent", mask=mask),), np.array([x, y]), 1.0)
    near = {
        speed_limit_at((CostmapFilter(type="speed_percent", mask=turned),), point + shift, 1.0)
        for shift in 1e-9 * np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, -1]])
    }
    assert here in near  # on a cell's very edge rounding decides
