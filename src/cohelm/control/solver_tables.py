"""Arrays of the SQP: rows, programs and workspaces, made once for each size of problem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.control.daqp_call import DaqpArrays, daqp_arrays
from cohelm.control.objective_tables import Objective, Workspace, workspace
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel


class Rows(NamedTuple):
    """Linearised constraints −margin ≤ G·Δu + s ≤ upper."""

    margin: Floats
    """(r,) distance from the lower bound; negative where violated."""
    upper: Floats
    """(r,) distance from the upper bound."""
    jacobian: Floats
    """G, (r, N·m)."""
    slack: Integers
    """(r,) index of the slack; −1: none."""
    key: Integers
    """(r,) identifier, the same from program to program."""
    used: Booleans
    """(r,) rows of the present program."""
    chosen: Integers
    """(r,) indices of the used rows."""
    left: Floats
    """(r,) distance of unused rows from their bounds."""


class Program(NamedTuple):
    """A quadratic program in DAQP's form, over (Δu, the slacks of the used rows)."""

    hessian: Floats
    """(N·m, N·m)."""
    gradient: Floats
    low: Floats
    high: Floats
    l1: Floats
    """(S,) prices of all slacks, and so on."""
    l2: Floats
    column: Integers
    """(S,) column of each slack; −1: not used."""
    slacks: Integers
    """(S,) the used slacks."""
    whole: Floats
    """Flat, with the slacks, and so on."""
    slope: Floats
    upper: Floats
    lower: Floats
    dual: Floats
    rows: Floats
    z: Floats
    multipliers: Floats
    of_inputs: Floats
    """(N·m,) multipliers of the last program: bounds of the inputs, slacks, rows by key."""
    of_slacks: Floats
    of_rows: Floats
    slack: Floats
    """(S,) solution."""


class SolverWorkspace(NamedTuple):
    """Arrays of one solve."""

    model: LocalModel
    rows: Rows
    program: Program
    daqp: DaqpArrays
    work: Workspace
    inputs: Floats
    """(2, L, m): best and trial."""
    poses: Floats
    """(2, L+1, 3)."""
    h: Floats
    """(N+1,) barrier along the trajectory."""
    stages: Floats
    """(N+1, 7): x, y, heading, cos, sin of the linearised trajectory, and (cos, sin) of the
    translation of the step that begins there."""
    multipliers: Floats
    """(n,) λ of the condensation."""


def solver_workspace(scene: Scene, objective: Objective, rows: int) -> SolverWorkspace:
    """Arrays for problems of this size with at most ``rows`` rows."""
    m, states = len(scene.robot.current_input), scene.steps + 1
    x, people = scene.planned * m, scene.people
    s = 2 * people.num_people + 1
    keys = x + scene.planned * (
        len(scene.robot.facets) + 2 * len(people.weight) + len(scene.robot.discs)
    )

    def zeros(*shape: int) -> Floats:
        return np.zeros(shape)

    def whole(count: int) -> Integers:
        return np.zeros(count, np.int64)

    size = x + s
    return SolverWorkspace(
        model=LocalModel(
            zeros(states, 3), zeros(states, 6), zeros(scene.steps, m), zeros(scene.steps, m),
            zeros(scene.steps, m),
        ),
        rows=Rows(
            zeros(rows), zeros(rows), zeros(rows, x), whole(rows), whole(rows),
            np.zeros(rows, np.bool_), whole(rows), zeros(rows),
        ),
        program=Program(
            zeros(x, x), zeros(x), zeros(x), zeros(x), zeros(s), zeros(s), whole(s), whole(s),
            zeros(size * size), zeros(size), zeros(size + rows), zeros(size + rows),
            zeros(size + rows), zeros(rows * size), zeros(size), zeros(size + rows),
            zeros(x), zeros(s), zeros(keys), zeros(s),
        ),
        daqp=daqp_arrays(size + rows),
        work=workspace(scene, objective),
        inputs=zeros(2, scene.steps, m),
        poses=zeros(2, states, 3),
        h=zeros(scene.planned + 1),
        stages=zeros(scene.planned + 1, 7),
        multipliers=zeros(3),
    )  # fmt: skip
