"""Options of `worm live` and `worm replay` about the page that shows the trial."""

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import typer

from worm_bringup.cli.number_options import number
from worm_bringup.cli.usage_errors import refuse_without
from worm_bringup.graph.monitor_process import Monitor
from worm_msgs_py.limits import PAGE_PORT

_MONITOR = "The page that shows the trial"


@dataclass(frozen=True)
class MonitorOptions:
    """Whether a page shows the trial, and who can look at it."""

    monitor: Annotated[
        bool,
        typer.Option(
            "--monitor",
            help="Show picture, plots and numbers on a page, whose address is printed.",
            rich_help_panel=_MONITOR,
        ),
    ] = False
    monitor_port: Annotated[
        int | None,
        number(
            PAGE_PORT,
            help="Its port; 8642, or a free one where that is taken.",
            rich_help_panel=_MONITOR,
        ),
    ] = None
    monitor_host: Annotated[
        str,
        typer.Option(
            help="Address to serve it on, such as 0.0.0.0 for other machines, which then need the "
            "token that is printed with the address; otherwise this machine alone can look.",
            rich_help_panel=_MONITOR,
        ),
    ] = ""

    def page(
        self, rig: Mapping[str, Any], trial: str, player: Mapping[str, Any] | None = None
    ) -> Monitor | None:
        """Return the page that is asked for, if one is.

        Parameters
        ----------
        rig : mapping
            What rig files say of it.
        trial : str
            What the trial is called.
        player : mapping, optional
            Parameters of the node that plays a recording; none where the trial is live.

        Raises
        ------
        BadInput
            Options without the page that they are about.
        """
        for option in ("monitor_port", "monitor_host"):
            refuse_without(asdict(self), option, "monitor", "is the page's")
        if not self.monitor:
            return None
        parameters = {"trial": trial, **rig, "replay": player is not None}
        if player is not None and not player["loop"]:  # a loop's stamps are not those of its bag
            parameters["player"] = json.dumps(player)
        if self.monitor_port is not None:
            parameters["port"] = self.monitor_port
        if self.monitor_host:
            parameters["host"] = self.monitor_host
        return Monitor(parameters, _say_at_once)


def _say_at_once(line: str) -> None:
    print(f"worm: {line}", file=sys.stderr, flush=True)
