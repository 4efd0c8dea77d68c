"""What it takes for a number of several simulated trials to agree with the truth."""

import numpy as np


def assert_unbiased(answers, truth, most_error):
    """Hold a number's values and 95 % intervals in eight trials against what it is.

    Parameters
    ----------
    answers : sequence of Quantity
        The number in each trial.
    truth : float
    most_error : float
        The mean's standard error at most, as a part of the truth: else the test tells nothing.
    """
    inside = [answer.low <= truth <= answer.high for answer in answers]
    # At 95 % each, fewer than six of eight happens once in two hundred times.
    assert sum(inside) >= 6, [(a.low, a.value, a.high) for a in answers]
    values = np.array([answer.value for answer in answers])
    error = values.std(ddof=1) / np.sqrt(len(values))
    assert abs(values.mean() - truth) < 2.5 * error
    assert error < most_error * truth
