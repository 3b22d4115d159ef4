from .api import SocialModel
from .personal_space import PersonalSpace, group_spaces

__all__ = ["PersonalSpace", "SocialModel", "group_spaces"]
