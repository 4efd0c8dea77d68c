"""Peaks of histograms."""

import numpy as np
import pytest

from worm_analysis.statistics.histograms import peak_positions


def test_a_peak_lies_between_bins_and_an_end_is_no_peak():
    centres = np.arange(-89.0, 90.0, 2.0)
    rows = np.stack([np.exp(-(((centres - 30.7) / 12) ** 2)), np.arange(90.0)])
    peak, none = peak_positions(rows, centres)
    assert peak == pytest.approx(30.7, abs=0.05)
    assert np.isnan(none)
