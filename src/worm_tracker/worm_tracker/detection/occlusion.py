"""Reconnects the fragments of the body across an occlusion."""

from dataclasses import dataclass, field
from itertools import pairwise
from math import acos, pi

import cv2
import numpy as np

from worm_msgs_py.arrays import Floats, Picture
from worm_tracker.detection.blobs import Blob
from worm_tracker.midline.contour_midline import ContourMidlineSettings, contour_midline
from worm_tracker.midline.curve import arc_length, resample


@dataclass(frozen=True, slots=True)
class OcclusionSettings:
    """Which fragments belong to one body, and which of its ends are occluded."""

    least_fragment_area_widths2: float = 0.3
    """Smallest area of a fragment, in squared widths: less has no direction."""
    least_midline_area_widths2: float = 3.0
    """Area from which a fragment's midline is that of its contour: less is nearly round."""
    most_fragment_width_over_worm: float = 1.6
    """Width of a fragment beyond which it is none of a worm."""
    near_body_widths: float = 1.2
    """How far from the body as it was a fragment of it may lie."""
    occluder_ahead_widths: float = 0.8
    """How far beyond an end the picture is looked at to tell whether it could see more."""
    fading_stretch_widths: float = 0.8
    """The stretch of a fragment before an end that fades whose midline is not believed."""
    faded_signal_over_body: float = 0.55
    """Signal before an end below which the body fades away there; a tip that is seen is dark up to
    its edge."""
    fade_probe_widths: tuple[float, ...] = (0.2, 0.35, 0.5)
    """Where before an end that is looked at."""
    direction_stretch_widths: float = 1.0
    """The stretch before an end over which its direction is taken."""
    most_bend_rad: float = 1.2
    """Largest angle between an end's direction and the way to the next fragment."""
    short_gap_widths: float = 1.5
    """A gap that is shorter has no direction of its own."""
    longest_gap_lengths: float = 0.4
    """Largest gap that is bridged, in lengths of the worm."""
    worm_length_over_longest_fragment: float = 3.0
    """What the worm's length is taken to be where it is not known."""
    least_bridge_part_occluded: float = 0.6
    """Least part of a bridge that lies where the body may be occluded."""
    most_length_over_known: float = 1.06
    """Length of the reconnected body that is not believed: a worm stretches by less."""
    missing_length_widths: float = 1.5
    """A body shorter than the known one by so much goes on in the occluder."""
    contour: ContourMidlineSettings = field(default_factory=ContourMidlineSettings)


@dataclass(frozen=True, eq=False, slots=True)
class ReconnectedBody:
    """A body put together from its fragments, in the window's coordinates.

    Attributes
    ----------
    fragments : list of ndarray, shape (n, 2)
        Midlines of what is seen, in order along the body, each in that direction.
    bridges : list of ndarray, shape (m, 2)
        What is put between them, and at the ends that are occluded.
    occluded_ends : tuple of bool
        Whether the first, and the last, end of the body is occluded.
    """

    fragments: list[Floats]
    bridges: list[Floats]
    occluded_ends: tuple[bool, bool]

    @property
    def ends(self) -> Floats:
        """The first and the last point that is seen, shape (2, 2)."""
        return np.stack([self.fragments[0][0], self.fragments[-1][-1]])


@dataclass(frozen=True, eq=False, slots=True)
class OccludedView:
    """What a body is reconnected in.

    Attributes
    ----------
    signal : ndarray of uint8, shape (h, w)
        Light that the worm takes away, in a window.
    occluder : ndarray of uint8, shape (h, w)
        Not zero where the body may be occluded.
    width, length, level : float
        Of the worm, pixels and grey levels; a length of 0 where none is known yet.
    body : ndarray, shape (n, 2), or None
        Its midline in the frame before, in the window's coordinates.
    settings : OcclusionSettings
    """

    signal: Picture
    occluder: Picture
    width: float
    length: float
    level: float
    body: Floats | None
    settings: OcclusionSettings

    def part_occluded(self, points: Floats) -> float:
        """Return the part of some points that lie in the occluder."""
        height, width = self.occluder.shape
        u, v = np.rint(points).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        hit = self.occluder[v.clip(0, height - 1), u.clip(0, width - 1)] > 0
        return float((hit & inside).mean())

    def goes_on(self, line: Floats) -> bool:
        """Tell whether a line's last end lies before a place that may occlude more of the body."""
        reach = self.settings.occluder_ahead_widths + self.settings.fading_stretch_widths
        ahead = np.linspace(0.0, reach, 8)[:, None] * self.width * self.direction(line)
        return self.part_occluded(line[-1] + ahead) > 0

    def fades(self, line: Floats) -> bool:
        """Tell whether a body fades away towards a line's last end."""
        if not self.goes_on(line):
            return False
        before = np.array(self.settings.fade_probe_widths)[:, None] * self.width
        u, v = np.rint(line[-1] - before * self.direction(line)).astype(int).T
        height, width = self.occluder.shape
        seen = self.signal[v.clip(0, height - 1), u.clip(0, width - 1)]
        return bool(np.median(seen) < self.settings.faded_signal_over_body * self.level)

    def direction(self, line: Floats) -> Floats:
        """Return the unit vector along a line at its last end."""
        s = arc_length(line)
        before = max(s[-1] - self.settings.direction_stretch_widths * self.width, 0.0)
        way = line[-1] - np.array([np.interp(before, s, line[:, k]) for k in (0, 1)])
        return np.asarray(way / max(float(np.hypot(*way)), 1e-9))

    def is_near_body(self, line: Floats) -> bool:
        """Tell whether most of a fragment lies along the body as it was."""
        if self.body is None:
            return True
        away = np.hypot(*(line[:, None] - self.body[None]).T).min(axis=0)
        return bool((away < self.settings.near_body_widths * self.width).mean() > 0.5)


