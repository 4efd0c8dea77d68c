"""The constants by which a worm is followed: which midlines are believed, and when."""

from dataclasses import dataclass, field, replace

from worm_tracker.detection.blobs import BlobSettings
from worm_tracker.detection.debris import DebrisCuttingSettings
from worm_tracker.detection.polarity import Polarity
from worm_tracker.midline.body_model import BodyModelSettings
from worm_tracker.midline.body_residual import BodyResidualSettings
from worm_tracker.midline.contour_midline import ContourMidlineSettings
from worm_tracker.midline.doubled_body import DoubledBodySettings
from worm_tracker.midline.refine import RefineSettings
from worm_tracker.propagation.propagation_settings import PropagationSettings


@dataclass(frozen=True, slots=True)
class FollowerSettings:
    """Which midlines are believed, and when."""

    least_area_over_known: float = 0.35
    most_area_over_known: float = 2.2
    """Areas beyond these are not the worm's, whatever it does."""
    agreement_of_all: float = 0.95
    """Agreement below which a midline found by the contour may leave something over."""
    most_s_turn_of_open_rad: float = 1.5
    """How sharp an S an open body may make near an end: its midline led into a bend and back."""
    least_agreement: float = 0.7
    """Least agreement of body and picture for a midline to be believed."""
    most_log_length_over_known: float = 0.15
    most_log_length_over_last: float = 0.08
    """A length beyond both is an error, because a worm does not stretch in a moment."""
    most_log_length_in_fold: float = 0.3
    """Log of the length over the known one that no stroke explains: such a body is not told."""
    most_log_shortening: float = 0.1
    """Log of the known length over one that a body may have that lies on itself with an end."""
    most_log_stretch_per_frame: float = 0.04
    """A length that changes by more in a frame is that of a body whose end is not seen."""
    leap_confidence: float = 0.5
    """What a leap of an end leaves of the confidence."""
    occlusion_confidence: float = 0.9
    """What an occluded part leaves of the confidence."""
    most_hole_widths2: float = 0.15
    """Hole, in squared widths, from which a body touches itself."""
    most_side_difference: float = 0.3
    """Difference of a body's sides over its length from which its ends are not where they seem."""
    least_length_over_width: float = 2.5
    """What is stouter is no worm, where its length is not known."""
    most_log_area_over_midline: float = 0.35
    """Log of the area over length times width beyond which a first midline misses a part."""
    most_width_over_known: float = 1.35
    """What is wider is a body laid double."""
    least_length_over_known: float = 0.75
    most_length_over_known: float = 1.35
    """Lengths beyond these are not the worm's."""
    relearn_area_over_known: float = 1.1
    """Area from which, after a long fold, a body of another length is believed."""
    learned_frames: int = 10
    """Midlines from which on the body model is that of this worm."""
    whole_log_length_over_known: float = 0.035
    whole_confidence: float = 0.85
    """Log of the length, and confidence, from which all of the worm is taken to be seen."""
    cut_length_over_known: float = 0.92
    """Length below which what was cut out is a part of the worm: a stroke shortens it less."""
    cut_length_over_last: float = 0.97
    """The same over the length a frame before: a stroke takes off no more in a frame."""
    most_cut_after_fold_widths2: float = 1.4
    """What may be cut off after a fold of a known body, squared widths: more may be an end that
    comes out of it."""
    least_cut_end_widths2: float = 0.5
    """What is cut off an object that goes on there, squared widths, from which an end was cut."""
    loop_hole_widths2: float = 20.0
    """Hole, in squared widths, that is a loop's, not a bubble's."""
    sought_again_frames: int = 4
    """How often a body that was lost in a fold is sought where it was last told."""
    coil_margin_px: int = 24
    """How much about a coil is kept for a later frame to look at."""
    body_model: BodyModelSettings = field(default_factory=BodyModelSettings)
    contour: ContourMidlineSettings = field(default_factory=ContourMidlineSettings)
    refine: RefineSettings = field(default_factory=RefineSettings)
    propagation: PropagationSettings = field(default_factory=PropagationSettings)
    doubled: DoubledBodySettings = field(default_factory=DoubledBodySettings)
    residual: BodyResidualSettings = field(default_factory=BodyResidualSettings)
    blobs: BlobSettings = field(default_factory=BlobSettings)
    cutting: DebrisCuttingSettings = field(default_factory=DebrisCuttingSettings)

    def seen_as(self, polarity: Polarity) -> "FollowerSettings":
        """Return the constants for a worm that is darker, or brighter, than the water."""
        bright = polarity is Polarity.BRIGHT
        propagation = replace(self.propagation, darkest_of_marked_are_overlaps=not bright)
        return replace(self, propagation=propagation)
