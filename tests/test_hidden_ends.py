"""An end under another part of the body is hidden; one beside it, or across it, is not."""

import numpy as np
import pytest
from benchmarks.hidden_ends import hides_end

WIDTH = 10.0


def hairpin(aside, back):
    """Return a body that turns back by so much, at a distance from itself, and tapers."""
    there = np.stack([np.linspace(0.0, 300.0, 150), np.zeros(150)], axis=1)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 30)[1:-1]
    bow = np.stack([300 + aside / 2 * np.cos(turn), aside / 2 * (1 + np.sin(turn))], axis=1)
    back = np.stack([300 - np.linspace(0.0, back, 80), np.full(80, aside)], axis=1)
    line = np.concatenate([there, bow, back])
    along = np.arange(len(line))
    half = WIDTH / 2 * np.minimum(1.0, 0.1 + np.minimum(along, along[::-1]) / 12)
    return line, half


@pytest.mark.parametrize(("aside", "hidden"), [(0.5, True), (6.0, False), (12.0, False)])
def test_an_end_is_hidden_where_it_lies_on_the_body(aside, hidden):
    line, half = hairpin(aside, back=150.0)
    assert hides_end(line, half, WIDTH) is hidden
    assert hides_end(line[::-1], half[::-1], WIDTH) is hidden


def test_a_straight_body_hides_nothing():
    line = np.stack([np.linspace(0.0, 300.0, 100), np.zeros(100)], axis=1)
    assert not hides_end(line, np.full(100, WIDTH / 2), WIDTH)


def test_an_end_that_has_crossed_the_body_is_not_hidden():
    turn = np.linspace(0.0, 2 * np.pi, 120)
    loop = np.stack([80 * np.sin(turn), 80 * (1 - np.cos(turn))], axis=1)
    leg = np.stack([np.linspace(-200.0, 0.0, 100)[:-1], np.zeros(99)], axis=1)
    past = np.stack([np.zeros(30), -np.linspace(1.0, 40.0, 30)], axis=1)
    line = np.concatenate([leg, loop, past])
    assert not hides_end(line, np.full(len(line), WIDTH / 2), WIDTH)
