"""An end that may be another, or that the picture does not show, is no surer than what tells it."""

from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest
from body_searches import candidate, search_after
from drawn_folds import NODES_PER_WIDTH, Drawn, as_rows

from worm_model.simulator.rig.strands import polyline_body
from worm_tracker.midline.path import BodyPath, evenly
from worm_tracker.propagation.end_sureness import (
    end_sd_px_of,
    is_too_short,
    most_end_sd_px,
    outline_sd_px,
    s_at_end,
)
from worm_tracker.propagation.propagation_settings import PropagationSettings
from worm_tracker.worm_track import PropagatedBody

WIDTH = 12.0


class Tapered(Drawn):
    """A body whose ends taper over two widths; a round one may turn about its middle unseen."""

    @cached_property
    def body(self):
        s = np.linspace(0.0, 1.0, len(self.curve)) * WIDTH * len(self.curve) / NODES_PER_WIDTH
        part = np.minimum(s, s[-1] - s) / (2 * WIDTH)
        return polyline_body(as_rows(self.curve), WIDTH * (0.15 + 0.85 * np.minimum(part, 1.0)))


COMES_OUT = [(9.0, 0.0), (1.5 * np.pi * 2.5, 1 / 2.5), (3.55, 0.0)]
"""A body whose last end crosses its own strand and ends a width beyond its middle."""


def hairpin(apart_px, beyond_px=0.0):
    """Return a hairpin whose arms are so far apart at their ends, one of them so much longer."""
    arm, r = 12 * WIDTH, 0.8 * WIDTH
    bend = r * np.exp(1j * np.linspace(np.pi / 2, 1.5 * np.pi, 40))
    first = np.linspace(arm + 1j * apart_px / 2, 1j * r, 60)
    last = np.linspace(-1j * r, arm + beyond_px - 1j * apart_px / 2, 60)
    return BodyPath(evenly(200 + 200j + np.r_[first, bend[1:-1], last], 240))


def end_sds(path, seen_px, darkening=0.5, length_scatter=0.02, shorter=1.0, **body):
    search = search_after(path, WIDTH, 1, loops_known=True)
    model = replace(search.model, darkening=darkening, length_scatter=length_scatter)
    model = replace(model, length=shorter * model.length)
    body = PropagatedBody(path, 0.95, 0.95, end_sd_px=seen_px, **body)
    return end_sd_px_of(body, model, search.settings)


@pytest.mark.parametrize(
    ("apart_px", "seen_px", "is_hidden"),
    [
        pytest.param(2.0, 4.0, True, id="coincide, and are seen to a third of a width"),
        pytest.param(2.0, 1.0, False, id="coincide, and are seen"),
        pytest.param(1.6 * WIDTH, 4.0, False, id="lie beside each other"),
    ],
)
def test_ends_that_coincide_are_hidden_unless_both_are_seen_well(apart_px, seen_px, is_hidden):
    sds = end_sds(hairpin(apart_px), (seen_px, 1.0))
    assert sds == ((WIDTH, WIDTH) if is_hidden else (seen_px, 1.0))


@pytest.mark.parametrize("darkening", [0.5, 0.0])
def test_of_one_shade_an_end_on_the_body_is_no_surer_than_the_length(darkening):
    path = hairpin(0.5 * WIDTH, beyond_px=6 * WIDTH)
    first, last = end_sds(path, (1.0, 1.0), darkening)
    by_length = 0.02 * path.length
    assert first == pytest.approx(by_length if darkening == 0.0 else 1.0)
    assert last == 1.0, "it lies clear of the body"


@pytest.mark.parametrize(
    ("shorter", "darkening", "is_told"),
    [(1.2, 0.0, True), (1.4, 0.0, False), (1.4, 0.5, True)],
)
def test_of_one_shade_an_end_on_a_body_shorter_than_any_stroke_makes_it_is_not_told(
    shorter, darkening, is_told
):
    """Seven midlines of a worm of one shade were told by their outline, 25 % short and more."""
    path = hairpin(0.5 * WIDTH, beyond_px=6 * WIDTH)
    outline = (1.0, np.inf)
    first, last = end_sds(path, (1.0, 1.0), darkening, shorter=shorter, outline_sd_px=outline)
    assert (first == 1.0) is is_told
    assert is_told or first > 3 * WIDTH
    assert last == 1.0, "it lies clear of the body"


