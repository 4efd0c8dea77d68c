"""A core that is put away and taken up again after any frame goes on as if nothing had been."""

import pytest
from exact_content import content
from walked_tracks import GEOMETRY, rough_track, slides_and_hops

from worm_analysis.analysis import Analysis
from worm_analysis.parameters import AnalysisParameters
from worm_bringup.checkpoints.exact_pickle import dumps, loads
from worm_model.inference.comparison import ModelParameters
from worm_model.inference.trial_model import TrialModel
from worm_model.simulator import scenes
from worm_model.simulator.scenes import Take
from worm_tracker.parameters import TrackerParameters
from worm_tracker.tracker import Tracker

TAKE = Take(px_per_mm=14.0, frames=40)


def untouched(core):
    return core


def put_away(core):
    return loads(dumps(core))


def tracked(film, between):
    """Track a film; `between` frames the tracker may be changed for another."""
    tracker, given = Tracker(TrackerParameters()), []
    for frame in film:
        given += tracker.push(frame.picture, frame.stamp_ns)
        tracker = between(tracker)
    given += tracker.finish()
    return content(given), content(tracker.exchanges), content(tracker.geometry)


@pytest.mark.parametrize(
    "scene",
    [scenes.coil, scenes.bumped_camera, scenes.moving_glare, scenes.light_off],
    ids=lambda scene: scene.__name__,
)
def test_a_tracker_gives_the_same_frames(scene):
    film = list(scene(TAKE))
    assert tracked(film, put_away) == tracked(film, untouched)


def analysed(states, between):
    analysis, said = Analysis(AnalysisParameters(minimum_n=5)), []
    analysis.set_geometry(GEOMETRY)
    for number, state in enumerate(states):
        said.append(analysis.push(state))
        if number % 100 == 99:
            said.append((analysis.summary(), analysis.correlation(), analysis.distributions()))
        if number % 7 == 0:
            analysis = between(analysis)
    said.append(analysis.finish())
    said.append((analysis.summary(), analysis.correlation(), analysis.distributions()))
    return content(said)


@pytest.mark.parametrize(
    "states",
    [
        pytest.param(slides_and_hops(0, 45.0, 10.0).states(), id="slides and hops"),
        pytest.param(rough_track(3).states(), id="gaps, doubts and two chambers"),
    ],
)
def test_an_analysis_says_the_same(states):
    assert analysed(states, put_away) == analysed(states, untouched)


def modelled(between):
    analysis, model, said = Analysis(AnalysisParameters(minimum_n=5)), None, []
    analysis.set_geometry(GEOMETRY)
    model = TrialModel(ModelParameters(forecast_interval_s=1.0))
    model.set_geometry(GEOMETRY)
    for number, state in enumerate(slides_and_hops(0, 45.0, 10.0).states()):
        observables, events = analysis.push(state)
        for event in events:
            model.take_event(event)
        if number % 100 == 99:
            said.append(model.take_summary(tuple(analysis.summary()), state.stamp_ns))
        said.append(model.take_state(observables))
        if number % 7 == 0:
            model = between(model)
    said.append(model.finish())
    assert any(said)
    return content(said)


def test_a_model_forecasts_the_same():
    assert modelled(put_away) == modelled(untouched)
