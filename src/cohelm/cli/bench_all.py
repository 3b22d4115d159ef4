"""``cohelm bench all``: every benchmark in turn, with little of each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from rich.table import Table

from cohelm.cli.bench import FAILED, INTERRUPTED, Asked, run_bench
from cohelm.cli.report import ERRORS, OUTPUT, as_json, versions, write_json

LITTLE: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "ablation": {"seeds": 2},
        "barn": {"options": {"worlds": "10"}},
        "cards": {"seeds": 2},
        "crowdnav": {"seeds": 20},
        "crowds": {"seeds": 10},
        "paper-dynamic": {"seeds": 5},
        "paper-global": {"seeds": 3},
        "paper-static": {"seeds": 1},
        "planning": {"options": {"sizes": (384, 1000)}},
        "riders": {"seeds": 1},
        "rides": {"seeds": 3},
        "solver": {"options": {"share": 0.05}},
    }
)
"""Of each, what says whether it works and roughly what it finds; a number of seeds that is asked
for wins."""


def bench_all(benches: Mapping[str, tuple[str, str]], asked: Asked) -> int:
    """Run every benchmark, each in a folder of its own; one that fails does not stop the others.

    Args:
        benches: name → module and what it measures.
        asked: as for one of them.

    Returns:
        0, 1 where any of them failed, 130 where it was interrupted.

    Raises:
        OSError: if there can be no such folder.
    """
    folder = asked.out or Path("benches") / "all"
    folder.mkdir(parents=True, exist_ok=True)
    said: dict[str, Mapping[str, Any]] = {}
    status = 0
    for name, (module, _) in benches.items():
        ERRORS.print(f"== cohelm bench {name}", markup=False)
        code, said[name] = _one(name, module, _share(name, asked, folder))
        status = max(status, code)
        if code == INTERRUPTED:
            break
    whole = status != INTERRUPTED
    summary = {"bench": "all", "complete": whole, "benches": said, "versions": versions()}
    (folder / "summary.json").write_text(as_json(summary, indent=2) + "\n", encoding="utf-8")
    if asked.json:
        write_json(summary)
    else:
        OUTPUT.print(_table(said))
    return status


def _share(name: str, asked: Asked, folder: Path) -> Asked:
    little = {**LITTLE.get(name, {})}
    if asked.seeds is not None:
        little["seeds"] = asked.seeds
    return asked._replace(out=folder / name, **little)


def _one(name: str, module: str, asked: Asked) -> tuple[int, Mapping[str, Any]]:
    """The exit status of one, and what came of it in words and numbers."""
    try:
        done, report = run_bench(name, module, asked)
    except KeyboardInterrupt:
        return INTERRUPTED, {"status": "interrupted"}
    except Exception as failure:  # whatever it is, the others go on
        error = f"{type(failure).__name__}: {failure}"
        ERRORS.print(error, markup=False, soft_wrap=True)
        return FAILED, {"status": "not run", "error": error}
    figures = {
        "tasks": done.total,
        "done": done.done,
        "failed": len(done.faults),
        "notes": [] if report is None else list(report.notes),
        "folder": str(asked.out),
    }
    if not done.whole:
        return INTERRUPTED, {"status": "interrupted", **figures}
    if done.faults or report is None:
        return FAILED, {"status": "failed in part", **figures}
    return 0, {"status": "done", **figures}


def _table(said: Mapping[str, Mapping[str, Any]]) -> Table:
    table = Table(title="every benchmark", title_justify="left", header_style="dim")
    for column in ("bench", "status", "tasks", "failed", "remark"):
        table.add_column(column, overflow="fold")
    for name, each in said.items():
        missed = sum("MISSED" in note for note in each.get("notes", ()))
        remark = each.get("error") or (f"{missed} MISSED" if missed else "")
        tasks = f"{each['done']} of {each['tasks']}" if "tasks" in each else ""
        table.add_row(name, each["status"], tasks, str(each.get("failed", "")), remark)
    return table
