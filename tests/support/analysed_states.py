"""The analysis of a row of states in one call, and a rig whose wall has no exit."""

from dataclasses import replace

import numpy as np
from walked_tracks import GEOMETRY

from worm_analysis.analysis import Analysis

CLOSED = replace(
    GEOMETRY,
    chambers=tuple(replace(chamber, exit_width_m=np.nan) for chamber in GEOMETRY.chambers),
)
"""A rig in which no exit is known: the wall goes all the way round."""


def analyse(states, geometry=GEOMETRY, parameters=None):
    analysis = Analysis(parameters)
    if geometry:
        analysis.set_geometry(geometry)
    results = [analysis.push(state) for state in states]
    events = [event for _, closed in results for event in closed] + analysis.finish()
    return analysis, [observables for observables, _ in results], events


def by_name(analysis):
    return {quantity.name: quantity for quantity in analysis.summary()}
