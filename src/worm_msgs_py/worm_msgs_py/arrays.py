"""What arrays hold, by name."""

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
"""Grey levels, or a mask (0 or 255), shape (h, w)."""
Mask = NDArray[np.bool_]
Integers = NDArray[np.int64]
Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Complex = NDArray[np.complex128]
"""Of the picture: points as numbers u + iv."""