@pytest.mark.parametrize(
    ("outline_px", "loop_in_doubt", "told_px"),
    [
        pytest.param(0.5, None, 1.0, id="as it is seen"),
        pytest.param(3.0, None, 3.0, id="as the outline tells"),
        pytest.param(np.inf, None, "by length", id="as its length tells"),
        pytest.param(2.5, (0.3, 0.6), 2.5, id="a loop is in doubt, but the outline is sure"),
        pytest.param(4.0, (0.3, 0.6), "by length", id="a loop is in doubt, the outline less sure"),
    ],
)
def test_of_one_shade_an_end_is_as_sure_as_its_outline_tells(outline_px, loop_in_doubt, told_px):
    """Less so with a loop in doubt: strands that are taken for each other have one outline."""
    path = hairpin(0.5 * WIDTH, beyond_px=6 * WIDTH)
    search = search_after(path, WIDTH, 1, loops_known=True)
    model = replace(search.model, darkening=0.0, length_scatter=0.02)
    body = PropagatedBody(
        path, 0.95, 0.95, end_sd_px=(1.0, 1.0), outline_sd_px=(outline_px, np.inf)
    )
    first, _ = end_sd_px_of(replace(body, doubt_by_bends=loop_in_doubt), model, search.settings)
    assert first == pytest.approx(0.02 * path.length if told_px == "by length" else told_px)


@pytest.mark.parametrize(
    ("arcs", "darkening", "is_clear"),
    [
        pytest.param(COMES_OUT, 0.0, True, id="comes out"),
        pytest.param([(8.0, 0.0), (6 * np.pi + 3, 1 / 3)], 0.0, False, id="lies along the body"),
        pytest.param(COMES_OUT, 0.45, False, id="overlaps tell it"),
    ],
)
def test_the_outline_tells_an_end_that_comes_out_from_under_the_body(arcs, darkening, is_clear):
    drawn = Tapered.of(arcs, WIDTH, darker=darkening > 0)
    path = BodyPath(evenly(drawn.at(np.linspace(0.0, drawn.length, 600)), 240))
    model = search_after(path, WIDTH, 1, loops_known=True).model
    at = np.linspace(0.0, drawn.length, len(model.widths))
    widths = np.interp(at, drawn.body.s_px, drawn.body.width_px)
    model = replace(model, widths=widths, darkening=darkening)
    settings = PropagationSettings()
    found = replace(candidate(path), end_sd_px=(1.0, 1.0))
    first, last = outline_sd_px(drawn.mask, found, model, settings)
    assert first == np.inf, "it lies by itself: that is not asked"
    assert (last < settings.most_end_sd_widths * WIDTH) is is_clear
    as_sure = outline_sd_px(drawn.mask, found, model, replace(settings, sd_of_misfit=1.0))[1]
    assert last == pytest.approx(settings.sd_of_misfit * as_sure), "its flanks fit nowhere"
    unsure = replace(found, end_sd_px=(1.0, WIDTH))
    assert outline_sd_px(drawn.mask, unsure, model, settings) == (np.inf, np.inf)
    by_flanks = replace(unsure, flanks_sd_px=(np.inf, 3.0))
    told = outline_sd_px(drawn.mask, by_flanks, model, settings)
    assert told == ((np.inf, np.inf) if darkening else (np.inf, 3.0)), "flanks that fit tell more"


@pytest.mark.parametrize(("crossing", "is_hidden"), [(True, True), (False, False)])
def test_an_end_where_two_other_strands_cross_is_hidden(crossing, is_hidden):
    """Of one strand on another it is seen how dark both are; a third makes that hardly darker."""
    away, back, again = [0.0, 6.0], [6 + 4j, -6 - 4j], [-6 + 4j, 6 - 4j]
    legs = 200 + 200j + WIDTH * np.array(away + back + (again if crossing else []))
    s = np.r_[0.0, np.cumsum(np.abs(np.diff(legs)))]
    path = BodyPath(np.interp(np.linspace(0, s[-1], 400), s, legs))
    assert end_sds(path, (1.0, 1.0)) == (WIDTH if is_hidden else 1.0, 1.0)


@pytest.mark.parametrize(
    ("over_limits", "in_doubt", "is_stricter"),
    [(0.5, (0.3, 0.8), True), (0.2, (0.3, 0.8), False), (0.5, None, False)],
)
def test_beside_a_loop_in_doubt_and_something_left_over_an_end_must_be_surer(
    over_limits, in_doubt, is_stricter
):
    """What is left over may be that end, elsewhere."""
    path = hairpin(1.6 * WIDTH)
    search = search_after(path, WIDTH, 1, loops_known=True)
    body = PropagatedBody(path, 0.95, 0.95, over_limits=over_limits, doubt_by_bends=in_doubt)
    usual = replace(body, over_limits=0.0, doubt_by_bends=None)
    most, mostly = (most_end_sd_px(b, search.model, search.settings) for b in (body, usual))
    assert (most < mostly) is is_stricter
    assert most <= mostly


