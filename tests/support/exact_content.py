"""What results hold, to the last bit, in a form that can be compared."""

from dataclasses import fields, is_dataclass
from enum import Enum

import numpy as np


def content(thing):
    """Return plain tuples that are equal where, and only where, every bit of two results is."""
    if isinstance(thing, Enum):
        return thing.name
    if is_dataclass(thing):
        return tuple((item.name, content(getattr(thing, item.name))) for item in fields(thing))
    if isinstance(thing, np.ndarray):
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, float):
        return float(thing).hex()
    if isinstance(thing, dict):
        return tuple((key, content(value)) for key, value in thing.items())
    if isinstance(thing, (list, tuple)):
        return tuple(content(item) for item in thing)
    return thing
