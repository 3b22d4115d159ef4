"""Social space: shape and parameters of the space of each person and group."""

from cohelm.social.api import SocialModel
from cohelm.social.personal_space import PersonalSpace, group_spaces

__all__ = ["PersonalSpace", "SocialModel", "group_spaces"]
