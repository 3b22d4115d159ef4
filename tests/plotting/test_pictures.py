import dataclasses
import re
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from PIL import Image

from cohelm.errors import ConfigError
from cohelm.maps import CostmapFilter, NamedPlace, OccupancyGrid, Places
from cohelm.messages import Path, Wish, WishReport
from cohelm.planning import Inflation, RouteProblem, build_costmap
from cohelm.plotting import PlanRecord, animate_ride, canvas, check_animation, draw_plan, draw_ride
from cohelm.plotting import animation as film
from cohelm.plotting.route_panels import RoutePanel, draw_error_plot, draw_route_panels
from cohelm.simulation import FloorPiece, FloorRelief

PIT = FloorPiece(at=np.array([12.0, 7.0]), size=np.array([1.0, 1.0]), angle=0.0, height=-0.5)


@pytest.fixture
def grid():
    data = np.zeros((120, 200), dtype=np.int8)
    data[[0, -1]] = data[:, [0, -1]] = 100
    data[:20, :40] = -1
    return OccupancyGrid(data=data, resolution=0.1, X_MG=np.array([1.0, 2.0, 0.3]))


@pytest.fixture
def route():
    points = np.array([[4.0, 6.0], [9.0, 7.0], [14.0, 9.0]])
    return Path(
        points=points,
        length=10.5,
        cost=11.0,
        method="upf",
        wishes=WishReport(closest=[0.5], extra_length=0.7),
        without_wishes=points + np.array([0.0, 1.0]),
    )


@pytest.fixture
def ride(grid, route, chair):
    k, n = 41, 3
    t = np.linspace(0.0, 2.0, k)
    pose = np.stack([4.0 + 5.0 * t, 6.0 + 1.5 * t, np.full(k, 0.3)], axis=-1)
    people = np.zeros((k, n, 4))
    people[..., 0] = 6.0 + 2.0 * np.arange(n)
    people[..., 1] = 9.0 - t[:, None]
    data = grid.data.copy()
    data[60:65, 100:105] = 100
    return SimpleNamespace(
        grid=grid,
        world=OccupancyGrid(data=data, resolution=0.1, X_MG=grid.X_MG),
        relief=FloorRelief(pieces=(PIT,)),
        places=Places(places=(NamedPlace(name="Hall", point=[9.0, 9.0]),)),
        robot=chair,
        goal=np.array([14.0, 9.0]),
        prefer=np.array([[9.0, 7.0]]),
        time=t,
        pose=pose,
        twist=np.zeros((k, 3)),
        eta=np.linspace(0.0, 1.0, k),
        people=people,
        people_radius=np.full(n, 0.25),
        gap_people=np.hypot(*(people[..., :2] - pose[:, None, :2]).T).T - 0.6,
        path=route,
        ticks=(),
        closest=None,
    )


def test_the_same_ride_gives_the_same_bytes(ride, tmp_path):
    draw_ride(ride, tmp_path / "a.png", title="a ride")
    draw_ride(ride, tmp_path / "b.png", title="a ride")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as image:
        width, height = image.size
    assert 600 < width < 1500
    assert 300 < height < 1300


def test_a_ride_of_one_instant_with_nobody_and_no_route(ride, tmp_path):
    first = {key: getattr(ride, key)[:1] for key in ("time", "pose", "twist", "eta")}
    bare = SimpleNamespace(
        **{
            **vars(ride),
            **first,
            "people": np.empty((1, 0, 4)),
            "people_radius": np.empty(0),
            "gap_people": np.empty((1, 0)),
            "path": None,
            "prefer": np.empty((0, 2)),
        }
    )
    draw_ride(bare, tmp_path / "bare.png")
    assert (tmp_path / "bare.png").is_file()


