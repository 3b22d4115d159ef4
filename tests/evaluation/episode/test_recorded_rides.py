"""Recorded rides: contents of the file, replay, and damaged files."""

import itertools
import shutil
import signal
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

from cohelm.arrays import identical
from cohelm.errors import RecordingError, ScenarioError
from cohelm.evaluation import Episode, run
from cohelm.evaluation.episode.open_loop import CHANGEABLE, replay_ride, scenario_of
from cohelm.evaluation.episode.recorded import facts_of, run_recorded
from cohelm.messages import Mode
from cohelm.recordings import RecordedRide, RideRecorder, RideTick, open_recording
from cohelm.recordings.rides import ros_messages as ros_writing
from cohelm.recordings.rides.exact import pack, unpack
from cohelm.recordings.rides.recorder import FLUSH, delayed_interrupt
from cohelm.recordings.rides.ride import TICK_TOPIC, TOPICS
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import PARTS

SECONDS = 2.0
SHORT = (f"time_limit={SECONDS}", "rider=nudge", "prefer=[[7, 7]]")


class Kept:
    """What a ride was, tick by tick."""

    def __init__(self, settings, file=None, scenario="crossing"):
        self.ticks, self.truths, self.file = [], [], file
        scenario = load_scenario(scenario, settings)
        if file is None:
            self.ride = run(scenario, 3, self)
        else:
            self.ride = run_recorded(scenario, 3, file, self)

    def __call__(self, tick, truth):
        self.ticks.append(tick)
        self.truths.append(truth)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Two seconds among five people, seen by a scanner."""
    return Kept(SHORT, tmp_path_factory.mktemp("rides") / "ride.mcap")


@pytest.fixture(scope="module")
def said(kept):
    """Every message by its topic, read with rosbags: (time in ns, message)."""
    found = {}
    with AnyReader([kept.file]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found


@pytest.fixture
def copy(kept, tmp_path):
    """The recording, to be spoilt."""
    return Path(shutil.copy(kept.file, tmp_path / "copy.mcap"))


def rewritten(file, to, change):
    """A sound file with other ticks: ``change(tick)`` gives them, None leaves one out."""
    with file.open("rb") as stream, to.open("wb") as out:
        writer, channels = Writer(out), {}
        writer.start(profile="ros2")
        for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            data = message.data
            if channel.topic == TICK_TOPIC:
                octets = ros_writing.store(2).deserialize_cdr(data, schema.name).data
                tick = change(unpack(bytes(octets), RideTick))
                if tick is None:
                    continue
                data = ros_writing.serialised(ros_writing.octets(pack(tick)))
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            writer.add_message(
                channels[channel.topic], message.log_time, data, message.publish_time
            )
        writer.finish()
    return to


# what is in the file


def test_the_ride_is_the_same_with_and_without_a_recording(kept):
    without = Kept(SHORT)
    timings = frozenset({"durations"})
    assert len(without.ticks) == len(kept.ticks)
    assert identical(without.ride.command, kept.ride.command)
    for a, b in zip(without.ticks, kept.ticks, strict=True):
        assert identical(a.observation, b.observation)
        assert identical(a.decision, b.decision)
        assert identical(a.plan, b.plan, ignore=timings)


def test_what_is_read_back_is_what_the_navigator_was_given_and_decided(kept):
    ride = RecordedRide(kept.file)
    for read, tick in zip(ride, kept.ticks, strict=True):
        assert identical(read.observation, tick.observation)
        assert identical(read.request, tick.request)
        assert identical(read.decision, tick.decision)
    assert ride.warnings == []
    assert identical(ride.facts, facts_of(build_scenario(load_scenario("crossing", SHORT), 3)))


def test_every_topic_is_a_documented_one_of_a_type_whose_definition_is_embedded(kept):
    with kept.file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert schema.name == TOPICS[channel.topic].type
        assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
        assert schema.data
    seen = {channel.topic for channel in summary.channels.values()}
    # the chair has no 3-D sensor and no inertial unit
    assert TOPICS.keys() - seen == {"/points", "/imu"}
    assert summary.statistics.message_end_time == round(1e9 * kept.ticks[-1].observation.time)


def test_the_page_lists_every_topic_with_its_type_and_when_it_speaks():
    page = Path(__file__).parents[3] / "docs/recording.md"
    rows = [line.split(" | ") for line in page.read_text(encoding="utf-8").splitlines()]
    told = {row[0][3:-1]: tuple(row[1:3]) for row in rows if row[0].startswith("| `/")}
    assert told == {
        name: (f"`{topic.type.replace('/msg/', '/')}`", topic.when)
        for name, topic in TOPICS.items()
    }


def test_the_file_says_for_people_what_it_is(kept):
    with kept.file.open("rb") as stream:
        reader = make_reader(stream)
        about = {each.name: each.metadata for each in reader.iter_metadata()}
        attached = {each.name: each.data for each in reader.iter_attachments()}
    assert about["cohelm"]["scenario"] == "crossing"
    assert about["cohelm"]["seed"] == "3"
    assert "version numpy" in about["cohelm"]
    assert about["cohelm end"] == {"outcome": "timeout", "ticks": str(len(kept.ticks))}
    assert b'"crossing"' in attached["scenario.json"]


def test_numbers_of_every_tick_are_those_of_the_ride(kept, said):
    for topic in ("/odom", "/cmd_vel", "/tf", "/eta", "/rider"):
        assert len(said[topic]) == len(kept.ticks)
    for k, tick in enumerate(kept.ticks):
        x, y, yaw = tick.observation.pose
        (time, odom), (_, command) = said["/odom"][k], said["/cmd_vel"][k]
        assert time == round(1e9 * tick.observation.time)
        where, q = odom.pose.pose.position, odom.pose.pose.orientation
        assert (where.x, where.y) == (x, y)
        assert 2.0 * np.arctan2(q.z, q.w) == pytest.approx(yaw, abs=1e-12)
        v = odom.twist.twist
        assert (v.linear.x, v.linear.y, v.angular.z) == tuple(tick.observation.twist)
        v = command.twist
        assert (v.linear.x, v.linear.y, v.angular.z) == tuple(tick.decision.twist)
        assert said["/eta"][k][1].data == tick.authority.eta
        stick = said["/rider"][k][1].axes
        assert np.array_equal(stick, np.float32(tick.observation.rider.deflection))
        (moved,) = said["/tf"][k][1].transforms
        assert (moved.header.frame_id, moved.child_frame_id) == ("map", "base_footprint")
        assert (moved.transform.translation.x, moved.transform.translation.y) == (x, y)


def test_scans_are_the_ranges_in_single_precision(kept, said):
    scans = [scan for tick in kept.ticks for scan in tick.observation.scans]
    assert len(scans) == len(said["/scan"]) > 15
    for scan, (_, message) in zip(scans, said["/scan"], strict=True):
        assert np.array_equal(message.ranges, scan.ranges.astype(np.float32), equal_nan=True)
        assert message.angle_increment == pytest.approx(scan.angle_increment)
        last = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
        assert message.angle_max == pytest.approx(last)


def test_the_map_lies_where_it_is(kept, said):
    ((_, message),) = said["/map"]
    grid = kept.ride.grid
    assert (message.info.height, message.info.width) == grid.shape
    assert np.array_equal(message.data.reshape(grid.shape), grid.data)
    origin = message.info.origin.position
    assert (origin.x, origin.y) == tuple(grid.X_MG[:2])


def test_routes_plans_and_wishes_are_those_of_the_ride(kept, said):
    paths = [tick.path for tick in kept.ticks]
    new = [b for a, b in itertools.pairwise([None, *paths]) if b is not a]
    assert len(said["/plan"]) == len(new)
    for (_, message), path in zip(said["/plan"], new, strict=True):
        points = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
        assert np.array_equal(points, path.points)
    poses = said["/local_plan"][0][1].poses
    assert len(poses) == len(kept.ticks[0].plan.poses)
    assert len(said["/goal"]) == 1
    spots = [m.pose.position for m in said["/wishes"][0][1].markers if m.ns.startswith("attract")]
    assert [(p.x, p.y) for p in spots] == [(7.0, 7.0)]


def test_people_are_drawn_where_they_are_believed_and_where_they_truly_are(kept, said):
    at = {round(1e9 * tick.observation.time): k for k, tick in enumerate(kept.ticks)}
    most = 0
    for time, message in said["/people"]:
        people = kept.ticks[at[time]].people
        bodies = [m for m in message.markers if m.ns == "body"]
        assert [(m.pose.position.x, m.pose.position.y) for m in bodies] == [
            tuple(mean[:2]) for mean in people.mean
        ]
        assert [m.id for m in bodies] == people.id.tolist()
        most = max(most, len(bodies))
    assert most > 0
    for time, message in said["/truth/people"]:
        bodies = [m.pose.position for m in message.markers if m.ns == "body"]
        where = kept.truths[at[time]].crowd.position
        assert np.array_equal([(p.x, p.y) for p in bodies], where)
    assert len(said["/people"]) == pytest.approx(SECONDS / 0.2, abs=1.5)


def test_the_status_gives_the_reason_in_words(kept, said):
    at = {round(1e9 * tick.observation.time): tick for tick in kept.ticks}
    for time, message in said["/status"]:
        (status,) = message.status
        facts = {pair.key: pair.value for pair in status.values}
        reason = at[time].decision.reason
        assert facts["reason"] == ("" if reason is None else reason.value)
        assert status.message == ("no limitation" if reason is None else reason.sentence)
        assert facts["mode"] == "shared"


def test_a_recorded_ride_is_a_bag_like_any_other(kept):
    frames = list(open_recording(kept.file))
    swept = [tick.observation for tick in kept.ticks if tick.observation.scans]
    assert len(frames) == len(swept)
    for frame, seen in zip(frames, swept, strict=True):
        assert frame.posed
        assert frame.observation.pose[:2] == pytest.approx(seen.pose[:2], abs=1e-6)
        read, scan = frame.observation.scans[0], seen.scans[0]
        assert read.mount == pytest.approx(scan.mount, abs=1e-9)
        near = np.isfinite(read.ranges)
        assert read.ranges[near] == pytest.approx(scan.ranges[near], rel=1e-6)


@pytest.mark.slow
def test_clouds_of_several_sensors_have_topics_of_their_own(tmp_path):
    kept = Kept(("time_limit=0.5",), tmp_path / "lidar.mcap", "lidar")
    clouds = [cloud for tick in kept.ticks for cloud in tick.observation.clouds]
    read = []
    with AnyReader([kept.file]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic.startswith("/points/"):
                read.append(reader.deserialize(data, connection.msgtype))
    assert len(read) == len(clouds) > 0
    for message, cloud in zip(read, clouds, strict=True):
        points = message.data.view("<f4").reshape(-1, 3)
        assert np.array_equal(points, cloud.points, equal_nan=True)
    assert all(each.same for each in replay_ride(RecordedRide(kept.file)))


# riding it again


def test_a_replay_gives_the_same_commands_tick_by_tick(kept):
    again = list(replay_ride(RecordedRide(kept.file)))
    assert [each.number for each in again] == list(range(len(kept.ticks)))
    assert all(each.same and each.same_inputs for each in again)
    for each, tick in zip(again, kept.ticks, strict=True):  # and all else it made of it
        assert identical(each.tick, tick, ignore=frozenset({"durations"}))


@pytest.mark.parametrize("at", [0, 25])
def test_an_observation_that_was_tampered_with_is_noticed(kept, tmp_path, at):
    def nudged(tick):
        if tick.number != at:
            return tick
        seen = tick.observation
        return replace(tick, observation=replace(seen, pose=seen.pose + np.array([0.0, 0.02, 0.0])))

    ride = RecordedRide(rewritten(kept.file, tmp_path / "tampered.mcap", nudged))
    parted = next(each for each in replay_ride(ride) if not each.same_inputs)
    assert parted.number == at


def test_a_decision_that_was_tampered_with_is_noticed_at_its_last_bit(kept, tmp_path):
    def nudged(tick):
        if tick.number != 20:
            return tick
        twist = np.nextafter(tick.decision.twist, 9.0)
        return replace(tick, decision=replace(tick.decision, twist=twist))

    ride = RecordedRide(rewritten(kept.file, tmp_path / "tampered.mcap", nudged))
    assert [each.number for each in replay_ride(ride) if not each.same] == [20]


@pytest.mark.parametrize(
    "setting",
    ["local_planner.steps=20", "local_planner=dwa", "profile.preferred_speed=0.4", "mode=manual"],
)
def test_other_parameters_are_compared_on_the_same_observations(kept, setting):
    some = list(itertools.islice(replay_ride(RecordedRide(kept.file), [setting]), 30))
    assert not all(each.same for each in some)
    for each, tick in zip(some, kept.ticks, strict=False):
        assert identical(each.tick.observation, tick.observation)
        assert identical(each.recorded, tick.decision)
    if setting == "mode=manual":
        assert some[-1].tick.request.mode is Mode.MANUAL


@pytest.mark.parametrize(
    ("setting", "problem"),
    [
        ("people.count=3", "people: determined the recording"),
        ("goal=[1, 2]", "goal: determined the recording"),
        ("rider=ideal", "rider: determined the recording"),
        ("local_plannr=dwa", "did you mean 'local_planner'"),
        ("local_planner.stepps=20", "did you mean 'steps'"),
        ("gate.nothing=1", "gate.nothing"),
    ],
)
def test_settings_that_do_not_fit_are_refused(kept, setting, problem):
    with pytest.raises(ScenarioError, match=problem.replace("(", r"\(")):
        replay_ride(RecordedRide(kept.file), [setting])


def test_of_several_settings_that_do_not_fit_the_first_by_name_is_told(kept):
    facts = RecordedRide(kept.file).facts
    for settings in itertools.permutations(["start=[1,1]", "people.count=2", "goal=[2,2]"]):
        with pytest.raises(ScenarioError) as caught:
            scenario_of(facts, settings)
        assert caught.value.key == "goal"


def test_every_part_and_parameter_of_the_navigator_can_be_set():
    stage = build_scenario(load_scenario("empty"), 0)
    own = {*stage.navigator.__dataclass_fields__} & {*type(stage.scenario).model_fields}
    assert own - {"filters"} <= {*CHANGEABLE}  # it is recorded
    assert {*PARTS} - {"rider"} <= {*CHANGEABLE}


def test_the_set_up_is_that_of_the_ride(kept):
    facts = RecordedRide(kept.file).facts
    recorded, ours = scenario_of(facts), load_scenario("crossing", SHORT)
    for key in CHANGEABLE:
        assert getattr(recorded, key) == getattr(ours, key)


# what it costs


@pytest.mark.slow
def test_memory_grows_with_the_index_alone(kept, tmp_path):
    """A chunk a second, each with less than 6 kB of index: 20 MB an hour."""
    first, truth = kept.ticks[0], kept.truths[0]

    def at(time):
        return replace(first, observation=replace(first.observation, time=time))

    facts = RecordedRide(kept.file).facts
    tracemalloc.start()
    try:
        with RideRecorder(tmp_path / "long.mcap", facts) as recorder:
            for k in range(100):
                recorder(at(1.1 * k), truth)
            before, _ = tracemalloc.get_traced_memory()
            for k in range(100, 500):
                recorder(at(1.1 * k), truth)
            after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 400 * 6_000


# damage


@pytest.mark.parametrize("back", [1, 2])
def test_of_a_file_that_is_cut_off_the_beginning_is_replayed(copy, kept, back):
    with kept.file.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[-back]
    copy.write_bytes(copy.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length // 2])
    ride = RecordedRide(copy)
    read = list(replay_ride(ride))
    assert all(each.same for each in read)
    began = round(20 * 1e-9 * chunk.message_start_time)
    # the last chunk may hold no more than what the last tick draws
    assert max(began - 1, 1) <= len(read) <= len(kept.ticks) - (back > 1)
    (warning,) = ride.warnings
    assert "cut off" in warning
    assert f"read until {read[-1].time:.2f} s" in warning


def test_a_recorder_that_is_killed_loses_a_second_at_most(tmp_path):
    stage = build_scenario(load_scenario("empty", ["time_limit=2.9"]), 0)
    file, left = tmp_path / "ride.mcap", tmp_path / "left.mcap"

    def killed(tick, truth):
        recorder(tick, truth)
        if round(tick.observation.time, 3) == 2.8:
            shutil.copy(file, left)  # what is on the disk now is what a killed process leaves

    with RideRecorder(file, facts_of(stage)) as recorder:
        Episode(stage).run(killed)
    read = list(replay_ride(RecordedRide(left)))
    assert all(each.same for each in read)
    assert read[-1].time >= 2.8 - FLUSH


def test_an_interrupt_leaves_a_whole_file(tmp_path):
    file = tmp_path / "ride.mcap"
    seen = []

    def interrupted(tick, truth):
        seen.append(tick)
        if len(seen) == 33:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_recorded(load_scenario("empty"), 0, file, interrupted)
    ride = RecordedRide(file)
    assert len(list(ride)) == 33
    assert ride.warnings == []
    with file.open("rb") as stream:
        assert make_reader(stream).get_summary().statistics.message_count > 33


@pytest.fixture
def interrupts():
    """Python's own handler, which is not there where a shell began the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_in_the_midst_of_writing_waits_for_its_end(interrupts):
    done = []

    def work():
        with delayed_interrupt():
            signal.raise_signal(signal.SIGINT)
            done.append("all of it")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_damaged_chunk_ends_the_ride_there_in_words(copy, kept):
    data = bytearray(copy.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 200] = bytes(200)
    copy.write_bytes(data)
    ride = RecordedRide(copy)
    read = list(ride)
    assert 0 < len(read) < len(kept.ticks)
    assert ride.warnings
    for tick, was in zip(read, kept.ticks, strict=False):
        assert identical(tick.observation, was.observation)


