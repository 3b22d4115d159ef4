"""Riders: stored whole, private, chosen with their preset, and gone with one action."""

import io
import itertools
import json
import stat
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from cohelm.errors import StoreError
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.limits import ActiveSettings, ChairMoves
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Limits, RiderSettings
from cohelm.live.ride_tracker import RideTracker
from cohelm.live.rider_choice import RiderChoice
from cohelm.live.sessions.database import FILE, Database
from cohelm.live.sessions.progress import MIN_SESSIONS, SIGNIFICANCE, direction, rider_progress
from cohelm.live.sessions.records import (
    LimitsAt,
    RideStop,
    RideSummary,
    SessionInfo,
    SessionSummary,
)
from cohelm.live.sessions.report import breaches, session_html
from cohelm.live.sessions.riders import (
    RiderDraft,
    RiderExists,
    RiderGoal,
    RiderPreset,
    RiderStore,
)
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Mode
from cohelm.robots import load_robot
from cohelm.scenarios import load_scenario

from .disk import full_disk

ROBOT = load_robot("quantum_q6_edge")
WIDE = Limits(max_speed=1.0, max_acceleration=0.8, min_distance=0.3)
CALM = Limits(max_speed=0.5, max_acceleration=0.4, min_distance=0.8)
PRESET = RiderPreset(
    limits=CALM, settings=RiderSettings(dwell=2.0, switches=1), mode=Mode.STOP_ONLY, pace="slow"
)
NAME = "Ana Példa"


def draft(name=NAME, **changes):
    return RiderDraft(name=name, preset=PRESET, **changes)


@pytest.fixture
def riders(tmp_path):
    return RiderStore(Database(tmp_path))


def session(id_, rider, *rides):
    facts = SessionInfo(
        id=id_, started=f"{id_[:4]}-{id_[4:6]}-{id_[6:8]}T10:00:00+00:00", scene="hospital",
        robot="chair", rider=rider,
    )  # fmt: skip
    return SessionSummary(session=facts, rides=tuple(rides))


def ride(id_, **changes):
    fields = {
        "id": id_,
        "session": id_.rpartition("-r")[0],
        "started": "2026-01-31T14:25:30+00:00",
        "seed": 3,
        "destination": "Ward 4",
        "outcome": "arrived",
        "duration": 60.0,
        "length": 25.0,
        "modes": {"shared": 60.0},
        "limits": (LimitsAt(time=0.0, limits=CALM),),
    }
    return RideSummary(**{**fields, **changes})


def stored(store, summary):
    """Enter a session in the index."""
    info, rider = summary.session.model_dump_json(), summary.session.rider
    for each in summary.rides:
        store.database.write(
            "INSERT INTO ride VALUES (?, ?, ?, 'unmeasured', ?, ?, NULL, NULL)",
            each.id, each.session, rider, info, each.model_dump_json(),
        )  # fmt: skip
        store.log_file(each.id).parent.mkdir(exist_ok=True)
        store.log_file(each.id).write_bytes(b"log")


def test_a_rider_comes_back_as_given_and_only_the_owner_reads_the_file(riders, tmp_path):
    goals = (RiderGoal(kind="unaided", target=10), RiderGoal(kind="words", text="doors"))
    made = riders.create(draft(notes="left hand\nglasses", goals=goals))
    again = RiderStore(Database(tmp_path)).get(made.id)
    assert again == made
    assert (again.name, again.notes, again.goals) == (NAME, "left hand\nglasses", goals)
    assert again.preset == PRESET
    assert stat.S_IMODE((tmp_path / FILE).stat().st_mode) == 0o600


@pytest.mark.parametrize("same", [NAME, "ana példa", "  ANA   PÉLDA ", "Ana Pe\u0301lda"])
def test_nobody_gets_the_name_of_another_rider(riders, same):
    first, other = riders.create(draft()), riders.create(draft("Bo"))
    with pytest.raises(RiderExists):
        riders.create(draft(same))
    with pytest.raises(RiderExists):
        riders.change(other.id, draft(same))
    assert riders.change(first.id, draft(same)).id == first.id


@pytest.mark.parametrize(
    "given",
    [
        {"name": ""}, {"name": "  \n"}, {"name": "\x00\x07"}, {"name": "\u200b"},
        {"name": "x" * 81},
        {"name": "x" * 10_000}, {"notes": "x" * 2001}, {"name": "a", "goals": [{"kind": "words"}]},
        {"goals": [{"kind": "arrivals", "target": 0}]}, {"goals": [{"kind": "arrivals"}] * 9},
    ],
)  # fmt: skip
def test_what_is_no_rider_is_refused(given):
    with pytest.raises(ValidationError):
        RiderDraft.model_validate({"name": "a", "preset": PRESET, **given})


