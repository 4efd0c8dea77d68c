"""The constants of a body's propagation: what it must explain, what it may change."""

from dataclasses import dataclass, field

from worm_tracker.detection.pale_ends import PaleEndSettings
from worm_tracker.midline.body_residual import BodyResidualSettings
from worm_tracker.midline.deformable_fit import BodyFitSettings
from worm_tracker.midline.end_by_flanks import EndByFlanksSettings
from worm_tracker.midline.end_by_signal import EndBySignalSettings
from worm_tracker.midline.end_by_skin import EndBySkinSettings
from worm_tracker.midline.end_marks import EndMarksSettings
from worm_tracker.midline.end_residual import EndResidualSettings
from worm_tracker.midline.hidden_slack import HiddenSlackSettings
from worm_tracker.midline.led_out import LedOutSettings
from worm_tracker.midline.other_ends import OtherEndsSettings
from worm_tracker.midline.other_ways import OtherWaysSettings
from worm_tracker.midline.overlap_darkening import OverlapDarkeningSettings
from worm_tracker.midline.path_following import PathFollowingSettings
from worm_tracker.midline.regrown_ends import RegrownEndsSettings
from worm_tracker.midline.strand_meetings import StrandExchangeSettings
from worm_tracker.midline.strand_shift import StrandShiftSettings
from worm_tracker.midline.traced_body import TracedBodySettings
from worm_tracker.midline.way_by_marks import WayByMarksSettings
from worm_tracker.midline.way_by_widths import WayByWidthsSettings