@pytest.fixture
def plan(grid, route, chair):
    wishes = (
        Wish(points=[[9.0, 7.0], [11.0, 9.0]]),
        Wish(kind="stroke", points=[[5.0, 6.0], [9.0, 8.0]]),
        Wish(kind="avoid", points=[[8.0, 10.0]], radius=0.8),
        Wish(kind="avoid", points=[[11.0, 6.0], [13.0, 6.0], [13.0, 7.0]], hard=True),
        Wish(kind="avoid", points=[[90.0, 90.0]], radius=0.8),
    )
    problem = RouteProblem(
        grid=grid, robot=chair, start=route.points[0], goal=route.points[-1], wishes=wishes
    )
    return PlanRecord(
        problem=problem,
        path=dataclasses.replace(route, pivots=[1]),
        costmap=build_costmap(grid, 0.3, Inflation()),
        others=[route],
    )


def test_a_plan_is_drawn_in_every_format(plan, tmp_path):
    for suffix in (".png", ".svg", ".pdf"):
        file = tmp_path / f"plan{suffix}"
        draw_plan(plan, file)
        assert file.stat().st_size > 1000


def test_a_plan_names_all_that_it_shows(plan, tmp_path):
    file = tmp_path / "plan.svg"
    draw_plan(plan, file)
    draw_plan(plan, tmp_path / "again.svg")
    text = file.read_text()
    assert text == (tmp_path / "again.svg").read_text()
    for label in (
        "route", "route without the wish", "alternative 2: 10.5 m", "footprint along the route",
        "drawn by the rider", "avoid if possible", "never enter", "turns on the spot",
        "start", "goal", "higher cost, or too close", "wish of the rider",
    ):  # fmt: skip
        assert f"<!-- {label} -->" in text


def test_masks_are_drawn_and_named_as_far_as_they_say_anything(plan, grid, tmp_path):
    def mask(kind, occupancy):
        data = np.zeros((30, 40), dtype=np.int8)
        data[10:20, 10:20] = occupancy
        small = OccupancyGrid(data=data, resolution=0.1, X_MG=np.array([6.0, 6.0, 0.3]))
        return CostmapFilter(type=kind, mask=small)

    def labels(*filters):
        file = tmp_path / "plan.svg"
        problem = dataclasses.replace(plan.problem, filters=filters)
        draw_plan(dataclasses.replace(plan, problem=problem), file)
        return re.findall("<!-- (keepout zone|slow: .*?) -->", file.read_text())

    assert labels(mask("keepout", 100)) == ["keepout zone"]
    assert labels(mask("speed_percent", 30)) == ["slow: 30 % of full speed"]
    assert labels(mask("speed_percent", 30), mask("speed_percent", 60)) == [
        "slow: 30 to 60 % of full speed"
    ]
    assert labels(mask("keepout", 50), mask("speed_percent", 0)) == []


def test_the_same_routes_give_the_same_bytes(grid, tmp_path):
    line = np.array([[4.0, 6.0], [9.0, 7.0]])
    panels = [RoutePanel(f"scene {i}", grid, line[1], {"a": line, "b": line + 1}) for i in range(6)]
    for name in ("1.png", "2.png"):
        draw_route_panels(panels, ("a", "b", "c"), tmp_path / name)
        draw_error_plot({"a": [line, line], "b": [line]}, ("a", "b"), tmp_path / f"e{name}")
    for name in ("", "e"):
        first, second = (tmp_path / f"{name}{i}.png" for i in (1, 2))
        assert first.read_bytes() == second.read_bytes()
        assert first.stat().st_size > 5000


def test_an_animation_shows_every_quarter_second(ride, tmp_path):
    file = tmp_path / "ride.gif"
    animate_ride(ride, file)
    with Image.open(file) as frames:
        assert frames.n_frames == 9  # 0, ¼, …, 1¾ and the last, at 2 s
        assert frames.size[0] == film.WIDTH


def test_the_colours_of_eta_darken_all_along():
    red, green, blue, _ = canvas.ETA(np.linspace(0.0, 1.0, 64)).T
    luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    assert (np.diff(luminance) < 0.0).all()


def test_lines_differ_by_more_than_colour(grid, route):
    _, axes = canvas.sheet((1.0, 2.0, 20.0, 14.0), "")
    canvas.draw_floor(axes, grid)
    canvas.draw_route(axes, route.points, route.without_wishes)
    patterns = {str(line._dash_pattern) for line in axes.lines}
    assert len(patterns) == len(axes.lines) == 2
    assert not [c for c in axes.collections if isinstance(c, LineCollection)]