def test_a_damaged_record_is_told_not_replaced_and_leaves_the_others(riders, tmp_path):
    lost, kept = riders.create(draft()), riders.create(draft("Bo"))
    Database(tmp_path).write("UPDATE rider SET record = '{\"na' WHERE id = ?", lost.id)
    found, damaged = riders.list()
    assert [each.id for each in found] == [kept.id]
    assert [each.id for each in damaged] == [lost.id]
    assert lost.id in damaged[0].problem
    with pytest.raises(StoreError, match="cannot be read"):
        riders.change(lost.id, draft())
    assert riders.check(lost.id) == '{"na'
    riders.remove(lost.id)
    assert riders.list() == ((kept,), ())


def test_a_full_disk_keeps_what_was_stored_before(riders):
    made = riders.create(draft())
    with full_disk():
        with pytest.raises(StoreError, match="cannot be written"):
            riders.change(made.id, draft("Bo"))
        with pytest.raises(StoreError, match="cannot be written"):
            riders.create(draft("Cy"))
    assert riders.list() == ((made,), ())


@pytest.mark.parametrize("id_", ["", "rider-xyz", "../settings", "rider-0000000", "rider-11111111"])
def test_nothing_but_a_rider_is_found(riders, id_):
    for ask in (riders.get, riders.remove, riders.check):
        with pytest.raises(StoreError, match="no such rider"):
            ask(id_)


class Desk:
    """A choice of riders with a control loop that runs calls at once."""

    def __init__(self, folder):
        self.store = SessionStore(folder)
        self.settings = ActiveSettings(folder, ROBOT, limits=WIDE)
        self.driver, self.moves, self.ended, self.log = DriverState(), False, [], []
        desk = self

        class Cycle:
            @property
            def moves(self):
                return desk.moves

        self.riders = RiderChoice(
            self.store, self.settings, self.driver, SimpleNamespace(end=self.ended.append),
            SimpleNamespace(
                cycle=Cycle(),
                call=lambda call: call(),
                announce=lambda code, _: self.log.append(("notice", {"code": code})),
            ),
            log_event=lambda who, what, **said: self.log.append((what, said)),
            announce=lambda: self.log.append(("told", {})),
            modes=tuple(Mode),
        )  # fmt: skip


@pytest.fixture
def desk(tmp_path):
    desk = Desk(tmp_path)
    yield desk
    desk.store.close()


def test_the_preset_of_who_is_chosen_is_in_force_and_stays_with_the_program_s_end(desk, tmp_path):
    made = desk.riders.create(draft(), "t")
    listed = desk.riders.choose(made.id, "t")
    assert listed.current == made.id
    assert desk.settings.limits == CALM
    assert desk.settings.rider == PRESET.settings
    assert (desk.driver.mission.mode, desk.driver.mission.pace) == (Mode.STOP_ONLY, "slow")
    assert desk.ended == ["cancelled"]
    again = ActiveSettings(tmp_path, ROBOT)
    assert (again.person, again.limits, again.rider) == (made.id, CALM, PRESET.settings)
    desk.riders.choose(made.id, "t")
    assert desk.ended == ["cancelled"]  # the same rider goes on
    notices = [said["code"] for what, said in desk.log if what == "notice"]
    assert notices == ["rider_chosen"]  # the pages forget the trip that was being chosen, once


def test_who_rode_last_rides_on_and_a_rider_that_is_gone_does_not(desk, tmp_path):
    made = desk.riders.create(draft(), "t")
    desk.riders.choose(made.id, "t")
    desk.store.close()
    again = Desk(tmp_path)
    again.riders.restore()
    assert again.riders.list().current == made.id
    assert (again.driver.mission.mode, again.driver.mission.pace) == (Mode.STOP_ONLY, "slow")
    assert again.ended == []
    again.store.riders.remove(made.id)
    again.riders.restore()
    assert again.riders.list().current == ""
    again.store.close()


def test_another_rider_begins_another_session(tmp_path):
    settings = ActiveSettings(tmp_path, ROBOT)
    store = SessionStore(tmp_path)
    rides = RideTracker(store, settings, lambda *_: None)
    scenario = load_scenario("empty")
    rides.enter(SimpleNamespace(seed=0, scenario=scenario, robot=ROBOT))
    moving = SimpleNamespace(twist=np.array([0.3, 0.0, 0.0]))
    begun = []
    for person in ("", "", "rider-00000001"):
        settings.choose(person, None, None, lambda: True)
        rides.step(moving, Mission(), elapsed=0.05, length=0.0, device="keys")
        begun.append(rides.ride)
        rides.end("cancelled")
    store.close()
    assert begun[1] == f"{begun[0][:-1]}2"  # one session for a drive
    assert begun[2].rpartition("-r")[0] != begun[0].rpartition("-r")[0]
    assert begun[2].endswith("-r1")


