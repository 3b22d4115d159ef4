"""Many people at once, from the scan to tracks."""

import numpy as np

from cohelm.perception import KalmanTracker, ScanClusters

from .rays import Laser, box, observation


def test_of_ten_people_about_the_chair_eight_are_tracked_at_least():
    # All walk in and out at once, 1.5 to 5.5 m away, and hide each other and behind three boxes.
    boxes = [box(3.0, 2.0, 0.5, 0.3), box(-4.0, -3.0, 0.6), box(6.0, -5.0, 0.4)]
    laser = Laser(segments=np.concatenate(boxes))
    detector, tracker = ScanClusters(), KalmanTracker()
    angle = np.arange(10) * 2 * np.pi / 10
    memory = None
    for k in range(60):
        now = k / 10
        away = 3.5 + 2.0 * np.sin(0.3 * now + np.arange(10))
        people = np.stack([away * np.cos(angle), away * np.sin(angle), np.full(10, 0.25)], axis=-1)
        scan, told = laser.scan(now, (0.0, 0.0, 0.0), people)
        seen = (detector.detect(scan, told, laser.walls),)
        tracked, memory = tracker.track(observation(now, told), seen, memory)
    assert len(tracked) >= 8
