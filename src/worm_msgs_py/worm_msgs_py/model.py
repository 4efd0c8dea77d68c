"""The model's numbers beside the measured ones."""

from dataclasses import dataclass

NAN = float("nan")


@dataclass(frozen=True, slots=True)
class ModelQuantity:
    """One quantity, measured and modelled.

    Attributes
    ----------
    name : str
        The symbol in ASCII (``tau_h``, ``n_s``, ``d_c``, ``t_per``).
    unit : str
        SI unit: ``s``, ``m``, ``1``.
    measured, measured_low, measured_high : float
        The trial's own value and its 95 % interval; NaN where it cannot be had.
    modelled, modelled_low, modelled_high : float
        The model's value and the 95 % interval of its Monte Carlo mean.
    """

    name: str
    unit: str
    measured: float = NAN
    measured_low: float = NAN
    measured_high: float = NAN
    modelled: float = NAN
    modelled_low: float = NAN
    modelled_high: float = NAN


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
    """

    stamp_ns: int
    parameters: tuple[tuple[str, float], ...] = ()
    quantities: tuple[ModelQuantity, ...] = ()
