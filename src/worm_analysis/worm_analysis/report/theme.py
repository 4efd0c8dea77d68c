"""The look of every figure: one type size, colours that the colour-blind can tell apart, SVG."""

import re
from collections.abc import Mapping
from io import StringIO
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from worm_msgs_py.colours import CENTROID_COLOUR as CENTROID_COLOUR
from worm_msgs_py.colours import HEAD_COLOUR as HEAD_COLOUR
from worm_msgs_py.colours import TAIL_COLOUR as TAIL_COLOUR

COLUMN_IN = 3.4
"""Width of a journal's column."""
PAGE_IN = 7.0
SCALE_ON_SCREEN = 1.4

COLOURS = {"head": HEAD_COLOUR, "centroid": CENTROID_COLOUR, "tail": TAIL_COLOUR}
INK, GREY, SHADE = "#1a1a1a", "#767676", "#E4E4E4"
MODEL_COLOUR = "#CC79A7"
WALK_OF_PAPER: dict[str, Any] = {"color": "#767676", "linestyle": (0, (1, 1.2)), "linewidth": 1.2}
"""The walk with the paper's parameters is dotted and grey: it is no measurement."""
PAPER_STYLE: dict[str, Any] = {"color": GREY, "linestyle": (0, (4, 2)), "linewidth": 1.0}
"""The paper's values are dashed and grey in every figure."""

_STYLE = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same glyphs on every machine
    "mathtext.fontset": "dejavusans",
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "legend.fontsize": 7.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "lines.linewidth": 1.0,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "axes.unicode_minus": True,
    "axes.axisbelow": True,
    "axes.titley": 1.0,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "svg.fonttype": "path",
    "svg.hashsalt": "worm-escape",
    "figure.dpi": 72,
}


def style() -> Any:
    """Return the context in which figures are made and written."""
    return mpl.rc_context(_STYLE)


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure of a fixed size, so that type is the same size in all of them."""
    return Figure(figsize=(width_in, height_in), layout="constrained")


def say_n(axes: Any, text: str, *, x: float = 0.97, y: float = 0.96) -> None:
    """Write what n is into a corner of the axes."""
    axes.text(
        x,
        y,
        text,
        transform=axes.transAxes,
        ha="right" if x > 0.5 else "left",
        va="top" if y > 0.5 else "bottom",
        color=INK,
        fontsize=7.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0},
    )


def drawn_svg(figure: Figure, about: Mapping[str, str]) -> str:
    """Draw a figure, made within `style`, as an SVG document without a ground.

    Parameters
    ----------
    figure : Figure
        It finds its layout here, once for all files: with an engine it would be drawn once more
        for each.
    about : mapping
        What the document says of itself.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        FigureCanvasSVG(figure)
        engine.execute(figure)
        figure.set_layout_engine(None)
    stream = StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, **about}, transparent=True)
    return stream.getvalue()


def on_white(svg: str) -> str:
    """Return an SVG document with a white ground."""
    first, body = svg.split("<defs>", 1)
    return f'{first}<rect width="100%" height="100%" fill="#ffffff"/>\n <defs>{body}'


def for_page(svg: str, figure: Figure, key: str, alt: str) -> str:
    """Return a drawn figure as an SVG element to be put into HTML.

    Parameters
    ----------
    svg : str
        From `drawn_svg`.
    figure : Figure
        The same.
    key : str
        Put before every id: several figures share a page.
    alt : str
        Said by a screen reader instead of the picture; no markup.

    Returns
    -------
    str
        ``<svg …>…</svg>``, without any address; the same bytes for the same figure.
    """
    view_box = re.search(r'viewBox="([^"]+)"', svg)
    body = svg[svg.index(">", svg.index("<svg")) + 1 :]
    assert view_box is not None
    # The document's own style would reach the whole page, the addresses are those of standards.
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, count=1, flags=re.DOTALL)
    body = re.sub(r"<title>.*?</title>", "", body, count=1, flags=re.DOTALL)  # a tip on hovering
    body = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", body, flags=re.DOTALL)
    body = re.sub(r"\n\s*", "\n", body).replace("xlink:href", "href")
    body = re.sub(r'\bid="([^"]+)"', rf'id="{key}-\1"', body)
    body = re.sub(r'href="#([^"]+)"', rf'href="#{key}-\1"', body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{key}-\1)", body)
    width_px = round(figure.get_figwidth() * 96 * SCALE_ON_SCREEN)
    return (
        f'<svg role="img" aria-label="{_attribute(alt)}" viewBox="{view_box[1]}" '
        f'style="width:{width_px}px;stroke-linejoin:round;stroke-linecap:butt">{body.rstrip()}\n'
    )


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
