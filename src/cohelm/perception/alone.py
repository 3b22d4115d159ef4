"""No groups: everyone is alone."""

from __future__ import annotations

from cohelm.config import Model
from cohelm.messages import Groups, People


class Alone:
    """Finds no groups; to see what groups are good for."""

    class Parameters(Model):
        """None."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def group(self, people: People, memory: None = None) -> tuple[Groups, None]:
        """See :meth:`GroupDetector.group`."""
        return Groups.alone(len(people)), None
