"""The detection of a worm whose fragments were reconnected across an occlusion."""

from dataclasses import replace

import cv2
import numpy as np

from worm_msgs_py.arrays import Picture
from worm_tracker.detection.blobs import find_blobs, whole_picture
from worm_tracker.detection.detection import Detection, DetectionPrior, Occlusion, SignalView
from worm_tracker.detection.occlusion import (
    OccludedView,
    OcclusionSettings,
    ReconnectedBody,
    paint,
    reconnect,
)


def reconnected(
    view: SignalView,
    occluder: Picture,
    width: float,
    level: float,
    prior: DetectionPrior,
    settings: OcclusionSettings,
) -> ReconnectedBody | None:
    """Return the worm put together from the fragments in a window; None where nothing is occluded.

    Parameters
    ----------
    view : SignalView
    occluder : ndarray of uint8
        Not zero where the body may be occluded.
    width, level : float
        The worm's, pixels and grey levels.
    prior : DetectionPrior
    settings : OcclusionSettings
    """
    body = None if prior.body is None else view.in_window(prior.body)
    length = prior.model.length if prior.model else 0.0
    seen = OccludedView(view.signal, occluder, width, length, level, body, settings)
    here = whole_picture(view.smooth.shape)
    blobs = find_blobs(view.smooth, view.threshold, here, view.settings)
    return reconnect(blobs, seen)


def drawn(
    view: SignalView, occluder: Picture, body: ReconnectedBody, width: float, level: float
) -> Detection | None:
    """Return the detection of a worm put together, what is occluded drawn in.

    Parameters
    ----------
    view : SignalView
    occluder : ndarray of uint8
        Not zero where the body may be occluded.
    body : ReconnectedBody
    width, level : float
        What it is drawn with, pixels and grey levels.
    """
    signal = paint(view.signal, body.bridges, width, level)
    smooth = paint(view.smooth, body.bridges, width, level)
    for fragment in body.fragments:  # one object, also where it fades
        smooth = paint(smooth, [fragment], 1, level)
    view = replace(view, signal=signal, smooth=smooth)
    blobs = view.blobs()
    if not blobs:
        return None
    first = body.fragments[0]
    ((u, v),) = view.in_picture(first[len(first) // 2][None]).tolist()
    inside = [cv2.pointPolygonTest(blob.contour[:, None], (u, v), True) for blob in blobs]
    return Detection(
        view,
        blobs[int(np.argmax(inside))],
        occlusion=Occlusion(view.in_picture(body.ends), body.occluded_ends),
        occluder=occluder,
    )
