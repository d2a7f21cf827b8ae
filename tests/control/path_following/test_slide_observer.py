"""Missing velocity of a contact that moves to a target, on points with known rolling and friction."""

from __future__ import annotations

import numpy as np
import pytest
import scipy  # loads its parts when they are used: signal and stats take half a second

from tactile_maps.control.path_following.slide_observer import (
    MOST_MISSING,
    MOST_YIELDING,
    SlideObserver,
    YieldObserver,
    observer_rate,
)
from tactile_maps.control.task_control.tasks import PATH_TOLERANCE

DT = 0.005
RATE = 4.0
SPEED = 0.01
AHEAD = np.array([SPEED, 0.0])


class Led:
    """A contact that makes a share of the requested velocity, and is led to a target that moves along the first axis.

    The share of an object of radius R on skin of radius r is r / (r + R).
    """

    def __init__(self, share: float = 1.0, *, start: float = 0.0, curvature: float = 0.0) -> None:
        self.observer = SlideObserver()
        self.curvature = curvature
        self.share = share
        self.point = np.array([-start, 0.0])
        self.target = np.zeros(2)
        self.tried = np.zeros(2)

    def run(self, seconds: float, *, velocity: np.ndarray = AHEAD, observed: bool = True) -> np.ndarray:
        """Return the errors (k, 2) [m]."""
        errors = []
        for _ in range(round(seconds / DT)):
            error = self.target - self.point
            missing = self._look()
            self.tried = RATE * error + velocity + (missing if observed else 0.0)
            self.point = self.point + DT * self.share * self.tried
            self.target = self.target + DT * velocity
            errors.append(error)
        return np.array(errors)

    def _look(self) -> np.ndarray:
        return self.observer.look(1, self.point, self.tried, DT, rate=RATE, speed=SPEED, curvature=self.curvature)


@pytest.mark.parametrize(("object_radius", "skin_radius"), [(0.03, 0.02), (0.03, 0.03), (0.02, 0.04), (0.01, 0.05)])
def test_rolling_contact_has_no_steady_state_error(object_radius, skin_radius):
    share = skin_radius / (skin_radius + object_radius)
    behind = SPEED * (object_radius / skin_radius) / RATE
    curvature = 1 / skin_radius
    assert Led(share, curvature=curvature).run(6.0, observed=False)[-1] == pytest.approx([behind, 0.0], abs=1e-6)
    assert Led(share, curvature=curvature).run(8.0)[-1] == pytest.approx([0.0, 0.0], abs=2e-5)


def test_without_disturbances_the_contact_moves_as_without_the_observer():
    still = np.zeros(2)
    with_observer = Led(start=0.004).run(2.0, velocity=still)
    without = Led(start=0.004).run(2.0, velocity=still, observed=False)
    assert with_observer == pytest.approx(without, abs=1e-12)
    assert (with_observer[:, 0] >= 0).all(), "without overshoot"


@pytest.mark.parametrize(("pitch", "rate"), [(0.002, RATE), (0.004, RATE), (0.0114, 2.20), (0.0228, 1.10)])
def test_rate_follows_the_position_gain_but_stays_well_below_that_of_passing_taxels(pitch, rate):
    assert observer_rate(RATE, SPEED, pitch) == pytest.approx(rate, rel=0.01)


@pytest.mark.parametrize("pitch", [0.006, 0.0114])
def test_periodic_errors_of_the_place_are_not_amplified(pitch):
    """The measured place errs by 1 mm as a sine; without the observer the contact follows K / |i w + K| of it."""
    frequency = 2 * np.pi * SPEED / pitch
    observer = SlideObserver()
    rate = observer_rate(RATE, SPEED, pitch)
    place = np.zeros(2)
    tried = np.zeros(2)
    places = []
    for k in range(4000):
        measured = place + [0.001 * np.sin(frequency * k * DT), 0.0]
        tried = -RATE * measured + observer.look(1, measured, tried, DT, rate=rate, speed=SPEED, curvature=0.0)
        place = place + DT * tried
        places.append(place[0])
    followed = np.abs(places[-1000:]).max() / 0.001
    assert followed < 0.9


