"""Contact is told from noisy radii as the paper's rule tells it from the radius without noise."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worm_analysis.events.contact_state import ContactStateSettings, HiddenContact, tells_contact
from worm_analysis.events.excursion_depth import ExcursionDepth, RadiusNoise

THRESHOLD, TOUCH = 1.2e-4, 0.4e-4
RATE_HZ = 30
seeds = st.integers(0, 2**32 - 1)


def depths(seed, seconds=300.0):
    """A head that is at the wall, or off it by a threshold and more, for a second on average."""
    rng = np.random.default_rng(seed)
    found, n = [], round(seconds * RATE_HZ)
    while len(found) < n:
        found += [TOUCH] * (1 + rng.geometric(1 / RATE_HZ))
        found += [THRESHOLD + rng.exponential(1.1e-3)] * (1 + rng.geometric(1 / RATE_HZ))
    return np.array(found[:n])


def noise(seed, n, deviation, kept=0.0):
    rng = np.random.default_rng((seed, 1))
    found = [rng.normal()]
    while len(found) < n:
        found.append(kept * found[-1] + np.sqrt(1 - kept**2) * rng.normal())
    return deviation * np.array(found)


def told(seen, mouth=None, sensor=None):
    """Return the frames as they are settled, and what was told of each at once."""
    sensor = sensor or HiddenContact()
    mouth = np.zeros(len(seen), bool) if mouth is None else mouth
    settled, at_once = [], []
    for k, (depth, before_exit) in enumerate(zip(seen.tolist(), mouth.tolist(), strict=True)):
        now, resolved = sensor.push(
            round(k / RATE_HZ * 1e9), 0.0, depth, (0.0, 0.0), THRESHOLD, in_mouth=before_exit
        )
        at_once.append(now)
        settled += resolved
    return settled + sensor.cut(), np.array(at_once), sensor


def ends(contact):
    return int(np.sum(contact[:-1] & ~contact[1:]))


@pytest.mark.parametrize(("deviation", "kept"), [(1e-5, 0.0), (3e-5, 0.0), (4e-5, 0.72)])
def test_noise_neither_makes_contacts_nor_hides_them(deviation, kept):
    """One threshold would count up to twice as many."""
    true = np.concatenate([depths(seed) for seed in range(3)])
    seen = true + noise(1, len(true), deviation, kept)
    settled, at_once, sensor = told(seen)
    contact, truth = np.array([frame.contact for frame in settled]), true < THRESHOLD
    assert len(settled) == len(true), "every frame once"
    assert sum(frame.leaves for frame in settled) == pytest.approx(ends(truth), rel=0.05)
    assert ends(contact) == pytest.approx(ends(truth), rel=0.06)
    assert contact.mean() == pytest.approx(truth.mean(), abs=0.02)
    assert np.mean(at_once == truth) > 0.95
    assert sensor.law.noise * THRESHOLD == pytest.approx(deviation, rel=0.06)
    assert sensor.law.kept == pytest.approx(kept, abs=0.08)


def test_without_noise_the_rule_is_the_papers():
    true = depths(4)
    settled, at_once, _ = told(true)
    contact = np.array([frame.contact for frame in settled])
    assert np.mean(contact != (true < THRESHOLD)) < 0.002, "bins of a sixtieth of the threshold"
    late = np.arange(len(true)) > 20 * RATE_HZ
    assert np.mean(at_once[late] != (true < THRESHOLD)[late]) < 0.002


@pytest.mark.parametrize("offset", [-5e-5, 5e-5])
def test_a_wall_that_is_drawn_off_its_place_moves_the_threshold(offset):
    true = depths(5)
    settled, _, sensor = told(true + offset + noise(5, len(true), 2e-5))
    assert sensor.law.touch * THRESHOLD == pytest.approx(TOUCH + offset, abs=5e-6)
    assert sum(f.leaves for f in settled) == pytest.approx(ends(true < THRESHOLD), rel=0.05)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_before_the_exit_there_is_no_contact(seed):
    rng = np.random.default_rng(seed)
    true = depths(seed, 30.0)
    mouth = rng.random(len(true)) < 0.2
    settled, at_once, _ = told(true + noise(seed, len(true), 2e-5), mouth)
    assert not at_once[mouth].any()
    assert not np.array([frame.contact for frame in settled])[mouth].any()
    assert all(f.leaves == 0 for f, nxt in itertools.pairwise(settled) if nxt.in_mouth)


@settings(max_examples=20, deadline=None)
@given(seeds, st.lists(st.floats(0.1, 5.0), max_size=8))
def test_each_frame_is_settled_once_in_order_however_the_track_is_cut(seed, lengths):
    """And within a bounded time, once the law is known."""
    sensor, stamps, start = HiddenContact(), [], 0
    for length in [20.0, *lengths]:
        seen = depths(seed, length)
        for k, depth in enumerate(seen.tolist()):
            stamp_ns = start + round(k / RATE_HZ * 1e9)
            _, resolved = sensor.push(stamp_ns, 0.0, depth, (0.0, 0.0), THRESHOLD, in_mouth=False)
            stamps += [frame.stamp_ns for frame in resolved]
            if length == 20.0 and k > 16 * RATE_HZ:
                assert stamp_ns - stamps[-1] <= 3.1e9
        stamps += [frame.stamp_ns for frame in sensor.cut()]
        start += round((length + 1) * 1e9)
    assert stamps == sorted(set(stamps))
    assert len(stamps) == sum(len(depths(seed, length)) for length in [20.0, *lengths])


def test_frames_are_held_back_for_as_long_as_the_settings_say():
    held_back_s = {}
    for look_ahead_s in (0.5, 1.5):
        sensor, settled, longest = HiddenContact(ContactStateSettings(look_ahead_s)), 0, 0
        for k, depth in enumerate(depths(6, 30.0).tolist()):
            stamp_ns = round(k / RATE_HZ * 1e9)
            _, resolved = sensor.push(stamp_ns, 0.0, depth, (0.0, 0.0), THRESHOLD, in_mouth=False)
            settled += len(resolved)
            if settled and not resolved:
                longest = max(longest, k + 1 - settled)
        held_back_s[look_ahead_s] = longest / RATE_HZ
    assert held_back_s == pytest.approx({0.5: 1.0, 1.5: 3.0}, abs=0.05)


@pytest.mark.parametrize("shape", ["step", "half sine"])
@pytest.mark.parametrize("kept", [0.0, 0.72])
def test_the_largest_of_noisy_depths_is_not_too_large(shape, kept):
    """The largest of thirty is two deviations above the truth."""
    way = np.ones(30) if shape == "step" else np.sin(np.pi * (np.arange(30) + 0.5) / 30)
    deviation, errors = 4e-5, []
    for seed in range(300):
        excursion = ExcursionDepth(RadiusNoise(deviation, kept))
        for depth in 1e-3 * way + noise(seed, len(way), deviation, kept):
            excursion.push(float(depth))
        errors.append(excursion.maximum() - 1e-3 * way.max())
    assert np.mean(errors) == pytest.approx(0.0, abs=0.6 * deviation)


@given(st.floats(0.0, 1e-3), st.floats(1e-5, 1e-3))
def test_contact_is_told_of_a_head_placed_to_half_a_threshold(depth_sd, threshold):
    assert tells_contact(depth_sd, threshold) == (depth_sd <= 0.5 * threshold)


def test_contact_is_not_told_without_a_width_and_is_where_a_head_is_said_nothing_of():
    assert not tells_contact(0.0, np.nan)
    assert tells_contact(np.nan, THRESHOLD)
