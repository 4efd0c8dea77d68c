"""`worm evaluate`: how far a trial's tracks are from its truth."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from worm_bringup.cli import options
from worm_bringup.cli.number_options import number
from worm_bringup.cli.terminal import Terminal
from worm_model.evaluation import (
    Evaluation,
    Figure,
    evaluate_tracks,
    read_tracks,
    read_truth,
)
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY
from worm_msgs_py.errors import BadInput, EvaluationError
from worm_msgs_py.limits import Limit


def evaluate(
    tracks: Annotated[Path, typer.Argument(help="Results directory, or its tracks.parquet.")],
    truth: Annotated[Path, typer.Argument(help="The truth's table, such as BAG_truth.parquet.")],
    certain: Annotated[
        float,
        number(Limit(0.5, 1.0), help="Head certainty that counts as certain."),
    ] = SURE_HEAD_CERTAINTY,
    as_json: options.AsJson = False,
) -> None:
    """Compare tracks with the truth: tips, midline, head or tail, contact, calibration.

    Try it: `worm simulate --out crawl`, `worm replay crawl --out results`, then `worm evaluate
    results crawl_truth.parquet`.
    """
    try:
        result = evaluate_tracks(read_tracks(tracks), read_truth(truth), certain=certain)
    except EvaluationError as error:
        raise BadInput(str(error)) from None
    if as_json:
        typer.echo(json.dumps(result.document(), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        Terminal().print(_figures_table(result))


def _figures_table(result: Evaluation) -> Table:
    title = (
        f"{result.frames_in_common} frames in common by {result.joined_by}"
        f" ({result.frames_of_tracks} of the tracks, {result.frames_of_truth} of the truth)"
    )
    table = Table("figure", "value", "n", title=title)
    for figure in result.figures:
        table.add_row(figure.name.replace("_", " "), _value_with_unit(figure), str(figure.n))
    return table


def _value_with_unit(figure: Figure) -> str:
    if figure.value is None:
        return figure.why
    if not figure.unit:
        return f"{figure.value:.4f}"
    return f"{figure.value:.4g} {figure.unit}"
