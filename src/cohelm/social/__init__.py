"""Social space: which shape with which parameters for this person, this group."""

from cohelm.social.api import SocialModel
from cohelm.social.group_space import group_spaces
from cohelm.social.personal_space import PersonalSpace

__all__ = ["PersonalSpace", "SocialModel", "group_spaces"]