def test_nobody_is_changed_while_the_chair_moves(desk):
    made = desk.riders.create(draft(), "t")
    desk.moves = True
    with pytest.raises(ChairMoves):
        desk.riders.choose(made.id, "t")
    assert (desk.settings.person, desk.settings.limits) == ("", WIDE)
    desk.moves = False
    desk.riders.choose(made.id, "t")
    desk.moves = True
    with pytest.raises(ChairMoves):
        desk.riders.delete(made.id, "t")
    assert desk.riders.list().riders == (made,)


def test_on_a_full_disk_the_rider_and_what_is_tighter_count_at_once(desk, tmp_path):
    made = desk.riders.create(draft(), "t")
    with full_disk():
        desk.riders.choose(made.id, "t")
        assert (desk.settings.person, desk.settings.limits) == (made.id, CALM)
        assert "cannot be written" in desk.settings.error
    desk.settings.retry()
    assert desk.settings.error == ""
    assert ActiveSettings(tmp_path, ROBOT).person == made.id


def test_on_a_full_disk_nothing_becomes_looser(desk):
    desk.settings.set_limits(CALM, lambda: True)
    made = desk.riders.create(draft().model_copy(update={"preset": RiderPreset(limits=WIDE)}), "t")
    with full_disk():
        desk.riders.choose(made.id, "t")
    assert desk.settings.limits == CALM


def test_the_log_knows_no_name(desk):
    made = desk.riders.create(draft(), "t")
    desk.riders.choose(made.id, "t")
    desk.riders.change(made.id, draft(notes="secret"), "t")
    desk.riders.export(made.id, "t")
    desk.riders.delete(made.id, "t")
    said = json.dumps(desk.log, ensure_ascii=False)
    assert NAME not in said
    assert "secret" not in said
    events = [what for what, _ in desk.log]
    assert [each for each in events if each.startswith("rider_")] == [
        "rider_created", "rider_chosen", "rider_changed", "rider_exported", "rider_chosen",
        "rider_deleted",
    ]  # fmt: skip


def test_a_deleted_rider_takes_their_sessions_and_nobody_else_s(desk, tmp_path):
    one, other = desk.riders.create(draft(), "t"), desk.riders.create(draft("Bo"), "t")
    for number, rider in enumerate((one.id, other.id, "", one.id)):
        id_ = f"2026010{number + 1}-101010"
        stored(desk.store, session(id_, rider, ride(f"{id_}-r1")))
    older = tmp_path / "20260109-101010"
    older.mkdir()
    desk.riders.choose(one.id, "t")
    assert desk.settings.limits == CALM
    deleted = desk.riders.delete(one.id, "t")
    assert desk.settings.limits == desk.settings.defaults.limits != CALM
    assert desk.settings.rider == desk.settings.defaults.rider
    assert (deleted.sessions, deleted.unreadable) == (2, 1)
    assert desk.settings.person == ""
    left = {file.stem for file in tmp_path.rglob("*.mcap")}
    assert left == {"20260102-101010-r1", "20260103-101010-r1"}
    assert older.exists()
    assert [each.id for each in desk.riders.list().riders] == [other.id]
    assert not any(NAME.encode() in f.read_bytes() for f in tmp_path.rglob("*") if f.is_file())


def test_the_export_has_all_of_one_rider_and_nothing_of_others(desk, tmp_path):
    one, other = desk.riders.create(draft(), "t"), desk.riders.create(draft("Bo"), "t")
    mine, theirs = "20260101-101010", "20260102-101010"
    stored(desk.store, session(mine, one.id, ride(f"{mine}-r1")))
    stored(desk.store, session(theirs, other.id, ride(f"{theirs}-r1")))
    with zipfile.ZipFile(io.BytesIO(desk.riders.export(one.id, "t"))) as archive:
        assert {*archive.namelist()} == {
            "rider.json", f"{mine}.html", f"{mine}.csv", f"{mine}.json", f"{mine}-r1.mcap",
        }  # fmt: skip
        assert NAME in archive.read(f"{mine}.html").decode()
        assert NAME not in archive.read(f"{mine}.csv").decode()
        assert one.id in archive.read(f"{mine}.csv").decode()


def test_six_sessions_are_the_fewest_that_can_show_a_direction():
    """The two extreme ones of n! orders have 2/n!, which first is at most 1 % for six."""
    orders = [len([*itertools.permutations(range(n))]) for n in (MIN_SESSIONS - 1, MIN_SESSIONS)]
    assert 2 / orders[0] > SIGNIFICANCE >= 2 / orders[1]
    assert direction(range(MIN_SESSIONS - 1)) == "few"
    assert direction([None, *range(MIN_SESSIONS - 1), None]) == "few"
    assert direction(range(MIN_SESSIONS)) == "rising"
    assert direction(range(MIN_SESSIONS, 0, -1)) == "falling"
    assert direction([1.0] * 12) == "unclear"
    assert direction([3, 1, 4, 1, 5, 9, 2, 6]) == "unclear"


