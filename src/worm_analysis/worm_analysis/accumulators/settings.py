"""The settings of the sums: what of a trial counts for which number."""

from dataclasses import dataclass

from worm_analysis.events.contact_state import CONTACT_STATE, ContactStateSettings
from worm_analysis.events.excursion_depth import CONTACT_EPISODES, EpisodeSettings


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """How a head's search along the wall is cut up and summed.

    Attributes
    ----------
    contact : ContactStateSettings
        How contact is told.
    episodes : EpisodeSettings
        What is told of contacts and excursions.
    deepest_along_wall_radii : float
        An excursion that is deeper, in R, is not along the wall: its speed is left out.
    least_window_seen : float
        A window of the law of v_b and ψ_b of which less than this part was seen is left out.
    steps_in_limit : float
        Episodes shorter than this many of the head's advances a frame (or pixels) are not all seen.
    noise_in_depth_limit : float
        Excursions that are shallower than so many deviations of the noise are not all seen.
    other_thresholds, release_thresholds : tuple of float
        Over the one that is set: where a contact begins, and where it ends, under the rules that
        are computed beside.
    shortest_episodes_s : tuple of float
        Under these rules, too: shorter episodes are taken into those around them.
    """

    contact: ContactStateSettings = CONTACT_STATE
    episodes: EpisodeSettings = CONTACT_EPISODES
    deepest_along_wall_radii: float = 0.15
    least_window_seen: float = 0.9
    steps_in_limit: float = 1.5
    noise_in_depth_limit: float = 3.0
    other_thresholds: tuple[float, ...] = (0.5, 1.5, 2.0, 3.0)
    release_thresholds: tuple[float, ...] = (1.5, 2.0)
    shortest_episodes_s: tuple[float, ...] = (0.1, 0.2)


SEARCH = SearchSettings()
