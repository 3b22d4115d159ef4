"""A request may have people kept farther away than the gate does by itself."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.messages import Mode
from cohelm.robots.clearance import CLOSEST, Clearance
from cohelm.safety import GateParameters, gate
from cohelm.testing.scenes import walkers

from .scenes import request, sound, surroundings


def decided(chair, gap, *, farther, margin, mode=Mode.SHARED):
    x, _, radius = chair.discs[-1]
    somebody = walkers([[x + radius + gap + 0.25, 0.0, -0.5, 0.0]])
    return gate(
        np.array([0.8, 0.0, 0.0]),
        sound(speed=0.8),
        replace(request(mode), extra_clearance=farther),
        chair,
        **surroundings(None, somebody),
        clearance=Clearance(now=margin),
        parameters=GateParameters(),
    )


@pytest.mark.parametrize("gap", [0.2, 0.5, 0.6, 0.7, 0.8, 1.0, 2.0])
@pytest.mark.parametrize(("farther", "margin"), [(0.0, 0.12), (0.3, 0.1), (0.4, 0.12), (-1.0, 0.2)])
def test_it_is_as_if_the_margin_were_so_much_wider(chair, gap, farther, margin):
    wider = margin + max(farther, 0.0) / CLOSEST
    asked = decided(chair, gap, farther=farther, margin=margin)
    assert identical(asked, decided(chair, gap, farther=0.0, margin=wider))


def test_it_matters_where_it_should(chair):
    """In the time that it takes to brake both come 0.8·0.2 + 0.8²/2a + 0.5·(0.2 + 0.8/a) nearer."""
    a = chair.max_deceleration
    needed = 0.8 * 0.2 + 0.8**2 / (2.0 * a) + 0.5 * (0.2 + 0.8 / a)
    near, far = (decided(chair, needed + 0.3, farther=by, margin=0.12) for by in (0.0, 0.4))
    assert near.twist[0] == pytest.approx(0.8)
    assert far.twist[0] < 0.8
