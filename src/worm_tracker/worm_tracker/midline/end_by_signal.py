"""Where a picture's grey levels say that an end lies, where overlaps are darker than the body.

The body is drawn with its end in many places, as dark as it is and as blurred. A place along the
path that one line of grey levels leaves open, as that of a thin tail on its own strand, all of the
picture about it tells.
"""

from dataclasses import dataclass, field, replace
from functools import partial

from worm_msgs_py.arrays import Complex, Floats, Floats32, Picture
from worm_tracker.midline.curve import unit_grid
from worm_tracker.midline.drawn_signal import BodySignal, SignalDrawingSettings, expected_signal
from worm_tracker.midline.end_in_picture import EndInPictureSettings, PictureAboutEnd
from worm_tracker.midline.likeliest_end import KnownEnd, LikeliestEnd, LikeliestEndSettings
from worm_tracker.midline.rounded_widths import rounded_half_widths


@dataclass(frozen=True, slots=True)
class EndBySignalSettings:
    """How a body is drawn with its end in many places, and how likely each is."""

    narrower_px: float = 0.5
    """How much narrower the body is drawn: each pixel that it touches is."""
    drawing: SignalDrawingSettings = field(default_factory=partial(SignalDrawingSettings, finer=2))
    compared: EndInPictureSettings = field(
        default_factory=lambda: EndInPictureSettings(
            LikeliestEndSettings(
                likelihood=0.0064,
                likelihood_over_cost=0.2,
                most_cost=0.1,
                most_cost_moved=0.1,
                sd_over_spread=1.5,
            )
        )
    )
    """It costs 0.01 to 0.1 in the best place, more where the body lies otherwise. Of 1097 unsure
    ends in five films 608 are told so to 0.42 widths, one of them more than a width off (91 of all
    before); their root mean square error is half to two thirds of what is told."""


def end_by_signal(
    signal: Picture,
    body: BodySignal,
    widths: Floats,
    known: KnownEnd,
    settings: EndBySignalSettings,
) -> LikeliestEnd:
    """Return where the first end of a body lies best, by the picture's grey levels.

    Parameters
    ----------
    signal : ndarray of uint8, shape (h, w)
        Background minus picture.
    body : BodySignal
        From that end on, in the signal's coordinates.
    widths : ndarray, shape (m,)
        Its widths from that end on, at equal parts of its length, pixels.
    known : KnownEnd
        That end.
    settings : EndBySignalSettings
    """
    picture = PictureAboutEnd.of(signal, body.level, known, settings.compared)

    def drawn(line: Complex) -> Floats32:
        narrower = 2 * rounded_half_widths(unit_grid(len(line)), widths) - settings.narrower_px
        lies_so = replace(body, curve=line)
        shape, corner = picture.seen.shape, picture.corner
        return expected_signal(shape, corner, lies_so, narrower, True, settings.drawing)

    return picture.likeliest_end(body.curve, drawn)
