"""Constraints of the optimal-control problem, most of them barriers on a distance h.

``barrier`` holds the condition of Xu et al., eq. (9), which all barriers share,
``prediction_selection`` the predicted people that constrain the robot, and ``social_distance`` the
shapes of personal spaces.
"""