def test_ticks_that_are_missing_are_told(kept, tmp_path):
    gap = rewritten(
        kept.file, tmp_path / "gap.mcap", lambda tick: None if 10 <= tick.number < 13 else tick
    )
    ride = RecordedRide(gap)
    assert len(list(ride)) == 10
    assert "ticks 10 to 12 are missing" in ride.warnings[0]


def test_a_file_without_ticks_is_refused(kept, tmp_path):
    ride = RecordedRide(rewritten(kept.file, tmp_path / "none.mcap", lambda tick: None))
    with pytest.raises(RecordingError, match="holds no tick"):
        list(ride)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "is empty"),
        (b"#ROSBAG V2.0\n", "is not an MCAP file"),
        (b"\x89MCAP0\r\n", "cut off"),
        (b"\x89MCAP0\r\n" + bytes(50), "cut off"),
    ],
)
def test_a_file_that_is_no_ride_is_refused(tmp_path, content, problem):
    file = tmp_path / "other.mcap"
    file.write_bytes(content)
    with pytest.raises(RecordingError, match=problem) as caught:
        RecordedRide(file)
    assert str(file) in str(caught.value)


def test_a_bag_of_somebody_else_is_refused_with_what_it_holds(tmp_path):
    file = tmp_path / "other.mcap"
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        message = ros_writing.number(1.0)
        schema = writer.register_schema(message.__msgtype__, "ros2msg", b"float64 data")
        channel = writer.register_channel("/battery", "cdr", schema)
        writer.add_message(channel, 1, ros_writing.serialised(message), 1)
        writer.finish()
    with pytest.raises(RecordingError, match=r"holds no ride of cohelm.*/battery"):
        RecordedRide(file)