@dataclass(frozen=True, slots=True)
class PropagationSettings:
    """What a propagated body must explain of the picture, and what it may change."""

    first_expected_agreement: float = 0.95
    """What a body is expected to agree with the picture that touches itself for the first time."""
    expected_agreement_lost_per_frame: float = 0.005
    """What that expectation loses in a frame: a tighter coil is drawn less well."""
    most_agreement_lost_sliding: float = 0.02
    """How much less than expected a slid body may have before others are tried."""
    most_agreement_lost_unsure: float = 0.06
    """The same where a slid body does not explain all: it is followed, but not told."""
    most_agreement_lost_resliding: float = 0.02
    """How much less than the fitted body the one slid from it, below a pixel, may have."""
    end_displacement_cost_per_length: float = 0.3
    """What moving an end by a length takes off a body's score."""
    log_stretch_cost: float = 1.0
    """What a unit of log length takes off it."""
    free_log_stretch: float = 0.05
    """Log of the length over the known one that costs nothing: a worm's own stroke."""
    unexplained_cost_per_width2: float = 0.15
    """What a squared width that is not explained takes off it."""
    end_part_widths: float = 2.0
    """How much of the body an end is that may taper."""
    most_stretches: int = 3
    """How often a bend is laid anew."""
    most_slides_again: int = 4
    least_over_limits_slid_again: float = 1.5
    least_over_limits_of_marked_slid_again: float = 3.0
    """How often a body is slid once more along what was laid anew, and how much it must leave over
    for that, over what may be: of 105 that left more and then explained their picture 95 were
    right, 31 before; of 76 that left less 60, and 52 before (44 films at half their frame rate).
    Of 22 with marks that left more than three times what may be 19 were right, 2 before."""
    most_end_sd_widths: float = 0.35
    most_end_sd_in_darker_overlap_widths: float = 0.42
    """Standard deviation of an end's place from which on it is told as hidden; and where overlaps
    are darker, so that an end that lies elsewhere leaves something over."""
    most_over_limits_of_unsure_end: float = 0.3
    most_end_sd_beside_left_over_widths: float = 0.25
    """What a body with a loop in doubt may leave over, over what may be, while an end is less sure
    than that: the end may lie elsewhere. 10 of 183 such heads were wrong, of others 1 in 1200."""
    most_end_sd_in_doubt_widths: float = 0.25
    """How surely the outline must tell an end of a body with a loop in doubt: 2 of 282 such ends
    were more than a width off, 15 of the next 64."""
    most_log_shortening_per_frame: float = 0.04
    """Log of the last length over that of a body in the next picture whose contour shows it, where
    it lay near itself."""
    most_log_shortening_of_pale: float = 0.14
    """Log of the known length over one that a folded body may have whose pale end is seen."""
    most_log_shortening_of_one_shade: float = 0.25
    """The same of one with an end on it where overlaps are no darker: nine that were shorter were
    all wrong, of 2100 others 46 (twelve films, at three frame rates). Where they are darker 400
    right ones of a worm that contracts were shorter."""
    most_log_shortening_of_open: float = 0.24
    """The same of one that lies open, and was not found by its contour: back over a gap in a film
    a fold was told as an open worm of 0.72 to 0.79 of its length, for certain, in nine pictures."""
    coinciding_ends_widths: float = 0.5
    most_end_sd_of_coinciding_widths: float = 0.2
    """Where both ends lie as near to each other, what is seen of one may be the other: they are
    not told unless both are as sure as that."""
    near_end_widths: float = 1.1
    """How near another part of the body an end lies on it or against it."""
    on_strand_widths: float = 0.9
    """How near to it an end lies on it: a pale one adds too little there to be seen, nor is any
    where overlaps are no darker. Of 27 that lay farther from it, nearer than 1.3, and that the
    picture told to 0.2 widths, one was more than half a width off, of 62 that lay nearer 28."""
    near_crossing_widths: float = 0.6
    """How near to an end two other strands may cross for it to be told: of 39 ends at crossings 27
    were more than a width off, of 4543 on one other strand 12."""
    most_missing_at_end_widths2: float = 0.06
    missing_at_end_widths: float = 2.0
    """What may be missing as near as this to an end that lies on or against the body, squared
    widths: it is little that a tapered end covers."""
    least_end_sd_by_signal_widths: float = 0.3
    """How unsure an end on the body must be for all of the picture about it to be asked: that takes
    15 ms."""
    moved_end_widths: tuple[float, ...] = (1.0, 2.0, -1.0, -2.0)
    """How far an end beside which the picture differs from the body is moved on along its way, or
    back, to see whether it lies there."""
    broad_end_widths: float = 2.0
    least_beside_over_body_level: float = 0.4
    most_beside_end_widths2: float = 0.28
    """What may lie beside the body, by more than a pixel, so near to an end, and at least that part
    as dark as the body: of 111 ends beside which more lay 44 were more than a width off. With what
    is paler, which skins show beside ends that are right, as many of 225."""
    least_way_of_changed_ends_widths: float = 1.5
    """How far an end moves at least where both have changed places."""
    lost_over_limits: float = 6.0
    """How many times what may be left over is left where a body is lost, and others are tried: each
    takes long."""
    most_turn_rad_per_width: float = 2.0
    """Turn over a width beyond which a midline has a kink: half a turn is a body laid double."""
    s_near_end_widths: float = 3.0
    most_s_turn_at_end_rad: float = 0.6
    """How sharp an S a body may make so near an end: of 13 that were folded and made a sharper one
    8 were wrong, of 25 045 others 37."""
    most_s_turn_of_marked_rad: float = 0.6
    s_turn_within_widths: float = 1.5
    """How sharp an S a body with marks may make anywhere, its two bends so near to each other: of
    26 wrong ones of 21,157 (20 films in skins and thin tails) 12 made a sharper one, and 91 of the
    others. Without marks 244 of 20,000 right ones did, and none of four wrong ones; of a real worm
    whose overlaps are not known to be darker ones that are right do, too."""
    kink_cost_per_rad: float = 0.05
    """What a radian more takes off its agreement."""
    length_sd_over_scatter: float = 2.0
    least_length_scatter: float = 0.03
    """How far a folded body's length may be from the known one: that many mean deviations of the
    open body's."""
    length_sd_relative: float = 0.04
    """How far the length of a body that strokes gets from what is expected, in a frame."""
    doubted_over_limits: float = 0.4
    most_over_limits_of_better_way: float = 0.1
    """What a body leaves over, over what may be, from which on one that lies otherwise is looked
    for, and how much of that such a one may leave over."""
    least_more_over_limits_of_marked: float = 0.1
    """How much more a body with marks must leave over than in the picture before, where one that
    lies otherwise was looked for, to look for one again: of 2508 searches where it left less than
    that, in 22 films, one found any, of 2235 others 10; they took a ninth of all slides."""
    open_loop_widths: float = 2.0
    """Breadth of a loop from which on it is open: the strands of a narrower one touch, and may
    cross each other unseen."""
    changed_widths: float = 0.5
    made_by_end_widths: float = 2.0
    """How far a part of a body lies from where it was that lies otherwise, and how near to that an
    end may have made the loop."""
    least_breadth_widths: float = 0.85
    """Breadth of a loop from which on it may be in doubt which way round it is passed. Its strands
    may then lie a width apart: what is told as the width is up to a sixth less than the outline's,
    where flanks are soft."""
    least_ends_kept: float = 0.95
    """How probable it is at least that ends were not taken for each other, for what lies between
    them to be passed as it was."""
    least_told_at_ends: float = 0.08
    """Part of a body's length at either end, beyond loops in doubt, by whose widths its order may
    be told: most of a body that is turned round with a loop tells the wrong one."""
    bend_lost_rad2: float = 0.15
    """How much less straight the other way past a loop may be and still be in doubt: bends are
    measured to so much, less well where marks hide where two strands lie on each other."""
    bend_lost_of_turned_rad2: float = 25.0
    """The same once such a loop was turned round, any other way: of broad ones about half are right
    then, and bends do not tell which. With 1 rad² a loop that was known, and that a hidden end was
    thought to have made, was told the wrong way round in 128 frames of one film."""
    most_frames_followed: int = 3
    """From a picture so many frames of 15 a second ago a body is followed with its ends and loops:
    a few may be missing, or the camera be slow."""
    most_frames_unexplained: int = 5
    """Most pictures in a row that a body may leave unexplained and still be the one followed."""
    tried_again_frames: int = 4
    """How often, after that, other ways are tried in which it may lie."""
    least_gain_of_order_widths2: float = 0.1
    """How much less a body traced anew leaves over with its ends in one order than in the other
    where that tells the order."""
    most_ways_slid: int = 6
    """Of the ways that are two steps from where it lay, how many are looked at closely."""
    most_more_left_by_way_widths2: float = 2.0
    """How much more such a way may leave over, as it is, than the body does: of 580 that left more
    none explained its picture once it was slid, and 1.5 % explained more than the body."""
    most_kink_rad: float = 0.2
    """How much more sharply than the body did such a way may turn, where that is a kink."""
    most_ways_led_out: int = 3
    most_kink_led_out_rad: float = 0.6
    """The same of ways that lead an end to a piece that is left over: an end that comes out makes a
    hairpin sharper than it was followed."""
    most_lost_by_likelier_end_widths2: float = 0.02
    """How much more a body may leave over with an end where its outline is explained best."""
    most_differing_at_seen_end_widths2: float = 0.1
    most_more_differing_at_likelier_end_widths2: float = 0.02
    """How much of a picture may differ from a body near an end that is seen where it lies, and how
    much more with it there: of 96 such ends (22 films) five lay nearer to the true one than before
    and 81 farther off, most of them across a gap that is seen. Where more differs as it is, which a
    real worm's picture does, of 40 ten nearer and 23 farther."""
    least_end_sd_by_outline_widths: float = 0.3
    """How surely an end that its flanks tell is followed to the next picture at most: with 0.1 the
    same were told, but five more of 4000 wrong."""
    sd_of_misfit: float = 1.3
    """By how much less surely an end is placed where its flanks fit nowhere."""
    least_gain_of_other_way_widths2: float = 0.2
    """What another way must explain more to be taken though it leaves something over, too."""
    most_over_limits_alone: float = 0.35
    most_over_limits_of_marked_alone: float = 1.0
    least_frames_explained: int = 10
    most_log_length_explained: float = 0.08
    """In how many pictures in a row a body that was lost must explain all to be known again, and by
    how much its length may differ, in logs, where overlaps are no darker. One with marks need only
    explain its pictures: of 476 in four films with pictures missing 255 were the tenth in a row or
    later, and all were right."""
    least_bend_of_other_way_rad2: float = 1.0
    """What a body that was lost may leave over, over what may be, and how much more any other way
    past its loops must bend, for it to be the only explanation."""
    least_apart_widths: float = 1.25
    """How far its strands lie apart at least where a body that was lost shows all of it: of 48
    bodies more than 1.1 widths apart none was wrong, of 99 less so 74."""
    least_agreement_backwards: float = 0.75
    """What a body that is propagated backwards must have: nothing else supports it."""
    most_agreement_lost_backwards: float = 0.04
    """How much less than expected it may have."""
    most_frames_lost_backwards: int = 12
    """How long, in frames of 15 a second, it is looked for from where it was seen last."""
    most_fits_backwards: int = 12
    """Pictures in which a body may be fitted that does not slide there: many would take long."""
    least_log_odds_of_whole_end: float = 8.0
    """From which on a pale end of a short body is seen whole: its marks say so."""
    most_end_sd_by_marks_widths: float = 0.25
    most_over_limits_by_marks: float = 0.5
    """How surely marks must tell where a pale end lies on the body, and what may be left over, over
    what may be. 0 of 110 such ends lay more than a width off, of others 7 of 15."""
    most_over_limits_of_marked: float = 0.7
    """What a marked body may leave over while an end is less sure than that: it may lie elsewhere.
    10 of 101 such bodies were wrong, of others 1 in 170."""
    most_over_limits_more_by_marks: float = 0.1
    """How much more a body may leave over, over what may be, with a loop passed as marks say."""
    most_speck_widths2: float = 4.0
    """Dirt up to this large shows nothing of a body on it, and is nothing that it leaves over."""
    darkest_of_marked_are_overlaps: bool = True
    """Whether the darkest places of a marked worm are taken for its overlaps until some were
    followed: two layers let through less light than one. Where a worm is seen by the light that it
    scatters, two need not send back more: only those that were followed tell there."""
    pale_ends: PaleEndSettings = field(default_factory=PaleEndSettings)
    """As the detector has them."""
    by_flanks: EndByFlanksSettings = field(default_factory=EndByFlanksSettings)
    by_signal: EndBySignalSettings = field(default_factory=EndBySignalSettings)
    by_skin: EndBySkinSettings = field(default_factory=EndBySkinSettings)
    end_marks: EndMarksSettings = field(default_factory=EndMarksSettings)
    end_residual: EndResidualSettings = field(default_factory=EndResidualSettings)
    overlaps: OverlapDarkeningSettings = field(default_factory=OverlapDarkeningSettings)
    led_out: LedOutSettings = field(default_factory=LedOutSettings)
    other_ends: OtherEndsSettings = field(default_factory=OtherEndsSettings)
    other_ways: OtherWaysSettings = field(default_factory=OtherWaysSettings)
    regrow: RegrownEndsSettings = field(default_factory=RegrownEndsSettings)
    exchange: StrandExchangeSettings = field(default_factory=StrandExchangeSettings)
    doubt: StrandExchangeSettings = field(
        default_factory=lambda: StrandExchangeSettings(most_apart_widths=1.0)
    )
    """Strands may have crossed unseen wherever they touch, not only where they are exchanged."""
    shift: StrandShiftSettings = field(default_factory=StrandShiftSettings)
    marks: WayByMarksSettings = field(default_factory=WayByMarksSettings)
    way_by_widths: WayByWidthsSettings = field(default_factory=WayByWidthsSettings)
    traced: TracedBodySettings = field(default_factory=TracedBodySettings)
    slack: HiddenSlackSettings = field(default_factory=HiddenSlackSettings)
    residual: BodyResidualSettings = field(default_factory=BodyResidualSettings)
    path_following: PathFollowingSettings = field(default_factory=PathFollowingSettings)
    most_over_limits_of_fitted: float = 8.0
    """How many times what may be left over a slid body leaves at most where others are fitted.

    Of 88 bodies of four films that left more no fit explained the picture, of 268 others 41."""
    fit: BodyFitSettings = field(default_factory=BodyFitSettings)
