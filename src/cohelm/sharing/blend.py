"""The shared reference: x̂ = η x_user + (1 − η) x_global, Xu et al., eq. (12)."""

from __future__ import annotations

import numpy as np

from cohelm.geometry import wrap_angle
from cohelm.messages import Authority, Reference


def blended(path: Reference, authority: Authority) -> Reference:
    """The path's reference pulled toward the rider's states by η; headings blend on the circle.

    Without authority it is the path's reference itself, bit for bit.
    """
    eta, rider = authority.eta, authority.states
    if eta == 0.0:
        return path
    poses = np.empty_like(path.poses)
    poses[:, :2] = eta * rider.poses[:, :2] + (1.0 - eta) * path.poses[:, :2]
    turn = wrap_angle(rider.poses[:, 2] - path.poses[:, 2])
    poses[:, 2] = path.poses[:, 2] + eta * np.unwrap(turn)
    return Reference(
        step=path.step,
        poses=poses,
        speeds=eta * rider.speeds + (1.0 - eta) * path.speeds,
    )
