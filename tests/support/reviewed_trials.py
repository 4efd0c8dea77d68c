"""Results directories to review: of a simulated worm, and of one that bumps the camera."""

import json

from report_trial import CHAMBER, record, states

FRAMES, FPS = 480, 12.0
"""With some frames that have no worm."""


def small_trial(directory):
    """Write the results of a trial of 40 s."""
    return record(directory, states(FRAMES / FPS, FPS))


def change_summary(directory, change):
    """Let a function change the summary's document."""
    path = directory / "summary.json"
    summary = json.loads(path.read_text())
    change(summary)
    path.write_text(json.dumps(summary))


__all__ = ["CHAMBER", "FPS", "FRAMES", "change_summary", "small_trial"]
