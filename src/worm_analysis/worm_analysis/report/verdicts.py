"""Says in words whether a number agrees with the paper, and whether a law fits what was measured.

The words are HTML of ours; empty where there is nothing to be said.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, log
from statistics import NormalDist

from worm_analysis.pooling import Pool
from worm_analysis.pooling.pool import WITHIN_TRIALS
from worm_analysis.report.numbers import LEAST_IN_PLAIN, plain, with_interval
from worm_analysis.report.panel import number_of
from worm_analysis.report.symbols import html_symbol
from worm_analysis.summary.quantities import DEFINITIONS
from worm_msgs_py import Quantity

HEADLINE = ("d_c", "d_nc", "v_w", "t_per", "success")
"""The five numbers that open a report: each has a value in the paper's text."""
REJECTED = 0.01
"""A law is rejected where chance alone gives a fit as bad less often: a page has many tests."""
WIDER = NormalDist().inv_cdf(1 - REJECTED / 2) / NormalDist().inv_cdf(0.975)
"""What a 95 % interval is widened by, to be one of the level at which a law is rejected."""
AS_IN_THE_PAPER = "agrees with the paper"

Numbers = Callable[[str], Quantity]
"""From a name to the number."""


@dataclass(frozen=True, slots=True)
class Headline:
    """One of the numbers that open a report.

    Attributes
    ----------
    quantity : Quantity
        The number.
    n : str
        What it rests on, counted.
    verdict : str
        Beside the paper, HTML.
    wrong : str
        Why its law does not hold; HTML, empty where it does or that is not known.
    """

    quantity: Quantity
    n: str
    verdict: str
    wrong: str


def headlines(
    quantity: Numbers, of_trials: Callable[[str], str] = lambda name: ""
) -> list[Headline]:
    """Return the five numbers with their verdicts.

    Parameters
    ----------
    quantity : callable
        From a name to the number.
    of_trials : callable
        From a name to what is wrong with a pool of trials; see `trials_differ`.
    """
    found = []
    for name in HEADLINE:
        number = quantity(name)
        law = (
            not_one_exponential(quantity)
            if name == "t_per"
            else not_exponential(number, quantity(f"{name}_exponential_p"))
        )
        n = number_of(number.n, DEFINITIONS[name].items)
        wrong = ". ".join(filter(None, (law, of_trials(name))))
        found.append(Headline(number, n, beside_paper(number), wrong))
    return found


def trials_differ(pool: Pool, name: str) -> str:
    """Return that trials differ by more than their intervals allow, where the pool's ignores it."""
    if pool.numbers[name].by != WITHIN_TRIALS:
        return ""
    p = pool.same_in_all_p(name)
    if not p < REJECTED:
        return ""
    return (
        f"The trials differ by more than their own intervals allow (Cochran’s test, "
        f"{chance(p)}): the interval is too narrow"
    )


def beside_paper(quantity: Quantity) -> str:
    """Return whether the paper's value lies in a number's interval, and else how far away it is."""
    if quantity.value is None:
        return "no verdict"
    if quantity.paper is None:
        return "the paper gives no number"
    if quantity.low is None and quantity.high is None:
        return "no verdict: it has no interval"
    low, high = (-inf if quantity.low is None else quantity.low), quantity.high
    if low <= quantity.paper <= (inf if high is None else high):
        return AS_IN_THE_PAPER
    side = "above" if quantity.value > quantity.paper else "below"
    if not quantity.paper or quantity.value / quantity.paper <= 0:
        return f"{side} the paper’s"
    return f"{side} the paper’s, {plain(quantity.value / quantity.paper, 2)} times as large"


def chance(p: float) -> str:
    """Write how probable a fit as bad would be by chance; none is told to be 0."""
    return (
        f"<i>p</i> = {plain(p, 2)}"
        if p >= LEAST_IN_PLAIN
        else f"<i>p</i> &lt; {LEAST_IN_PLAIN:.4f}"
    )


def not_exponential(quantity: Quantity, p: Quantity) -> str:
    """Return that an exponential law with a number as its mean is rejected, if it is."""
    if quantity.value is None or p.value is None or p.value >= REJECTED:
        return ""
    return (
        f"{html_symbol(quantity.name)}: an exponential law is rejected (Anderson and Darling’s "
        f"test, {chance(p.value)}, <i>n</i> = {p.n}); its mean says less than it seems to"
    )


def not_one_exponential(quantity: Numbers) -> str:
    """Return that C_θ does not decay as the exponential that is fitted to it, if it does not."""
    ratio, fitted, fall = map(quantity, ("t_1e_over_t_per", "t_per", "t_1e"))
    t_per = html_symbol("t_per")
    said = []
    if _rejects(ratio, 1.0):
        said.append(
            f"the fit decays in {with_interval(fitted)} s but the curve falls to 1/e at "
            f"{with_interval(fall)} s, a ratio of {with_interval(ratio)}"
        )
    for name, where in (
        ("c_theta_start", f"up to 0.5 {t_per}"),
        ("c_theta_tail", f"from 1.5 {t_per} on"),
    ):
        excess = quantity(name)
        if _rejects(excess, 0.0):
            said.append(f"{where} the curve less the fit is {with_interval(excess)}")
    return "<i>C</i><sub>θ</sub> is not one exponential: " + "; ".join(said) if said else ""


def _rejects(quantity: Quantity, number: float) -> bool:
    """Whether a number lies outside of the 99 % interval; on a log scale, where it is not 0."""
    if quantity.value is None or quantity.low is None or quantity.high is None:
        return False
    ends = [quantity.value, quantity.low, quantity.high, number]
    if number:
        ends = [log(end) for end in ends]
    middle, low, high, number = ends
    return not middle - WIDER * (middle - low) <= number <= middle + WIDER * (high - middle)


def against_paper(r: Quantity, *, expected: bool) -> str:
    """Return that a correlation is not as the paper finds it: positive where expected, else none.

    Where the interval leaves that open nothing is said.

    Parameters
    ----------
    r : Quantity
        Pearson's correlation.
    expected : bool
        Whether the paper finds one.
    """
    if r.value is None or r.low is None or r.high is None:
        return ""
    told = f"<i>r</i> = {with_interval(r)}"
    if expected and r.high <= 0:
        return f"The paper finds that it grows; here it does not, {told}"
    if not expected and not r.low <= 0 <= r.high:
        return f"The paper finds no correlation; here there is one, {told}"
    return ""