def reconnect(blobs: list[Blob], view: OccludedView) -> ReconnectedBody | None:
    """Put the fragments of a worm together.

    Parameters
    ----------
    blobs : list of Blob
        The objects in a window, in its coordinates.
    view : OccludedView

    Returns
    -------
    ReconnectedBody or None
        None where nothing of the worm is at a place that may occlude it.
    """
    lines = [line for line in (_fragment_midline(blob, view) for blob in blobs) if line is not None]
    if view.body is not None:
        lines = [
            line
            for line in lines
            if view.is_near_body(line) or view.goes_on(line) or view.goes_on(line[::-1])
        ]
        lines.sort(key=lambda line: not view.is_near_body(line))
    if not lines:
        return None
    chain = _chain([_Fragment.of(line, view) for line in lines], view)
    parts = _certain_lines(chain, (False, False))
    bridges = [_bridge(one, other, view) for one, other in pairwise(parts)]
    occluded = _occluded_ends(
        chain, sum(map(_line_length, parts)) + sum(map(_line_length, bridges)), view
    )
    if not bridges and not any(occluded):
        return None
    if any(occluded):
        parts = _certain_lines(chain, occluded)
        seen = sum(map(_line_length, parts)) + sum(map(_line_length, bridges))
        if view.length and view.body is not None:
            bridges += _continued_ends(parts, occluded, view.length - seen, view.body, view)
    return ReconnectedBody(parts, bridges, occluded)


