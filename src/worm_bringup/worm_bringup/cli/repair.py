"""`worm repair`: what can still be read of a damaged bag goes into a whole one."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from worm_bringup.cli import options
from worm_msgs_py.text import printable
from worm_tracker.sources.bags.bag_repair import name_of_repaired, repair_bag
from worm_tracker.sources.bags.scan.decompression import MAX_CHUNK_MIB
from worm_tracker.sources.bags.scan.scan_result import Lost

_MOST_LOSSES_SHOWN = 20


def repair(
    bag: Annotated[
        Path,
        typer.Argument(
            help="A rosbag2 directory, with or without its metadata.yaml, an .mcap or a .db3 file."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            help="The .mcap file to make; otherwise BAG_repaired.mcap, beside the bag. Nothing is "
            "ever overwritten."
        ),
    ] = None,
    max_chunk_mib: options.MaxChunkMib = None,
) -> None:
    """Save what can be read of a cut or damaged bag, and say what is lost.

    Goes over what is damaged and on behind it. What it makes is a whole bag, which `worm replay`
    and `ros2 bag` read; the damaged one is left as it is.
    """
    repaired = name_of_repaired(bag) if out is None else out
    survey = repair_bag(bag, repaired, max_chunk_mib or MAX_CHUNK_MIB)
    for topic, count in sorted(survey.messages.items(), key=lambda item: item[0].name):
        typer.echo(f"{count} messages of {printable(topic.name)} ({printable(topic.type)})")
    for line in lines_of(survey.losses):
        typer.echo(line)
    typer.echo(f"{survey.saved} messages saved in {printable(repaired)}")


def lines_of(losses: Sequence[Lost]) -> list[str]:
    """Return what to say of what was lost; the last line counts."""
    lines = [f"damaged: {printable(loss.why)}" for loss in losses[:_MOST_LOSSES_SHOWN]]
    if len(losses) > _MOST_LOSSES_SHOWN:
        lines.append(f"damaged: {len(losses) - _MOST_LOSSES_SHOWN} places more")
    known = sum(loss.messages or 0 for loss in losses)
    unknown = sum(loss.messages is None for loss in losses)
    if known or unknown:
        more = f", and an unknown number in {unknown} places" if unknown else ""
        lines.append(f"lost: {known} messages{more}")
    elif not losses:
        lines.append("nothing is damaged")
    return lines
