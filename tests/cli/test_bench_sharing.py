"""``cohelm bench sharing``: help, wrong names, and a small study."""

import csv


def test_the_command_refuses_in_one_line(cohelm, tmp_path):
    code, out, err = cohelm("bench", "sharing", "--families", "nothing", "--out", tmp_path / "new")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "--families" in err
    code, out, _ = cohelm("bench", "sharing", "--help")
    assert code == 0
    assert "--families" in out
    assert "--modes" in out


def test_a_small_study_leaves_rows_and_a_report(cohelm, tmp_path):
    folder = tmp_path / "study"
    given = ("bench", "sharing", "--families", "goal", "--modes", "manual,autonomous")
    # A short time limit: the rides need not arrive.
    given = (*given, "--seeds", "1", "--workers", "1", "--set", "time_limit=1", "--out", folder)
    code, out, _ = cohelm(*given)
    assert code == 0
    assert "arrived as the rider" in out.replace("\n", " ")
    with (folder / "rows.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 4 * 2
    assert {each["outcome"] for each in rows} == {"timeout"}
    assert {each["as_wanted"] for each in rows} <= {"0", "0.0"}
    assert cohelm(*given)[0] == 2
    assert cohelm(*given, "--resume")[0] == 0
