"""The `worm` command."""

from worm_bringup.cli.app import main

__all__ = ["main"]