@pytest.mark.parametrize("values", [[0, 0, 1, 2, 3, 4], [0, 0, 0, 1, 1, 2], [0, 1, 2, 3, 4, 5]])
def test_of_all_orders_at_most_one_in_a_hundred_has_a_direction(values):
    """The share of false directions if the order says nothing, with ties and without."""
    orders = [direction(order) for order in itertools.permutations(values)]
    assert sum(each != "unclear" for each in orders) <= SIGNIFICANCE * len(orders)


def test_quantities_of_a_session_are_those_of_its_rides():
    stop = RideStop(time=1.0, duration=2.0, code="a", text="b")
    first = ride(
        "20260101-101010-r1", stops=(stop, stop), modes={"manual": 58.0, "shared": 2.0},
        measures={"rider_effort": 10.0, "rider_reversals": 6.0, "min_distance": 0.5},
    )  # fmt: skip
    second = ride(
        "20260101-101010-r2", outcome="cancelled", length=75.0, duration=120.0,
        measures={"rider_effort": 5.0, "rider_reversals": 3.0, "min_distance": 0.9},
    )  # fmt: skip
    third = ride("20260101-101010-r3", destination="", outcome="cancelled", length=0.0)
    late = session("20260102-101010", "a", third)
    goals = (
        RiderGoal(kind="unaided", target=1),
        RiderGoal(kind="arrivals", target=2),
        RiderGoal(kind="words", text="doors", done=True),
    )
    found = rider_progress([late, session("20260101-101010", "a", first, second)], goals)
    point, last = found.sessions
    assert (point.rides, point.trips, point.arrivals, point.unaided) == (2, 2, 1, 1)
    assert point.mode is Mode.SHARED
    assert point.values == {
        "arrivals": 0.5,
        "stops": 2.0,  # of 100 m
        "effort": 15.0,
        "reversals": pytest.approx((60 * 6 + 120 * 3) / 180),
        "near_passes": 0.5,  # 0.5 m is closer than 0.8 m, 0.9 m is not
    }
    assert set(last.values.values()) == {None}
    assert set(found.directions.values()) == {"few"}
    assert [(each.reached, each.done) for each in found.goals] == [(1, True), (1, False), (1, True)]


def test_sessions_in_another_mode_are_not_compared():
    def sessions(first):
        modes = [first] * 3 + [Mode.MANUAL] * 5
        return [
            session(
                f"2026010{day}-101010", "a",
                ride(
                    f"2026010{day}-101010-r1", modes={mode: 60.0},
                    measures={"rider_reversals": float(day)},
                ),
            )
            for day, mode in enumerate(modes, 1)
        ]  # fmt: skip

    assert rider_progress(sessions(Mode.MANUAL)).directions["reversals"] == "rising"
    assert rider_progress(sessions(Mode.SHARED)).directions["reversals"] == "few"


def test_nobody_s_progress_is_empty():
    found = rider_progress([])
    assert found.sessions == ()
    assert set(found.directions.values()) == {"few"}


def test_a_report_names_the_rider_and_each_limit_that_was_not_kept():
    timeline = SimpleNamespace(speed=(0.2, 0.58, -0.1))
    near = ride("20260101-101010-r1", measures={"min_distance": 0.31})
    assert breaches(near, timeline) == [
        "a person was at 0.31 m, closer than the target of 0.8 m.",
        "the chair drove at 0.58 m/s, above the limit of 0.5 m/s.",
    ]
    kept = ride("20260101-101010-r2", measures={"min_distance": 0.796})
    assert breaches(kept, SimpleNamespace(speed=(0.5,))) == []
    page = session_html(session("20260101-101010", "a", near, kept), {}, rider="<b>Bo</b>")
    assert "Ride 1: a person was at 0.31 m, closer than the target of 0.8 m." in page
    assert "&lt;b&gt;Bo&lt;/b&gt;" in page
    assert "<b>Bo</b>" not in page
    assert page.count("<details>") == 2
    unmeasured = session_html(
        session("20260101-101010", "", ride("20260101-101010-r1", nearest=0.31)), {}
    )
    assert "0.31, closer than the target of 0.8" in unmeasured
    unmeasured = session_html(session("20260101-101010", "", ride("20260101-101010-r1")), {})
    assert "no ride is measured yet" in unmeasured
    assert "nobody was chosen" in unmeasured
