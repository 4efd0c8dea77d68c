"""Where a picture of a skin with marks says that an end lies.

The body is drawn with its end in many places, in its own skin: what each place of it lets through
is known from open pictures. So a pale end is told from water, and a mark from an overlap.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats32, Picture
from worm_tracker.midline.curve import complex_arc_length, unit_grid
from worm_tracker.midline.drawn_skin import SkinnedBody, dimmed_by_body
from worm_tracker.midline.end_in_picture import EndInPictureSettings, PictureAboutEnd
from worm_tracker.midline.likeliest_end import KnownEnd, LikeliestEnd, LikeliestEndSettings
from worm_tracker.midline.rounded_widths import rounded_half_widths


@dataclass(frozen=True, slots=True)
class EndBySkinSettings:
    """How a body is drawn with its end in many places, and how likely each is."""

    broader_px: float = 0.5
    blur_widths: float = 0.12
    """How much broader the body is drawn, and how blurred: a skin's edge is soft."""
    blurred_tip_widths: float = 1.0
    """How much of the tip is drawn in the skin behind it: its own is known blurred with water."""
    compared: EndInPictureSettings = field(
        default_factory=lambda: EndInPictureSettings(
            LikeliestEndSettings(
                likelihood=0.01,
                likelihood_over_cost=0.2,
                most_cost=0.5,
                most_cost_moved=0.5,
                sd_over_spread=1.5,
            )
        )
    )
    """It costs 0.04 to 0.18 in the best place: a skin is known less well than a body that is as
    dark all over. Of 1151 unsure ends in nine films 650 are told so to 0.42 widths, one of them
    more than a width off (100 of all before); of 600 others, asked to see, none."""


def end_by_skin(
    signal: Picture, body: SkinnedBody, known: KnownEnd, settings: EndBySkinSettings
) -> LikeliestEnd:
    """Return where the first end of a body lies best, by the marks and the darkness of its skin.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    body : SkinnedBody
        From that end on, in the signal's coordinates.
    known : KnownEnd
        That end.
    settings : EndBySkinSettings
    """
    compared = settings.compared
    picture = PictureAboutEnd.of(signal, body.level, known, compared)
    if not picture.seen.size:
        return LikeliestEnd(None, np.inf)
    step = float(np.abs(np.diff(body.curve)).mean())
    join = min(round((compared.moved_widths + 0.5) * known.width / step), len(body.curve) - 3)
    rest = len(body.curve) - join
    through = np.ones(picture.seen.shape)
    part = unit_grid(len(body.curve))
    half = rounded_half_widths(part, body.widths) + settings.broader_px / 2
    behind = slice(join - 1, None)  # one node more of both parts, for how they head
    line = body.curve[behind] - picture.corner
    dimmed_by_body(through, line, half[behind], body.absorbed(part[behind]), (True, False))
    sigma, blackest = settings.blur_widths * known.width, np.float32(body.blackest / body.level)
    tip = settings.blurred_tip_widths * known.width / known.length_px

    def drawn(line: Complex) -> Floats32:
        end = line[: len(line) - rest + 2]
        part = complex_arc_length(end) / known.length_px
        half = rounded_half_widths(part, body.widths) + settings.broader_px / 2
        all_through, skin = through.copy(), body.absorbed(np.maximum(part, tip))
        dimmed_by_body(all_through, end - picture.corner, half, skin, (False, True))
        sharp = (1 - all_through).astype(np.float32) * blackest
        return np.asarray(cv2.GaussianBlur(sharp, (0, 0), sigma), np.float32)

    return picture.likeliest_end(body.curve, drawn)
