"""What the page is told of a trial: in units for people, the last of each, never without end."""

import json
from math import nan, pi

import numpy as np
import pytest

from worm_monitor.page_content import MOST_LOGGED, MOST_POSES, ROW, PageContent
from worm_msgs_py import (
    BodyState,
    Chamber,
    Comparison,
    Correlation,
    Distribution,
    Episode,
    EpisodeKind,
    Forecast,
    Geometry,
    Keypoint,
    Midline,
    ModelQuantity,
    Observables,
    Quantity,
    SourceEvent,
    SourceEventKind,
    Status,
    Visit,
    Where,
)

SECOND = 1_000_000_000


def state(frame, status=Status.TRACKED, **more):
    point = Keypoint(10.0, 20.0, 1e-3, 2e-3, 0.0)
    return BodyState(
        frame, frame * SECOND, status=status, head=point, centroid=point, tail=point, **more
    )


def midline():
    x = np.arange(100.0)
    return Midline(x, x + 1, x, x, x, x)


def told(shown):
    """Return the news as a page reads them."""
    return json.loads(json.dumps(shown.news(), allow_nan=False))


def test_a_row_has_millimetres_and_degrees_since_the_first_frame():
    shown = PageContent()
    shown.take_state(state(5), 0.0, None)
    shown.take_observables(
        Observables(
            7, 7 * SECOND, r_h_m=9.5e-3, r_c_m=6e-3, r_t_m=nan, theta_h_rad=3 * pi / 2,
            psi_b_rad=-0.5 * pi, psi_h_rad=0.25 * pi, contact=True,
        )
    )  # fmt: skip
    row = dict(zip(ROW, told(shown)["rows"][0], strict=True))
    assert row == {
        "t": 2.0, "r_h": 9.5, "r_c": 6.0, "r_t": None, "theta_h": -90.0, "psi_b": -90.0,
        "psi_h": 45.0, "contact": 1.0,
    }  # fmt: skip


def test_news_are_told_once_and_everything_is_there_for_whoever_comes_late():
    shown = PageContent()
    shown.take_quantities([Quantity("d_c", 1.94999, 1.5, 2.5, 40, "mm", 1.95)])
    assert told(shown)["quantities"]["d_c"]["value"] == 1.95
    assert "quantities" not in told(shown)
    assert shown.everything()["quantities"]["d_c"]["n"] == 40


def test_a_frame_without_pose_says_why_and_how_long_ago_it_was():
    shown = PageContent()
    shown.take_state(state(3, Status.NO_WORM, where=Where.CHAMBER_A), 10.0, 0.05)
    shown.tell_now(12.5)
    now = told(shown)["now"]
    assert not now["has_pose"]
    assert now["reason"] == Status.NO_WORM.reason
    assert (now["age_s"], now["latency_s"], now["where"]) == (2.5, 0.05, "chamber_a")


def test_frames_a_second_are_those_of_late():
    shown = PageContent()
    for k in range(100):
        shown.take_state(state(k), 0.1 * k, None)
        shown.take_counts(2 * k, 0.1 * k)
    shown.tell_now(9.9)
    now = told(shown)["now"]
    assert now["fps_done"] == pytest.approx(10.0, rel=0.02)
    assert now["fps_in"] == pytest.approx(20.0, rel=0.02)


def test_a_pose_is_drawn_once_its_midline_has_come():
    shown = PageContent()
    shown.take_state(state(1), 0.0, None)
    assert shown.pose(SECOND) is None
    shown.take_midline(SECOND, midline())
    pose = shown.pose(SECOND)
    assert pose["midline"][0][0] == 0.0
    assert len(pose["midline"][0]) <= 100
    assert pose["head"] == [10.0, 20.0]


