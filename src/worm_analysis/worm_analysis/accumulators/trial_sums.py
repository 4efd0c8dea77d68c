"""All sums of a trial by name, in SI: what its numbers rest on, and what it adds to a pool."""

from dataclasses import dataclass
from math import hypot, isfinite, nan

import numpy as np

from worm_analysis.accumulators.bins import LENGTH_BIN_M
from worm_analysis.accumulators.body_size import BodySums
from worm_analysis.accumulators.exclusions import Exclusions
from worm_analysis.accumulators.passage_sums import PassageSums
from worm_analysis.accumulators.wall_search import WallSearch
from worm_analysis.events.exit_region import sagitta
from worm_analysis.parameters import AnalysisParameters
from worm_analysis.statistics.censored_exponential import next_edge
from worm_msgs_py import Geometry
from worm_msgs_py.arrays import Floats


@dataclass(frozen=True, slots=True)
class ChamberSize:
    """What the sums need of the chamber, NaN where it is not known."""

    radius_m: float = nan
    exit_width_m: float = nan
    depth_m: float = nan
    px_per_m: float = nan

    @classmethod
    def of(cls, geometry: Geometry) -> "ChamberSize":
        """Return that of the first chamber."""
        chamber = geometry.chambers[0]
        return cls(chamber.radius_m, chamber.exit_width_m, geometry.depth_m, chamber.px_per_m)

    @property
    def pixel_m(self) -> float:
        """Size of a pixel; 0 where it is not known."""
        return 1 / self.px_per_m if self.px_per_m > 0 else 0.0


def trial_sums(
    search: WallSearch,
    passages: PassageSums,
    skips: tuple[int, int],
    body: BodySums,
    exclusions: Exclusions,
    rig: ChamberSize | None,
    parameters: AnalysisParameters,
) -> dict[str, Floats]:
    """Return all sums by name; those that need a chamber or an exit that is not there are missing.

    `skips` are those over an exit as wide as W, and over one as wide as w_s.

    The laws of lengths are tested from the limit of resolution on: one and a half of the head's
    advance a frame, or of a pixel. An excursion is deeper than the threshold of contact by
    definition, and counts for Δr_h where the noise cannot be taken for it.
    """
    found = {**body.sums(), **exclusions.sums()}
    if rig is None:
        return found
    search.flush()
    gaps, law, settings = search.gaps, search.contact.law, search.settings
    width_m = parameters.body_width_m or body.median_width()
    threshold_m = parameters.contact_factor * width_m if isfinite(width_m) else 0.0
    limit_m, *limits_m = (
        settings.steps_in_limit * max(lengths.step_m, rig.pixel_m)
        for lengths in (search.episodes.lengths, *search.sensitivity.lengths)
    )
    found |= search.frames.sums() | search.speed_law.sums() | search.collisions.sums()
    found |= search.correlation.sums() | search.sensitivity.sums(limits_m)
    searched_s = search.observed_s + gaps.bridged_s + gaps.missing_s
    for part in ("bridged", "missing", "contact_untold"):
        found[f"search_{part}"] = np.array([[searched_s, getattr(gaps, f"{part}_s")]])
    edge_m = law.edge * threshold_m
    deep_m = (law.touch + settings.noise_in_depth_limit * law.noise) * threshold_m
    depth_limit_m = next_edge(max(rig.pixel_m, threshold_m, edge_m, deep_m), LENGTH_BIN_M)
    found |= search.episodes.sums(limit_m, depth_limit_m)
    found["depth_limit"] = np.array([[1.0, depth_limit_m - edge_m]])
    n = found["d_c"][:, 2].sum()
    found["radius_noise"] = np.array([[n, n * law.noise_above_bins * threshold_m, n * threshold_m]])
    found |= passages.sums(max(sagitta(rig.radius_m, rig.exit_width_m), rig.pixel_m))
    found["pixel"] = np.array([[1.0, rig.pixel_m]])
    found["chamber_radius"] = np.array([[1.0, rig.radius_m]])
    if rig.exit_width_m > 0:
        found |= passages.search_sums()
        found["n_s"] = np.array([[search.observed_s, skips[0]]])
        if isfinite(rig.depth_m):
            found["n_s_over_w_s"] = np.array([[search.observed_s, skips[1]]])
            found["w_s"] = np.array([[1.0, hypot(rig.exit_width_m, rig.depth_m)]])
    return found
