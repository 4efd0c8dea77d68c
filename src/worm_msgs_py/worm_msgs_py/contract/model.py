"""What the model says: its numbers beside the measured ones, and its forecast of the search."""

from dataclasses import dataclass
from math import nan

from worm_msgs_py.contract.frames import Where


@dataclass(frozen=True, slots=True)
class ModelQuantity:
    """One quantity, measured and modelled.

    Attributes
    ----------
    name : str
        The symbol in ASCII (``tau_h``, ``n_s``, ``d_c``, ``t_per``, ``tau_escape``).
    unit : str
        SI unit: ``s``, ``m``, ``1``.
    measured, measured_low, measured_high : float
        The trial's own value and its 95 % interval; NaN where it cannot be had.
    modelled, modelled_low, modelled_high : float
        The model's value, and the 95 % interval that the measured numbers which it rests on give
        it; NaN where the value is exact for the parameters given.
    """

    name: str
    unit: str
    measured: float = nan
    measured_low: float = nan
    measured_high: float = nan
    modelled: float = nan
    modelled_low: float = nan
    modelled_high: float = nan


@dataclass(frozen=True, slots=True)
class NeededReversal:
    """The reversal that the boundary walk needs to give one observation, all else as it is.

    Attributes
    ----------
    rule : str
        What the reversal counts: ``per_cycle``, ``per_phase`` (probabilities), ``rate`` (1/s).
    speed : str
        The speed of the walk: ``v_w``, or ``v_b``, the mean tangential speed.
    observation : str
        What is to be given: ``reversal`` (counted), ``t_per``, ``tau_h``, ``n_s``.
    value : float
        The reversal that gives the observed value; NaN where none does.
    low, high : float
        The reversals that give the observation's 95 % interval; NaN where none gives any value in
        it.
    is_measured : bool
        Whether the observation is the trial's own, or the paper's.
    """

    rule: str
    speed: str
    observation: str
    value: float = nan
    low: float = nan
    high: float = nan
    is_measured: bool = True


@dataclass(frozen=True, slots=True)
class Comparison:
    """Model against measurement, with the parameters that the model was run with.

    Attributes
    ----------
    stamp_ns : int
        Stamp of the last frame that it rests on.
    parameters : tuple of (str, float)
        Name (with its unit) and value of each parameter of the model.
    quantities : tuple of ModelQuantity
        What is compared.
    needs : tuple of NeededReversal
        Which observations one reversal can hold together.
    scores : tuple of (str, float)
        How good the forecasts were, by name (with its unit); empty before the first passage.
    """

    stamp_ns: int
    parameters: tuple[tuple[str, float], ...] = ()
    quantities: tuple[ModelQuantity, ...] = ()
    needs: tuple[NeededReversal, ...] = ()
    scores: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Forecast:
    """When the head will find the exit, given where it is and which way it goes now.

    Attributes
    ----------
    frame, stamp_ns : int
        The frame that it is made at.
    where : Where
        The part of the rig that holds the head; only in a chamber is there a forecast.
    theta_h_rad : float
        θ_h, from the middle of the exit.
    direction : float
        1 counter-clockwise, −1 clockwise; NaN where it cannot be told: then there is no forecast.
    contact : float
        1 sliding, 0 hopping.
    median_s, low_s, high_s : float
        Median, 5 % and 95 % quantile of the time until the head finds the exit; NaN where there is
        no forecast.
    within_10_s, within_30_s, within_60_s : float
        Probability that it finds it within that time.
    measured : tuple of (str, bool)
        Of each parameter of the walk, whether it is the trial's own or the paper's.
    """

    frame: int
    stamp_ns: int
    where: Where = Where.UNKNOWN
    theta_h_rad: float = nan
    direction: float = nan
    contact: float = nan
    median_s: float = nan
    low_s: float = nan
    high_s: float = nan
    within_10_s: float = nan
    within_30_s: float = nan
    within_60_s: float = nan
    measured: tuple[tuple[str, bool], ...] = ()