def test_one_route_is_drawn_once(grid, route):
    _, axes = canvas.sheet((1.0, 2.0, 20.0, 14.0), "")
    canvas.draw_route(axes, route.points, route.points)
    assert len(axes.lines) == 1


def test_the_scale_bar_is_as_long_as_it_says(grid):
    _, axes = canvas.sheet((0.0, 0.0, 24.0, 10.0), "")
    canvas.draw_scale_bar(axes)
    assert axes.texts[0].get_text() == "5 m"  # at most a quarter of 24 m
    assert np.ptp(axes.lines[0].get_xdata()) == pytest.approx(5.0)


def test_a_turned_map_lies_where_its_origin_says(grid):
    figure, axes = canvas.sheet((-5.0, 0.0, 25.0, 22.0), "")
    canvas.draw_floor(axes, grid)
    figure.canvas.draw()
    image = np.asarray(figure.canvas.buffer_rgba())
    free = grid.centres([60, 150])  # of a free cell
    x, y = axes.transData.transform(free)
    assert (image[image.shape[0] - int(y), int(x), :3] == 255).all()
    x, y = axes.transData.transform(grid.centres([119, 100]))  # of a wall's
    assert image[image.shape[0] - int(y) - 1, int(x), :3].max() < 200


def test_what_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch):
    with pytest.raises(ConfigError, match=r"\.png"):
        canvas.check_picture(tmp_path / "x.docx")
    with pytest.raises(ConfigError, match=r"\.gif or \.mp4"):
        check_animation(tmp_path / "x.png")
    monkeypatch.setattr(film.shutil, "which", lambda _: None)
    with pytest.raises(ConfigError, match="ffmpeg"):
        check_animation(tmp_path / "x.mp4")


@pytest.mark.parametrize("window", [(2.0, 2.0, 5.0, 30.0), (2.0, 2.0, 40.0, 4.0)])
def test_the_whole_legend_is_on_the_sheet_and_beside_the_floor(window):
    figure, axes = canvas.sheet(window, "")
    for i in range(9):
        axes.plot([], [], label=f"what the line number {i} stands for")
    canvas.draw_legend(figure, axes)
    figure.canvas.draw()
    (legend,) = figure.legends
    sheet, taken, floor = figure.bbox, legend.get_window_extent(), axes.get_window_extent()
    assert sheet.x0 <= taken.x0
    assert taken.x1 <= sheet.x1
    assert sheet.y0 <= taken.y0
    assert taken.y1 <= floor.y0


@pytest.mark.parametrize("window", [(2.0, 2.0, 5.0, 30.0), (2.0, 2.0, 40.0, 4.0)])
def test_a_narrow_window_is_widened_about_its_middle_and_stays_to_scale(window):
    _, axes = canvas.sheet(window, "")
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    assert x0 <= window[0] + 1e-9
    assert x1 >= window[2] - 1e-9
    assert (x0 + x1, y0 + y1) == pytest.approx((window[0] + window[2], window[1] + window[3]))
    box = axes.get_window_extent()
    assert box.width / (x1 - x0) == pytest.approx(box.height / (y1 - y0))


def test_a_place_s_name_keeps_off_the_track():
    figure, axes = canvas.sheet((0.0, 0.0, 20.0, 12.0), "")
    track = np.stack([np.linspace(0.0, 20.0, 200), np.full(200, 6.0)], axis=-1)
    places = Places(
        places=(
            NamedPlace(name="Ward 3", point=[10.0, 6.0]),
            NamedPlace(name="Hall", point=[10.0, 9.0]),
        )
    )
    canvas.draw_places(axes, places, track)
    figure.canvas.draw()
    ward, hall = axes.texts
    level = axes.transData.transform((10.0, 6.0))[1]
    assert not ward.get_window_extent().y0 <= level <= ward.get_window_extent().y1
    assert hall.xyann == (0.0, 0.0)
