"""What is learned of a body: that it is one open body, and that all of it is seen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_tracker.midline.body_model import (
    BodyModel,
    BodyModelSettings,
    ends_changed_places,
)
from worm_tracker.midline.refine import RefinedMidline

PART = np.linspace(0.0, 1.0, 65)
LENGTH, WIDTH = 150.0, 10.0


def body(widths, levels):
    points = np.c_[LENGTH * PART, np.zeros(65)]
    half_height_widths = np.full(65, np.median(widths))
    return RefinedMidline(
        points, widths, half_height_widths, levels, float(np.median(levels)), 1.0, 1500.0, 75.0, 0.0
    )


def learned(bodies, doubled):
    """Return what is learned of a body that looks doubled, or not, in all pictures."""
    model = BodyModel.of(bodies[0], 1500.0, 1.0, BodyModelSettings())
    for one in bodies[1:]:
        model = model.updated(one, 1500.0, 1.0, doubled)
    return model


def laid_double(frame, width=WIDTH):
    """Return a body that lies on itself with a part that grows and shrinks by a worm's stroke."""
    where = 0.5 + 0.2 * np.sin(frame / 4)
    return body(np.full(65, width), np.where(where < PART, 190.0, 100.0))


def marked(frame):
    """Return a body whose skin has a step, always at the same place of it."""
    noise = np.random.default_rng(frame).normal(1.0, 0.03, 65)
    return body(WIDTH * noise, np.where(PART > 0.7, 70.0, 100.0) * (1 + 0.1 * np.sin(frame / 4)))


def test_a_fold_that_travels_along_the_body_is_no_open_body():
    assert learned([laid_double(frame) for frame in range(90)], doubled=True).is_changing


def test_a_skin_with_a_step_is_one_body_in_any_light():
    assert not learned([marked(frame) for frame in range(90)], doubled=True).is_changing


def test_a_body_that_never_looks_doubled_may_change():
    """A narrow one is measured badly; a larva swells where its wave passes."""
    assert not learned([laid_double(frame) for frame in range(90)], doubled=False).is_changing


def test_few_pictures_do_not_tell():
    assert not learned([laid_double(frame) for frame in range(40)], doubled=True).is_changing


def test_a_wide_body_that_changes_may_yet_be_one_laid_double():
    """Whether it looks so or not: one that lies exactly on itself looks like a shorter one."""
    wide = learned([laid_double(frame, 20.0) for frame in range(200)], doubled=False)
    assert wide.varies
    assert wide.is_young
    assert wide.is_outgrown_by(1.2 * LENGTH)


def test_a_wide_body_that_stays_alike_is_known_after_150_pictures():
    known = learned([body(2 * marked(k).widths, marked(k).levels) for k in range(200)], False)
    assert not known.varies
    assert not known.is_young


def test_a_narrow_body_is_measured_too_badly_to_tell_that_it_changes():
    assert not learned([laid_double(frame) for frame in range(200)], doubled=False).varies


def test_a_wide_body_that_has_not_grown_in_500_pictures_is_believed():
    bodies = [laid_double(frame, 20.0) for frame in range(500)]
    assert not learned(bodies, doubled=False).varies


@pytest.mark.parametrize(("doubled", "may_be"), [(True, True), (False, False)])
def test_a_narrow_body_that_looks_doubled_from_the_first_may_be(doubled, may_be):
    bodies = [laid_double(frame) for frame in range(40)]
    assert learned(bodies, doubled=doubled).may_be_doubled is may_be


def test_a_body_that_was_known_for_long_does_not_become_unknown_by_a_fold():
    alike = [body(2 * marked(k).widths, marked(k).levels) for k in range(160)]
    assert not learned([*alike, *(laid_double(k, 20.0) for k in range(60))], doubled=False).varies


@given(brighter=st.floats(0.5, 2.0), wider=st.floats(0.8, 1.25))
def test_a_profile_differs_by_its_shape_alone(brighter, wider):
    model = learned([marked(0)], doubled=False)
    same = body(marked(0).widths * wider, marked(0).levels * brighter)
    assert model.profile_difference(same) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("shorter_widths", "left_over", "lacks"),
    [
        pytest.param(4.0, 2.0, True, id="a hairpin of two widths, cut off"),
        pytest.param(4.0, 0.5, False, id="contracted, beside a speck"),
        pytest.param(1.0, 2.0, False, id="whole, beside debris"),
        pytest.param(-3.0, 2.0, False, id="stretched, beside debris"),
    ],
)
def test_what_is_left_over_is_the_worms_where_the_worm_lacks_as_much(
    shorter_widths, left_over, lacks
):
    model = learned([marked(0)], doubled=False)
    assert model.lacks(model.length - shorter_widths * model.width, left_over) is lacks


HAIRPIN = np.array([[0.0, 0.0], [90.0, 4.0], [0.0, 30.0]])
"""First end, apex and last end of a body that lies double."""


@given(moved=st.lists(st.floats(-8.0, 8.0), min_size=4, max_size=4))
def test_ends_change_places_where_each_lies_where_the_other_was(moved):
    wobble = np.array([moved[:2], [0.0, 0.0], moved[2:]])
    assert ends_changed_places(HAIRPIN[::-1] + wobble, HAIRPIN, least_px=15.0)
    assert not ends_changed_places(HAIRPIN + wobble, HAIRPIN, least_px=15.0)


def test_ends_that_hardly_move_have_not_changed_places_however_near_they_lie():
    close = HAIRPIN * np.array([1.0, 0.1])
    assert not ends_changed_places(close[::-1], close, least_px=15.0)


def test_overlaps_that_a_body_was_followed_into_are_known_from_the_third_on():
    model = learned([marked(0)], doubled=False)
    known = []
    for darkening in (0.6, 0.4, 0.5, 0.5):
        model = model.with_overlap(darkening)
        known.append(model.darkening)
    assert known == pytest.approx([0.0, 0.0, 0.5, 0.5])
    assert model.updated(marked(1), 1500.0, 1.0, False).with_overlap(0.5).darkening == (
        pytest.approx(0.5)
    )


def test_of_many_overlaps_none_is_taken_to_be_less_than_no_darker():
    model = learned([marked(0)], doubled=False)
    for _ in range(5):
        model = model.with_overlap(-0.2)
    assert model.darkening == 0.0
