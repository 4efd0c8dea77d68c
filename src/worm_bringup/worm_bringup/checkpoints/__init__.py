"""Checkpoints: what a replay that was stopped goes on from, to the same bytes."""

from worm_bringup.checkpoints.checkpointing import Checkpoints, progress_of
from worm_bringup.checkpoints.folder import CheckpointFolder, Manifest

__all__ = ["CheckpointFolder", "Checkpoints", "Manifest", "progress_of"]
