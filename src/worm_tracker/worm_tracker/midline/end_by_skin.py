"""Where a picture of a skin with marks says that an end lies.

The body is drawn with its end in many places, in its own skin: what each place of it lets through
is known from open pictures. So a pale end is told from water, and a mark from an overlap.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_tracker.midline.curve import complex_arc_length, unit_grid
from worm_tracker.midline.drawn_skin import SkinnedBody, dim_by_body
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
    most_cost_of_sure: float = 0.2
    least_cost_of_wrong: float = 0.28
    """From what cost on an end that was thought to be sure is laid where it costs less; and from
    what on any is unsure. Of 1352 that were thought to be sure in nine films 143 cost more than the
    one, 65 more than the other; 27 and 26 of the 29 that were more than 0.8 widths off."""
    sd_of_wrong_widths: float = 2.0
    """How unsure such a one is."""
    compared: EndInPictureSettings = field(
        default_factory=lambda: EndInPictureSettings(
            LikeliestEndSettings(
                likelihood=0.01,
                likelihood_over_cost=0.2,
                most_cost=0.28,
                most_cost_moved=0.5,
                sd_over_spread=1.5,
            )
        )
    )
    """It costs 0.04 to 0.18 in the best place: a skin is known less well than a body that is as
    dark all over. Of 995 unsure ends in nine films 614 are told so to 0.42 widths, one of them
    more than a width off (71 of all before); of 543 others, asked to see, none."""


@dataclass(frozen=True, eq=False, slots=True)
class EndInSkin:
    """An end of a body in a picture, and what is needed to draw it in its skin.

    Attributes
    ----------
    picture : PictureAboutEnd
    body : SkinnedBody
        From that end on, in the picture's coordinates.
    rest : int
        How many of its last nodes lie the same wherever the end is.
    through : ndarray, shape (h, w)
        Part of the light that those let through, in the picture's window.
    settings : EndBySkinSettings
    """

    picture: PictureAboutEnd
    body: SkinnedBody
    rest: int
    through: Floats
    settings: EndBySkinSettings

    @classmethod
    def of(
        cls, signal: Picture, body: SkinnedBody, known: KnownEnd, settings: EndBySkinSettings
    ) -> "EndInSkin":
        """Return the first end of a body in a picture.

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
        picture = PictureAboutEnd.of(signal, body.level, known, settings.compared)
        step = float(np.abs(np.diff(body.curve)).mean())
        moved = round((settings.compared.moved_widths + 0.5) * known.width / step)
        join = min(moved, len(body.curve) - 3)
        through, part = np.ones(picture.seen.shape), unit_grid(len(body.curve))
        half = rounded_half_widths(part, body.widths) + settings.broader_px / 2
        behind = slice(join - 1, None)  # one node more of both parts, for how they head
        line, skin = body.curve[behind] - picture.corner, body.absorbed(part[behind])
        dim_by_body(through, line, half[behind], skin, (True, False))
        return cls(picture, body, len(body.curve) - join, through, settings)

    def drawn(self, line: Complex) -> Floats32:
        """Return the signal of the body along a midline, over that of most of it."""
        known, body, st = self.picture.known, self.body, self.settings
        end = line[: len(line) - self.rest + 2]
        part = complex_arc_length(end) / known.length_px
        half = rounded_half_widths(part, body.widths) + st.broader_px / 2
        tip = st.blurred_tip_widths * known.width / known.length_px
        through, skin = self.through.copy(), body.absorbed(np.maximum(part, tip))
        dim_by_body(through, end - self.picture.corner, half, skin, (False, True))
        sharp = (1 - through).astype(np.float32) * np.float32(body.blackest / body.level)
        blurred = cv2.GaussianBlur(sharp, (0, 0), st.blur_widths * known.width)
        return np.asarray(blurred, np.float32)

    @property
    def cost(self) -> float:
        """How much the body as it lies differs from the picture; 0 beyond it."""
        return self.picture.cost_of(self.body.curve, self.drawn)

    def likeliest(self) -> LikeliestEnd:
        """Return where the end lies best, by the marks and the darkness of the skin."""
        return self.picture.likeliest_end(self.body.curve, self.drawn)
