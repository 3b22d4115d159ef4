"""The options of the benches that ride."""

from cohelm.cli import bench as command
from cohelm.cli.bench_commands import BENCHES


def test_options_reach_the_bench(monkeypatch, cohelm, tmp_path):
    asked = {}

    def bench(name, module, given):
        asked.update(given.options, module=module)
        return 0

    monkeypatch.setattr(command, "bench", bench)
    code, _, _ = cohelm(
        "bench", "rides", "--planners", "dwa", "--blind", "--set", "time_limit=5",
        "--set", "mode=autonomous", "--seeds", "1", "--out", tmp_path,
    )  # fmt: skip
    assert code == 0
    assert asked == {
        "module": BENCHES["rides"][0],
        "planners": "dwa",
        "scenes": None,
        "settings": ("time_limit=5", "mode=autonomous"),
        "blind": True,
        "both": False,
        "true_people": False,
        "tuned": False,
    }


def test_an_ablation_is_ridden_among_blind_people_unless_they_shall_see(monkeypatch, cohelm):
    asked = []

    def bench(name, module, given):
        asked.append(given.options["seeing"])
        return 0

    monkeypatch.setattr(command, "bench", bench)
    for more in ((), ("--seeing",)):
        assert cohelm("bench", "ablation", "--scenes", "crossing", *more)[0] == 0
    assert asked == [False, True]
