"""The worm in two dimensions: an active elastic filament with both strokes, in the rig."""

from worm_model.filament.parameters import FilamentParameters
from worm_model.filament.rig import FilamentRig

__all__ = ["FilamentParameters", "FilamentRig"]