def test_a_recording_of_another_format_is_refused(tmp_path):
    stage = build_scenario(load_scenario("empty"), 0)
    file = tmp_path / "ride.mcap"
    with RideRecorder(file, replace(facts_of(stage), format=99)):
        pass
    with pytest.raises(RecordingError, match="is of format 99; this version reads format 2"):
        RecordedRide(file)


def test_neither_a_folder_nor_nothing_is_a_ride(tmp_path):
    for file in (tmp_path, tmp_path / "nothing.mcap"):
        with pytest.raises(RecordingError):
            RecordedRide(file)


def test_a_recording_is_never_written_over(kept):
    before = kept.file.read_bytes()
    with pytest.raises(RecordingError, match="exists already"):
        RideRecorder(kept.file, RecordedRide(kept.file).facts)
    assert kept.file.read_bytes() == before


def test_a_recording_that_cannot_begin_leaves_no_file_open(kept, tmp_path, monkeypatch):
    streams, opened = [], Path.open

    def watched(*args, **options):
        streams.append(opened(*args, **options))
        return streams[-1]

    facts = RecordedRide(kept.file).facts
    monkeypatch.setattr(Path, "open", watched)
    spoilt = replace(facts, scenario={"start": object()})
    with pytest.raises(TypeError), RideRecorder(tmp_path / "ride.mcap", spoilt):
        pass
    assert [each.closed for each in streams] == [True]


def test_a_disk_that_takes_no_more_ends_the_ride_in_words_and_keeps_what_it_took(tmp_path):
    resource = pytest.importorskip("resource")
    file = tmp_path / "ride.mcap"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, before[1]))
    try:
        with pytest.raises(RecordingError, match=r"cannot be written \(File too large\)"):
            run_recorded(load_scenario("empty"), 0, file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    ride = RecordedRide(file)
    assert len(list(ride)) > 0
    assert ride.warnings
