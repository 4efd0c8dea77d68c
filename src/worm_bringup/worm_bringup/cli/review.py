"""`worm review`: look through a trial, and set right which end of the worm is the head."""

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from worm_bringup.cli.number_options import number
from worm_bringup.cli.replay_again import replay_command
from worm_bringup.cli.terminal import say
from worm_monitor.access import Access
from worm_monitor.review.pictures import find_pictures
from worm_monitor.review.trial import read_reviewed_trial
from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import PAGE_PORT
from worm_msgs_py.ros.network import LOOPBACK
from worm_msgs_py.ros.running import stop_on_signals

if TYPE_CHECKING:
    from worm_monitor.review.review_server import ReviewServer


def review(
    results: Annotated[Path, typer.Argument(help="A directory made by worm replay or worm live.")],
    bag: Annotated[
        Path | None,
        typer.Option(
            help="The bag that was replayed or recorded; without it the one that the results name "
            "is looked for around here and around them, or their own bag has the pictures."
        ),
    ] = None,
    port: Annotated[
        int, number(PAGE_PORT, help="Port of the page; 0: 8642, or a free one if that is taken.")
    ] = 0,
    host: Annotated[
        str,
        typer.Option(
            help="Address to serve it on, such as 0.0.0.0 for other machines, which then need the "
            "token that is printed with the address; otherwise this machine alone can look."
        ),
    ] = LOOPBACK,
) -> None:
    """Look through a trial on a page, and exchange head and tail where the tracker mistook them.

    Each frame with what was found in it, the whole course, the events, and the stretches at which
    a person should look. What is exchanged is kept in corrections.json in the results at once; the
    page gives the command of the replay that makes tables and numbers anew. Ctrl-C ends it.
    """
    from worm_monitor.review.review_server import ReviewServer  # a web server: slow to import

    trial = read_reviewed_trial(results)
    pictures = find_pictures(trial, bag)
    command = replay_command(results, trial.results.provenance, pictures.bag)
    access = Access.to(host, port)
    asyncio.run(_serve(ReviewServer(pictures, access, command.line, command.stands_for)))


async def _serve(server: "ReviewServer") -> None:
    with stop_on_signals() as stop:
        try:
            await server.site.listen()
        except OSError as error:
            access = server.site.access
            raise BadInput(
                f"the page cannot listen on {access.host} port {access.port}: {error.strerror}; "
                "give another --port"
            ) from None
        try:
            say(f"Review: {server.site.access.address}")
            await asyncio.to_thread(stop.wait)
        finally:
            await server.close()
