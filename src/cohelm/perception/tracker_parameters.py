"""The parameters of the Kalman tracker."""

from __future__ import annotations

from pydantic import Field

from cohelm.config import Model


class TrackerParameters(Model):
    """Of the tracker; assumed where no reason is given."""

    agility: float = Field(0.4, gt=0.0, le=10.0)
    """q, intensity of the white acceleration, m²/s³: √0.4 m/s wandering in a second."""
    surprised_agility: float = Field(2.0, gt=0.0, le=50.0)
    """q of a track whose innovations are far larger than expected (it turns), m²/s³."""
    unseen_agility: float = Field(0.1, gt=0.0, le=10.0)
    """q while a track is not seen, m²/s³: what looks like agility from one sighting to the next
    is in part a body's swaying, which leads nowhere."""
    speed_deviation: float = Field(1.0, gt=0.0, le=5.0)
    """Standard deviation of a new track's velocity on each axis, m/s."""
    gate: float = Field(13.8, gt=0.0, le=100.0)
    """Largest squared Mahalanobis distance of a match (χ², 2 degrees of freedom, 99.9 %)."""
    strangers: float = Field(0.1, gt=0.0, le=10.0)
    """Density at which people appear where nobody was expected, 1/m² and scan: who is less
    likely to be the one who was lost is somebody else."""
    farthest: float = Field(1.0, gt=0.0, le=10.0)
    """Largest distance of a match, m."""
    straying: float = Field(0.3, ge=0.0, le=5.0)
    """Growth of that distance with time unseen, m/s."""
    separation: float = Field(0.35, ge=0.0, le=2.0)
    """No track is born this near one that was just seen, and this far beyond a cluster may
    somebody be expected who is part of it, m."""
    hits: int = Field(3, ge=1, le=20)
    """Sightings among the last ``window`` scans that confirm a track."""
    sure_hits: int = Field(2, ge=1, le=20)
    """The same of one whose shape leaves little doubt."""
    seldom: float = Field(0.5, gt=0.0, le=5.0)
    """Time between scans from which one sighting will do for such a one: there will be no second
    one soon, s."""
    window: int = Field(5, ge=1, le=20)
    """Scans that ``hits`` looks back on."""
    youngest: float = Field(0.09, ge=0.0, le=5.0)
    """Least age at which ``sure_hits`` will do, s: at 40 Hz two sightings are one look."""
    person_from: float = Field(1.0, ge=-5.0, le=5.0)
    """Log-odds of a person that confirm a track (1.0: 73 %)."""
    sure_from: float = Field(2.0, ge=-5.0, le=5.0)
    """Log-odds of a person that leave little doubt (2.0: 88 %)."""
    static_from: float = Field(-1.0, ge=-5.0, le=5.0)
    """Log-odds below which a confirmed track is no person any more."""
    unproven_from: float = Field(0.4, ge=-5.0, le=5.0)
    """The same of one that came where nothing was and has not walked since: a door, a chair."""
    came_from: float = Field(1.0, ge=0.0, le=5.0)
    """Log-odds of motion from which something has come to its place. What has not must have the
    shape of a person, and beyond doubt."""
    still_from: float = Field(2.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape that make a person of what has not moved."""
    still_looks: float = Field(2.0, ge=0.0, le=100.0)
    """Looks at it that this takes; those with few returns count in part."""
    still_least: float = Field(1.2, ge=-5.0, le=5.0)
    """Mean log-odds of a shape above which it remains one."""
    static_moved: float = Field(-0.3, ge=-5.0, le=0.0)
    """Log-odds of having come to its place below which nothing walks: a track that seems to
    has gone from one thing at rest to the next."""
    shape_rate: float = Field(0.15, gt=0.0, le=1.0)
    """Share of the latest look in the running mean of the shape's log-odds: looks at one shape
    are not independent, so they do not add up."""
    motion_gain: float = Field(1.0, ge=0.0, le=5.0)
    """Log-odds gained per sighting of something that walks; at most 5."""
    motion_loss: float = Field(0.2, ge=0.0, le=5.0)
    """Log-odds lost again per sighting at rest."""
    coming_loss: float = Field(0.3, ge=0.0, le=5.0)
    """The same of what came and has not walked since: things that show now and then do so."""
    walked_from: float = Field(0.4, ge=0.0, le=5.0)
    """Distance from its birthplace at which something has walked, m: more than a localiser's
    error of 3 cm and 1° moves what is 8 m away."""
    parallax: float = Field(0.4, ge=0.0, le=5.0)
    """How much farther that is for a sensor in motion, m: it sees other faces of what stands, and
    takes its parts together otherwise."""
    parallax_driven: float = Field(0.5, gt=0.0, le=10.0)
    """How far the sensor has to move for that, m."""
    walking_shape: float = Field(-3.0, ge=-5.0, le=5.0)
    """Mean log-odds of a shape below which nothing walks that stands where something was, or may
    have been: what is seen of a wall beside something else walks along it."""
    walking_age: float = Field(0.8, ge=0.0, le=10.0)
    """From which age on such a thing walks, s: before, nothing is known of what was there."""
    walking_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Least speed of something that walks, m/s."""
    heading_speed: float = Field(0.2, ge=0.0, le=3.0)
    """Least speed at which the heading follows the motion, m/s."""
    patience: float = Field(2.0, gt=0.0, le=20.0)
    """A confirmed track is given up after so long unseen, s; hidden time counts two fifths,
    time in which its place was seen through threefold."""
    tentative_patience: float = Field(0.35, gt=0.0, le=20.0)
    """The same for a tentative one, all its time counted whole, s."""
    told_deviation: float = Field(0.4, gt=0.0, le=5.0)
    """Standard deviation of the place beyond which nobody is told, m; the track lives on."""
    told_absent: float = Field(1.3, gt=0.0, le=20.0)
    """Who has not been seen for longer, so counted, is not told, s; the track lives on."""
    told_passed: float = Field(0.05, ge=0.0, le=5.0)
    """Whose place was seen through for longer is not told, s; the track lives on."""
