"""What happens over many frames: contacts, visits of a chamber, attempts at the exit."""

from dataclasses import dataclass
from enum import StrEnum
from math import nan


class EpisodeKind(StrEnum):
    """Whether the head touches the wall during an episode."""

    CONTACT = "contact"
    FREE = "free"


class StrokePhase(StrEnum):
    """Phase of the peristaltic stroke, from the body's length."""

    ELONGATION = "elongation"
    CONTRACTION = "contraction"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Episode:
    """One contact of the head with the wall, or one excursion from it.

    Attributes
    ----------
    chamber : str
        ``chamber_a`` or ``chamber_b``.
    kind : EpisodeKind
        In contact or free.
    start_ns, end_ns : int
        Stamps of its first frame and of the first frame of the next episode (or of its own last
        frame where `complete` is False).
    distance_m : float
        Arc length R·|Δθ_h|: d_c of a contact, d_nc of a free episode.
    delta_r_m : float
        Δr_h = max(R − r_h); NaN for a contact.
    incidence_rad : float
        θ_h^i of a contact, signed, counter-clockwise positive; NaN for a free episode.
    complete : bool
        False where the trial's start or end, a gap, or the exit cut it short (censored). A free
        episode that ends with the head in the exit is complete: the head came down there.
    """

    chamber: str
    kind: EpisodeKind
    start_ns: int
    end_ns: int
    distance_m: float
    delta_r_m: float = nan
    incidence_rad: float = nan
    complete: bool = True


@dataclass(frozen=True, slots=True)
class Visit:
    """One stay of the head in a chamber, from its entry until it finds the exit.

    Attributes
    ----------
    chamber : str
        ``chamber_a`` or ``chamber_b``.
    start_ns, end_ns : int
        Stamps of the entry and of the head's entering the exit (or of the last frame).
    first_contact_ns : int or None
        First contact with the wall; τ_h counts from here.
    theta_h0_rad : float
        θ_h at first contact, in (−π, π]; NaN where the head may have touched elsewhere before.
    tau_h_s : float
        Time from first contact to the head's entering the exit.
    skips : int
        Times that the head passed the exit's arc while out of contact and did not enter.
    complete : bool
        False where the visit's start or end was not seen (censored).
    """

    chamber: str
    start_ns: int
    end_ns: int
    first_contact_ns: int | None = None
    theta_h0_rad: float = nan
    tau_h_s: float = nan
    skips: int = 0
    complete: bool = True


@dataclass(frozen=True, slots=True)
class Attempt:
    """One entry of the head into the exit.

    Attributes
    ----------
    chamber : str
        The chamber whose exit it is.
    start_ns, end_ns : int
        Stamps of the head's entering and of its withdrawal, or of the centroid's entering.
    penetration_m : float
        x_p, how far along x the head got into the passage.
    success : bool
        Whether the centroid entered the passage.
    wall_contact : bool or None
        Whether the head touched the passage's walls; None where it cannot be told.
    stroke_phase : StrokePhase
        Phase of the peristaltic stroke at withdrawal.
    complete : bool
        False where the trial ended, or the head was lost, before it was decided.
    """

    chamber: str
    start_ns: int
    end_ns: int
    penetration_m: float
    success: bool
    wall_contact: bool | None = None
    stroke_phase: StrokePhase = StrokePhase.UNKNOWN
    complete: bool = True


Event = Episode | Visit | Attempt
"""Anything that is announced on `analysis/events` as it closes."""