def paint(picture: Picture, lines: list[Floats], width: float, level: float) -> Picture:
    """Return a signal with bodies drawn into it that have a width and a level."""
    strip = np.zeros_like(picture)
    for line in lines:
        fine = np.rint(16 * resample(line, 48)).astype(np.int32)
        cv2.polylines(strip, [fine], False, min(level, 255.0), max(1, round(width)), 16, 4)
    return np.asarray(cv2.max(picture, cv2.GaussianBlur(strip, (3, 3), 0)), np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class _Fragment:
    """A fragment's midline, and how long the stretches are in which it fades at either end."""

    line: Floats
    fades: tuple[float, float]

    @classmethod
    def of(cls, line: Floats, view: OccludedView) -> "_Fragment":
        stretch = view.settings.fading_stretch_widths * view.width
        first, last = (stretch if view.fades(way) else 0.0 for way in (line[::-1], line))
        return cls(line, (first, last))

    def reversed(self) -> "_Fragment":
        return _Fragment(self.line[::-1], self.fades[::-1])

    def certain_line(self, first: bool, last: bool) -> Floats:
        """Return the line without the stretches in which it fades, at the ends that are asked for.

        A fragment that would hardly be longer than these stays as it is.
        """
        s = arc_length(self.line)
        start, end = first * self.fades[0], s[-1] - last * self.fades[1]
        if end - start < 0.5 * s[-1]:
            return self.line
        at = np.linspace(start, end, len(self.line))
        return np.stack([np.interp(at, s, self.line[:, k]) for k in (0, 1)], axis=1)


def _chain(fragments: list[_Fragment], view: OccludedView) -> list[_Fragment]:
    """Return the fragments that continue the first one, in order along the body."""
    chain, rest = [fragments[0]], fragments[1:]
    longest = view.settings.worm_length_over_longest_fragment * _line_length(fragments[0].line)
    length = view.length or longest
    while rest:
        found = _best_continuation(chain, rest, length, view)
        if found is None:
            break
        at_start, k, fragment = found
        rest.pop(k)
        chain.insert(0, fragment) if at_start else chain.append(fragment)
    return chain


def _occluded_ends(chain: list[_Fragment], seen: float, view: OccludedView) -> tuple[bool, bool]:
    """Return whether the first, and the last, end of a chain is occluded."""
    missing = view.settings.missing_length_widths * view.width
    short = not view.length or view.length - seen > missing
    return (
        chain[0].fades[0] > 0 or (short and view.goes_on(chain[0].line[::-1])),
        chain[-1].fades[1] > 0 or (short and view.goes_on(chain[-1].line)),
    )


def _certain_lines(chain: list[_Fragment], occluded: tuple[bool, bool]) -> list[Floats]:
    """Return the lines of what is seen for sure: also the ends of the body where these are seen."""
    last = len(chain) - 1
    return [
        fragment.certain_line(k > 0 or occluded[0], k < last or occluded[1])
        for k, fragment in enumerate(chain)
    ]


def _fragment_midline(blob: Blob, view: OccludedView) -> Floats | None:
    """Return the midline of a fragment; None where it is none of a worm."""
    width, settings = view.width, view.settings
    if blob.area < settings.least_fragment_area_widths2 * width**2:
        return None
    if blob.area > settings.least_midline_area_widths2 * width**2:
        found = contour_midline(blob.contour, width, None, settings.contour)
        if found is not None:
            narrow = found.width < settings.most_fragment_width_over_worm * width
            return found.points if narrow else None
    centre, (a, b), turn = cv2.minAreaRect(blob.contour)
    along = np.radians(turn if a >= b else turn + 90)
    way = 0.5 * max(a, b) * np.array([np.cos(along), np.sin(along)])
    return np.linspace(centre - way, centre + way, 9)


def _best_continuation(
    chain: list[_Fragment], rest: list[_Fragment], length: float, view: OccludedView
) -> tuple[bool, int, _Fragment] | None:
    """Return the fragment that continues a chain best: at its start?, which, in the right order."""
    best, least = None, np.inf
    so_far = sum(_line_length(fragment.line) for fragment in chain)
    spare = view.settings.most_length_over_known * view.length - so_far
    for at_start in (True, False):
        end = (chain[0].reversed() if at_start else chain[-1]).certain_line(False, True)
        for k, fragment in enumerate(rest):
            for way in (fragment, fragment.reversed()):  # from the gap on
                line = way.certain_line(True, False)
                far = float(np.hypot(*(line[0] - end[-1])))
                too_far = far > view.settings.longest_gap_lengths * length
                if too_far or (view.length and far + _line_length(line) > spare):
                    continue
                cost = _gap_cost(end, line, view)
                if cost >= least:
                    continue
                bridged = np.linspace(end[-1], line[0], 16)
                if view.part_occluded(bridged) < view.settings.least_bridge_part_occluded:
                    continue
                best, least = (at_start, k, way.reversed() if at_start else way), cost
    return best


def _gap_cost(end: Floats, line: Floats, view: OccludedView) -> float:
    """Return what it costs to go from one line's end to another's start; infinity: too bent."""
    gap = line[0] - end[-1]
    far = float(np.hypot(*gap))
    one, other = view.direction(end), -view.direction(line[::-1])
    if far < view.settings.short_gap_widths * view.width:  # the way across says nothing
        turn = 2 * _angle(one, other)
    else:
        turn = _angle(one, gap) + _angle(other, gap)
    return np.inf if turn > 2 * view.settings.most_bend_rad else far * (1 + turn)


def _angle(one: Floats, other: Floats) -> float:
    scale = float(np.hypot(*one) * np.hypot(*other))
    return acos(min(max(float(one @ other) / scale, -1.0), 1.0)) if scale > 1e-9 else pi


def _line_length(line: Floats) -> float:
    return float(arc_length(line)[-1])


def _bridge(one: Floats, other: Floats, view: OccludedView) -> Floats:
    """Return the smooth curve from the end of one line to the start of another."""
    p, q = one[-1], other[0]
    far = float(np.hypot(*(q - p)))
    a, b = far * view.direction(one), -far * view.direction(other[::-1])
    t = np.linspace(0.0, 1.0, 24)[:, None]
    return np.asarray(
        (2 * t**3 - 3 * t**2 + 1) * p
        + (t**3 - 2 * t**2 + t) * a
        + (3 * t**2 - 2 * t**3) * q
        + (t**3 - t**2) * b
    )


def _continued_ends(
    lines: list[Floats],
    occluded: tuple[bool, bool],
    missing: float,
    body: Floats,
    view: OccludedView,
) -> list[Floats]:
    """Return the occluded ends, as the body went on in the frame before."""
    first, last = lines[0], lines[-1]
    if np.hypot(*(body[0] - first[0])) > np.hypot(*(body[-1] - first[0])):
        body = body[::-1]
    share = max(missing / sum(occluded) - view.width / 2, 1.0)  # it is drawn with a round end
    ends = [(first[::-1], body[::-1]), (last, body)]
    return [
        _onward(line, along, share, view)
        for (line, along), is_occluded in zip(ends, occluded, strict=True)
        if is_occluded
    ]


def _onward(line: Floats, body: Floats, far: float, view: OccludedView) -> Floats:
    """Return a line's continuation beyond its last end, over a distance, along a body."""
    nearest = int(np.hypot(*(body - line[-1]).T).argmin())
    way = body[nearest:] + (line[-1] - body[nearest])
    way = np.concatenate([way, [way[-1] + 2 * far * view.direction(body)]])
    s = arc_length(way)
    at = np.linspace(0.0, far, 24)
    return np.stack([np.interp(at, s, way[:, k]) for k in (0, 1)], axis=1)