@pytest.mark.parametrize(
    ("speed", "curvature", "bound"),
    [
        (0.004, 0.0, 0.004),
        (0.05, 0.0, MOST_MISSING),
        (0.004, 20.0, 0.004),
        (0.004, 50.0, 0.006),
        (0.05, 50.0, 1.5 * MOST_MISSING),
        (0.01, 500.0, 0.02),
    ],
)
def test_missing_velocity_is_bounded_where_the_contact_does_not_move(speed, curvature, bound):
    observer = SlideObserver()
    for _ in range(1000):
        observer.look(1, np.zeros(2), np.array([0.0, 0.1]), DT, rate=RATE, speed=speed, curvature=curvature)
    assert observer.missing == pytest.approx([0.0, bound])


@pytest.mark.parametrize(
    ("contact", "point"), [(2, np.zeros(2)), (1, np.array([0.1, 0.0]))], ids=["another contact", "another side"]
)
def test_missing_velocity_is_discarded_with_the_contact_and_at_a_seam(contact, point):
    led = Led(0.0)
    led.run(1.0)
    assert led.observer.missing[0] > 0
    given = {"rate": RATE, "speed": SPEED, "curvature": 0.0}
    assert led.observer.look(contact, point, AHEAD, DT, **given) == pytest.approx([0.0, 0.0])
    further = led.observer.look(contact, point, AHEAD, DT, **given)
    assert further == pytest.approx([RATE * DT * SPEED, 0.0]), "and estimated from there"
    led.observer.reset()
    assert led.observer.missing == pytest.approx([0.0, 0.0])


class Soft:
    """A mass of 1 kg with dry friction that a spring pulls to a desired position, critically damped."""

    FREQUENCY = 40.0
    FRICTION = 12.0
    """Friction that deflects the spring by 7.5 mm [N]."""

    def __init__(self, *, friction: float = FRICTION, observed: bool = True) -> None:
        self.observer = YieldObserver()
        self.observed = observed
        self.friction = friction
        self.position = self.velocity = self.desired = self.tried = 0.0

    def tick(self, requested: float) -> None:
        """Advance the desired position with this speed [m/s], and the mass by small steps."""
        added = self.observer.look(np.array([self.tried, 0.0]), np.array([self.velocity, 0.0]), DT)
        self.tried = requested + (float(added[0]) if self.observed else 0.0)
        self.desired += DT * self.tried
        steps = 50
        for _ in range(steps):
            pull = self.FREQUENCY**2 * (self.desired - self.position) - 2 * self.FREQUENCY * self.velocity
            if self.velocity == 0.0 and abs(pull) <= self.friction:
                continue
            direction = np.sign(self.velocity) or np.sign(pull)
            before = self.velocity
            self.velocity += DT / steps * (pull - direction * self.friction)
            if before * self.velocity < 0:
                self.velocity = 0.0
            self.position += DT / steps * self.velocity

    def errors(self) -> np.ndarray:
        """Return the errors (k,) behind a target that turns back every second [m]."""
        target = 0.0
        errors = []
        for k in range(round(6 / DT)):
            speed = SPEED if int(k * DT) % 2 == 0 else -SPEED
            error = target - self.position
            self.tick(RATE * error + speed)
            target += DT * speed
            errors.append(error)
        return np.array(errors)


def test_soft_joints_follow_a_target_that_turns_back_against_friction():
    without, with_observer = (
        np.quantile(np.abs(Soft(observed=observed).errors()[400:]), 0.95) for observed in (False, True)
    )
    assert with_observer < PATH_TOLERANCE < without


def test_response_with_yielding_joints_and_without_friction_is_that_of_the_damped_loop():
    """The speed per requested speed is  w² (2 s + w) / ((s + w) (s² + w s + w²)), with a damping ratio of 0.5."""
    soft = Soft(friction=0.0)
    speeds = []
    for _ in range(60):
        soft.tick(0.01)
        speeds.append(soft.velocity)
    w = Soft.FREQUENCY
    closed = scipy.signal.TransferFunction([2 * w**2, w**3], np.polymul([1, w], [1, w, w**2]))
    time = DT * np.arange(1, 61)
    _, expected = scipy.signal.step(closed, T=np.concatenate([[0.0], time]))
    assert np.array(speeds) == pytest.approx(0.01 * expected[1:], abs=0.0015), "up to the delay of a tick"


def test_soft_joint_compensation_is_bounded_and_discarded_on_reset():
    observer = YieldObserver()
    for _ in range(1000):
        observer.look(np.array([1.0, 0.0]) + observer.added, np.zeros(2), DT)
    assert observer.added == pytest.approx([MOST_YIELDING, 0.0])
    observer.reset()
    assert not observer.look(np.zeros(2), np.zeros(2), DT).any()