def pale_tailed(path, marked):
    """Return a search for a worm with a pale tail, which has marks or is even, and its model."""
    search = search_after(path, WIDTH, 1, loops_known=True)
    node = np.arange(65)
    levels = np.where(node > 48, 45.0, 100.0)
    levels = np.where(marked & (node > 60), 110.0, levels)
    return search, replace(search.model, darkening=0.5, levels=levels, length_scatter=0.03)


@pytest.mark.parametrize(
    ("marked", "seen_widths", "over_limits", "is_told"),
    [
        pytest.param(True, 0.15, 0.2, True, id="its marks tell"),
        pytest.param(False, 0.15, 0.2, False, id="it has none"),
        pytest.param(True, 0.3, 0.2, False, id="not surely"),
        pytest.param(True, 0.15, 0.7, False, id="and something is left over"),
    ],
)
def test_a_pale_end_on_the_body_is_told_by_its_marks_alone(
    marked, seen_widths, over_limits, is_told
):
    path = hairpin(0.5 * WIDTH, beyond_px=-6 * WIDTH)
    search, model = pale_tailed(path, marked)
    seen = 1.0, seen_widths * WIDTH
    body = PropagatedBody(path, 0.95, 0.95, end_sd_px=seen, over_limits=over_limits)
    _, last = end_sd_px_of(body, model, search.settings)
    assert last == pytest.approx(seen[1] if is_told else 0.03 * path.length)


@pytest.mark.parametrize(("apart_widths", "is_told"), [(0.5, False), (0.8, True)])
def test_a_pale_end_beside_the_body_is_seen_and_one_on_it_is_not(apart_widths, is_told):
    """Half-way along the longer arm, 0.8 or 1 width from its middle."""
    path = hairpin(apart_widths * WIDTH, beyond_px=-6 * WIDTH)
    search, model = pale_tailed(path, marked=False)
    body = PropagatedBody(path, 0.95, 0.95, end_sd_px=(1.0, 1.5))
    _, last = end_sd_px_of(body, model, search.settings)
    assert last == pytest.approx(1.5 if is_told else 0.03 * path.length)


@pytest.mark.parametrize("whole", [True, False])
def test_a_pale_end_of_a_short_body_is_told_where_its_marks_show_that_it_is_whole(whole):
    path = hairpin(0.9 * WIDTH, beyond_px=6 * WIDTH)
    search, model = pale_tailed(path, marked=True)
    model = replace(model, length=1.2 * path.length)
    body = PropagatedBody(path, 0.95, 0.95, whole_ends=(False, whole))
    _, last = end_sd_px_of(body, model, search.settings)
    assert last == pytest.approx(0.0 if whole else 0.2 * path.length)


@pytest.mark.parametrize(("over_limits", "is_stricter"), [(0.8, True), (0.6, False)])
def test_beside_much_that_a_marked_body_leaves_over_an_end_must_be_surer(over_limits, is_stricter):
    path = hairpin(1.6 * WIDTH)
    search, model = pale_tailed(path, marked=True)
    body = PropagatedBody(path, 0.95, 0.95, over_limits=over_limits)
    most, mostly = (
        most_end_sd_px(each, model, search.settings)
        for each in (body, replace(body, over_limits=0.0))
    )
    assert (most < mostly) is is_stricter


@pytest.mark.parametrize(("other_way", "is_s"), [(True, True), (False, False)])
def test_a_body_that_bends_both_ways_near_an_end_does_not_explain_its_picture(other_way, is_s):
    bends = np.array([0.9, -0.9 if other_way else 0.9])
    headings = np.repeat([0.0, *np.cumsum(bends)], [60, 4, 6])
    path = BodyPath(evenly(200 + 200j + np.cumsum(0.25 * WIDTH * np.exp(1j * headings)), 240))
    assert s_at_end(path, WIDTH, PropagationSettings()) is is_s
    body = PropagatedBody(path, 0.95, 0.95, is_s_at_end=is_s)
    assert body.is_explained is not is_s


@pytest.mark.parametrize(
    ("part", "darkening", "is_short"),
    [(0.75, 0.0, True), (0.9, 0.0, False), (1.1, 0.0, False), (0.75, 0.45, False)],
)
def test_an_open_body_shorter_than_a_stroke_makes_it_hides_an_end(part, darkening, is_short):
    """Where overlaps are darker they would show it."""
    path = hairpin(6 * WIDTH)
    search = search_after(path, WIDTH, 1, loops_known=True)
    model = replace(search.model, darkening=darkening, length=path.length / part)
    assert is_too_short(path.points, model, search.settings) is is_short
