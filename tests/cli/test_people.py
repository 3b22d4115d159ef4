"""``cohelm people``: recordings made here, told as JSON, tables, pictures, films and scores."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

BEAMS, STEP = 361, 0.1
STORE = get_typestore(Stores.ROS1_NOETIC)
TYPES = STORE.types


def header(k):
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=100 + k // 10, nanosec=(k % 10) * 10**8)
    return TYPES["std_msgs/msg/Header"](seq=k, stamp=stamp, frame_id="laser")


def ranges(time):
    """Of a room 12 m wide, and of somebody whose two legs walk past 2 m ahead, to the left."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, BEAMS)
    out = 6.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    for leg in (-0.12, 0.12):
        centre = np.array([2.0 + leg, -1.5 + 0.9 * time])
        along = np.cos(angles) * centre[0] + np.sin(angles) * centre[1]
        off = np.abs(np.cos(angles) * centre[1] - np.sin(angles) * centre[0])
        met = (off < 0.07) & (along > 0)
        near = along - np.sqrt(np.maximum(0.07**2 - off**2, 0.0))
        out = np.where(met, np.minimum(out, near), out)
    return out


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Three seconds of somebody walking past."""
    return write_bag(tmp_path_factory.mktemp("recordings") / "walk.bag", range(30))


def write_bag(file, steps):
    """A bag with scans at these tenths of a second, in this order."""
    with Writer(file) as writer:
        topic = writer.add_connection("/scan", "sensor_msgs/msg/LaserScan", typestore=STORE)
        for n, k in enumerate(steps):
            scan = TYPES["sensor_msgs/msg/LaserScan"](
                header=header(k), angle_min=-np.pi / 2, angle_max=np.pi / 2,
                angle_increment=np.pi / (BEAMS - 1), time_increment=0.0, scan_time=STEP,
                range_min=0.0, range_max=20.0,
                ranges=ranges(k * STEP).astype(np.float32), intensities=np.empty(0, np.float32),
            )  # fmt: skip
            writer.write(topic, 10**11 + n * 10**8, STORE.serialize_ros1(scan, topic.msgtype))
    return file


@pytest.fixture
def sweep(tmp_path):
    """A cloud of a few points on the floor."""
    file = tmp_path / "floor.pcd"
    points = "\n".join(f"{x} {y} -1.7" for x in range(1, 5) for y in range(-2, 3))
    file.write_text(
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 20\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 20\nDATA ascii\n{points}\n"
    )
    return file


def test_json_is_one_object_a_frame_and_nothing_else(cohelm, bag):
    code, out, _ = cohelm("people", bag, "--json")
    assert code == 0
    frames = [json.loads(line) for line in out.splitlines()]
    assert len(frames) == 30
    assert all(set(frame) == {"t", "sensing", "pose", "people"} for frame in frames)
    assert frames[0]["t"] == pytest.approx(100.0)
    assert frames[-1]["t"] == pytest.approx(102.9)
    assert {frame["sensing"] for frame in frames} == {"ok"}
    person = {"id", "x", "y", "vx", "vy", "confidence", "group"}
    assert all(set(each) == person for frame in frames for each in frame["people"])


def test_the_walker_is_told(cohelm, bag):
    frames = [json.loads(line) for line in cohelm("people", bag, "--json")[1].splitlines()]
    for frame in frames[15:]:
        truth = 2.0, -1.5 + 0.9 * (frame["t"] - 100.0)
        apart = [np.hypot(p["x"] - truth[0], p["y"] - truth[1]) for p in frame["people"]]
        assert min(apart) < 0.3
    nearest = min(frames[-1]["people"], key=lambda p: abs(p["x"] - 2.0))
    assert nearest["vy"] == pytest.approx(0.9, abs=0.3)


def test_twice_the_same(cohelm, bag):
    assert cohelm("people", bag, "--json")[1] == cohelm("people", bag, "--json")[1]


def test_the_table_says_what_there_was(cohelm, bag, tmp_path):
    plot, film = tmp_path / "who.png", tmp_path / "who.gif"
    code, out, _ = cohelm("people", bag, "--plot", plot, "--animate", film, "--at", 2)
    assert code == 0
    for word in ("walk.bag", "frames", "2.9 s", "ok 30", "people tracked longest", "written"):
        assert word in out
    with Image.open(plot) as image, Image.open(film) as moving:
        assert image.size[0] > 500
        assert moving.n_frames == 12  # 2.9 s, one every 0.25 s


def test_only_a_part_of_it(cohelm, bag):
    out = cohelm("people", bag, "--json", "--start", 1, "--seconds", 0.5)[1]
    times = [json.loads(line)["t"] for line in out.splitlines()]
    assert times == pytest.approx([101.0, 101.1, 101.2, 101.3, 101.4, 101.5])


def test_walks_go_on_before_what_is_shown(cohelm, bag, tmp_path):
    truth = tmp_path / "obsmat.txt"  # the walker of the bag, from its first frame on
    rows = [(10 * k, 1, 2.0, 0.0, -1.5 + 0.9 * 0.4 * k, 0.0, 0.0, 0.9) for k in range(9)]
    truth.write_text("\n".join(" ".join(map(str, row)) for row in rows))
    for start in (0, 1):
        out = cohelm("people", bag, "--json", "--start", start, "--truth", truth)[1]
        scores = json.loads(out.splitlines()[-1])["scores"]
        assert scores["found"] > 0.5  # not at first sight; a second late he would be 0.9 m away
        assert scores["position_error"] < 0.2


def test_instants_count_from_the_first_frame_of_the_recording(cohelm, bag, tmp_path, monkeypatch):
    from cohelm.plotting import canvas

    titles = []
    drawn = canvas.sheet
    monkeypatch.setattr(
        canvas, "sheet", lambda window, title: titles.append(title) or drawn(window, title)
    )
    options = "--plot", tmp_path / "who.png", "--at", 2, "--start", 1
    code, out, err = cohelm("people", bag, *options)
    assert code == 0
    assert [title.rpartition(" at ")[2] for title in titles] == ["2.0 s"]
    assert err.count("--at") == 0
    froms = [line.split() for line in out.partition("people tracked longest")[2].splitlines()]
    starts = [float(cells[3]) for cells in froms if len(cells) > 8 and cells[1].isdigit()]
    assert starts
    assert min(starts) >= 1.0
    _, _, err = cohelm("people", bag, "--plot", tmp_path / "who.png", "--at", 9)
    assert "--at 9: the nearest reading is at 2.9 s" in err


def test_a_hole_is_told_and_nothing_is_seen_in_it(cohelm, tmp_path):
    file = write_bag(tmp_path / "hole.bag", [*range(10), *range(50, 60)])
    assert "0.9 to 5.0 s" in cohelm("people", file)[1]
    code, _, err = cohelm("people", file, "--start", 2, "--seconds", 1)
    assert code == 2
    assert "no reading from 2 to 3 s" in err


def test_labels_of_something_else_are_worth_a_warning(cohelm, bag, tmp_path):
    truth = tmp_path / "truth.jsonl"
    truth.write_text(json.dumps({"t": 102.0, "people": [{"id": 1, "x": -5.0, "y": 5.0}]}))
    code, _, err = cohelm("people", bag, "--truth", truth)
    assert code == 0
    assert "no person was tracked near a label" in err


@pytest.mark.parametrize(
    ("steps", "says"),
    [([0] * 8, "clock_frozen"), ([*range(100, 110), *range(8)], "clock_backwards")],
    ids=["stands", "back"],
)
def test_a_clock_that_stands_or_runs_back_is_told(cohelm, tmp_path, steps, says):
    code, out, _ = cohelm("people", write_bag(tmp_path / "odd.bag", steps), "--json")
    assert code == 0
    frames = [json.loads(line) for line in out.splitlines()]
    assert len(frames) == len(steps)
    assert says in {frame["sensing"] for frame in frames}


def test_scores_are_the_last_object(cohelm, bag, tmp_path):
    truth = tmp_path / "truth.jsonl"
    lines = [
        {"t": 100.0 + k / 10, "people": [{"id": 1, "x": 2.0, "y": -1.5 + 0.09 * k}]}
        for k in range(15, 30)
    ]
    truth.write_text("".join(json.dumps(line) + "\n" for line in lines))
    code, out, _ = cohelm("people", bag, "--json", "--truth", truth)
    assert code == 0
    *frames, last = [json.loads(line) for line in out.splitlines()]
    assert len(frames) == 30
    scores = last["scores"]
    assert scores["instants"] == scores["labels"] == 15
    assert scores["found"] == 1.0
    assert scores["position_error"] < 0.3
    assert scores["id_changes"] == 0
    table = cohelm("people", bag, "--truth", truth)[1]
    assert "IDF1" in table
    assert "found within 0.5 m" in table


def test_what_was_told_is_its_own_truth(cohelm, bag, tmp_path):
    truth = tmp_path / "told.jsonl"
    truth.write_text(cohelm("people", bag, "--json")[1])
    scores = json.loads(cohelm("people", bag, "--json", "--truth", truth)[1].splitlines()[-1])
    assert scores["scores"]["mota"] == scores["scores"]["idf1"] == 1.0
    assert scores["scores"]["position_error"] < 1e-3


def test_a_still_picture_is_one_frame(cohelm, sweep, tmp_path):
    code, out, _ = cohelm("people", sweep, "--json", "--plot", tmp_path / "floor.png")
    assert code == 0
    (frame,) = [json.loads(line) for line in out.splitlines()]
    assert frame["people"] == []
    assert (tmp_path / "floor.png").stat().st_size > 5000


def test_a_map_explains_what_stands_there(cohelm, bag, room):
    assert cohelm("people", bag, "--json", "--map", room)[0] == 0


def test_a_bag_cut_short_is_read_as_far_as_it_goes(cohelm, bag, tmp_path):
    short = tmp_path / "short.bag"
    short.write_bytes(bag.read_bytes()[: bag.stat().st_size * 2 // 3])
    code, out, err = cohelm("people", short, "--json")
    assert code in {0, 2}
    if code == 0:
        assert out.count("\n") > 5
        assert "warning: " in err
    assert str(short) in err


def test_a_setting_changes_what_is_told(cohelm, bag):
    out = cohelm("people", bag, "--json", "--set", "tracker.use=given")[1]
    assert all(json.loads(line)["people"] == [] for line in out.splitlines())


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--plot", "who.bmp"), "--plot"),
        (("--animate", "who.png"), "--animate"),
        (("--at", "1"), "--at"),
        (("--set", "trackr.gate=1"), "did you mean 'tracker'"),
        (("--set", "tracker.no_such_key=1"), "tracker.no_such_key"),
        (("--map", "no.yaml"), "no.yaml"),
        (("--truth", "no.jsonl"), "no.jsonl"),
        (("--start", "1000"), "--start"),
        (("--topic", "/nothing"), "/nothing"),
        (("--start", "-1"), "start"),
    ],
)
def test_what_cannot_be_done_is_one_line(cohelm, bag, options, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = cohelm("people", bag, *options)
    assert code == 2
    assert out == ""
    assert says in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"", b"#ROSBAG V2.0\n", b"nonsense" * 100])
def test_a_file_that_is_no_recording_is_named(cohelm, tmp_path, content):
    file = tmp_path / "broken.bag"
    file.write_bytes(content)
    code, out, err = cohelm("people", file, "--json")
    assert code == 2
    assert out == ""
    assert str(file) in err
    assert err.count("\n") == 1


def test_labels_that_fit_no_instant_are_told(cohelm, bag, tmp_path):
    truth = tmp_path / "truth.jsonl"
    lines = [{"t": float(t), "people": []} for t in (5, 6)]
    truth.write_text("\n".join(json.dumps(line) for line in lines))
    code, _, err = cohelm("people", bag, "--json", "--truth", truth)
    assert code == 0
    assert "no labels at the times" in err


@pytest.mark.slow
def test_nobody_reads_any_more(bag):
    """As ``| head -1`` does."""
    command = [sys.executable, "-c", "from cohelm.cli import main; main()", "people", str(bag)]
    reader, writer = os.pipe()
    with subprocess.Popen([*command, "--json"], stdout=writer, stderr=subprocess.PIPE) as process:
        os.close(writer)
        os.read(reader, 10)
        os.close(reader)
        _, err = process.communicate(timeout=120)
    assert b"Traceback" not in err
    assert process.returncode in {0, 141}, err  # 0 where all had been written by then
