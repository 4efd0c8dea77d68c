"""The truth table has the tracker's columns, signs and units."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from worm_model.simulator.rig import Body, Rig, truth_of, write_truth

RIG = Rig(centre_px=(500.2, 520.9), exit_rad=0.7)


def body_at(theta: float, turn: float, r_mm: float = 9.9) -> Body:
    """A straight worm of 4 mm whose head points along the wall, counter-clockwise for turn > 0."""
    head = r_mm * np.exp(1j * theta)
    tail = head - 4.0 * np.exp(1j * (theta + turn))
    points = [RIG.chambers[0].to_pixels(z.real * 1e-3, z.imag * 1e-3) for z in (head, tail)]
    return Body.along(points, 16.0)


@pytest.mark.parametrize("turn", [0.6, -0.6])
def test_psi_is_positive_where_the_head_leads_counter_clockwise(turn):
    truth = truth_of(RIG, body_at(1.0, turn), 0, 0)
    assert truth.psi_b_deg == pytest.approx(np.degrees(turn), abs=0.1)
    assert truth.psi_h_deg == pytest.approx(np.degrees(turn), abs=0.1)


def test_numbers_are_millimetres_in_the_chambers_frame():
    truth = truth_of(RIG, body_at(-0.4, 0.6), 5, 123)
    assert (truth.frame, truth.stamp_ns, truth.where) == (5, 123, "chamber_a")
    assert truth.r_h_mm == pytest.approx(9.9)
    assert truth.theta_h_rad == pytest.approx(-0.4)
    assert (truth.head_x_mm, truth.head_y_mm) == pytest.approx(
        (9.9 * np.cos(-0.4), 9.9 * np.sin(-0.4))
    )
    assert truth.length_mm == pytest.approx(4.0)
    assert truth.width_mm == pytest.approx(0.4, abs=0.005)


@pytest.mark.parametrize(("gap_mm", "contact"), [(0.119, True), (0.121, False)])
def test_contact_is_three_tenths_of_a_width(gap_mm, contact):
    assert truth_of(RIG, body_at(2.0, 0.3, 10.0 - gap_mm), 0, 0).contact is contact


def test_contact_is_unknown_in_the_passage():
    truth = truth_of(RIG, body_at(0.0, 0.0, 11.0), 0, 0)
    assert truth.where == "passage"
    assert truth.contact is None


def test_theta_is_unwrapped_in_the_table(tmp_path):
    rows = [truth_of(RIG, body_at(0.5 * k, 0.5), k, k) for k in range(20)]
    write_truth(rows, tmp_path / "truth.parquet")
    table = pq.read_table(tmp_path / "truth.parquet").to_pydict()
    assert table["theta_h_rad"] == pytest.approx(0.5 * np.arange(20))
    assert len(table["midline_u_px"][0]) == 50
    assert table["midline_u_px"][3][0] == table["head_u_px"][3]
    assert [p.name for p in tmp_path.iterdir()] == ["truth.parquet"]


def test_a_film_without_frames_gives_an_empty_table(tmp_path):
    write_truth([], tmp_path / "truth.parquet")
    assert pq.read_table(tmp_path / "truth.parquet").num_rows == 0