def test_what_is_remembered_is_bounded():
    shown = PageContent()
    for k in range(3 * MOST_POSES):
        shown.take_state(state(k), float(k), None)
        shown.take_midline(k * SECOND, midline())
        shown.take_remark("something", k * SECOND)
        shown.take_health(f"node {k}", 0, "running", {})
    assert sum(shown.pose(k * SECOND) is not None for k in range(3 * MOST_POSES)) == MOST_POSES
    everything = shown.everything()
    assert len(everything["events"]) == MOST_LOGGED
    assert len(everything["health"]) == MOST_LOGGED


def test_events_are_told_in_words():
    shown = PageContent()
    shown.take_state(state(0), 0.0, None)
    shown.take_events(
        [
            Episode("chamber_a", EpisodeKind.FREE, SECOND, 3 * SECOND, 1.5e-3, 0.8e-3),
            Visit("chamber_a", 0, 9 * SECOND, SECOND, 0.1, 8.0, 1),
        ]
    )
    shown.take_source_events([SourceEvent(SourceEventKind.OUTAGE, 4, 4 * SECOND, "gone", 2.0)])
    shown.take_remark("head and tail exchanged")
    excursion, visit, outage, remark = told(shown)["events"]
    assert (excursion["t"], excursion["end"], excursion["kind"]) == (1.0, 3.0, "excursion")
    assert "1.50 mm" in excursion["text"]
    assert "0.80 mm" in excursion["text"]
    assert "8.0 s, 1 skip," in visit["text"]
    assert (outage["t"], outage["end"]) == (4.0, 6.0)
    assert remark["t"] == 0.0


def test_what_happened_before_the_first_frame_has_no_time():
    shown = PageContent()
    shown.take_source_events([SourceEvent(SourceEventKind.OUTAGE, 0, 7 * SECOND, "gone")])
    assert told(shown)["events"][0]["t"] is None


def test_the_rig_is_told_in_millimetres():
    shown = PageContent()
    chamber = Chamber("chamber_a", 512.0, 500.0, 400.0, 0.0, 10e-3, 3e-3)
    shown.take_geometry(Geometry(1, 0, 1024, 1024, (chamber,)))
    chamber = told(shown)["geometry"]["chambers"][0]
    assert (chamber["R_mm"], chamber["W_mm"], chamber["px_per_mm"]) == (10.0, 3.0, 40.0)


def test_the_walks_numbers_are_told_in_units_for_people():
    shown = PageContent()
    items = (
        ModelQuantity("d_c", "m", modelled=2e-3),
        ModelQuantity("tau_h", "s", 30.0, 20.0, 40.0, 25.0, 21.0, nan),
    )
    shown.take_comparison(Comparison(1, quantities=items))
    assert told(shown)["walk"] == {
        "d_c": {"value": 2.0, "low": None, "high": None, "unit": "mm"},
        "tau_h": {"value": 25.0, "low": 21.0, "high": None, "unit": "s"},
    }


def test_a_forecast_is_told_with_its_chances():
    shown = PageContent()
    shown.take_forecast(Forecast(3, 1, median_s=12.34, low_s=1.0, high_s=nan, within_10_s=0.456))
    assert told(shown)["forecast"] == {
        "median": 12.3, "low": 1.0, "high": None,
        "within": [[10, 0.46], [30, None], [60, None]],
    }  # fmt: skip


def test_histograms_and_curves_come_without_nan_and_without_empty_ends():
    shown = PageContent()
    counts = np.array([1, 0, 2, 0, 0])
    shown.take_distribution(Distribution("d_c", "m", np.arange(6) * 1e-3, counts))
    shown.take_distribution(Distribution("what nobody shows", "m", np.arange(2.0), np.ones(1, int)))
    lags = np.array([1.0, 2.0])
    curve = Correlation(lags, np.array([0.5, nan]), lags, np.ones(2, int), lags)
    shown.take_correlation(curve, of_model=False)
    news = told(shown)
    assert news["P_d_c"] == {"edges": [0.0, 1.0, 2.0, 3.0], "counts": [1, 0, 2], "unit": "mm"}
    assert news["correlation"]["c"] == [0.5, None]
    assert not [name for name in news if "nobody" in name]
