"""`sums.parquet` gives back what was written, the same bytes for the same sums, or one line."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from worm_analysis.results.sums import SCHEMA, read_sums, write_sums
from worm_msgs_py.errors import ReportError

rows = arrays(
    np.float64,
    st.tuples(st.integers(1, 5), st.integers(1, 4)),
    elements=st.floats(-1e9, 1e9),
)
tables = st.dictionaries(st.sampled_from(("d_c", "v_w", "d_c_at_contact_factor_0.15")), rows)


@given(tables)
def test_sums_come_back_as_they_were(tmp_path_factory, sums):
    folder = tmp_path_factory.mktemp("sums")
    write_sums(folder / "one.parquet", sums)
    write_sums(folder / "two.parquet", sums)
    back = read_sums(folder / "one.parquet")
    assert back.keys() == sums.keys()
    for name, values in sums.items():
        np.testing.assert_array_equal(back[name], values)
    assert (folder / "one.parquet").read_bytes() == (folder / "two.parquet").read_bytes()


def test_results_without_sums_are_refused_with_a_remedy(tmp_path):
    with pytest.raises(ReportError, match=r"sums.parquet: not there: run `worm replay`"):
        read_sums(tmp_path / "sums.parquet")


@pytest.mark.parametrize(
    ("names", "values"),
    [
        pytest.param(["d_c"], [[float("nan")]], id="no number"),
        pytest.param(["d_c"], [[None]], id="null in a sum"),
        pytest.param(["d_c"], [None], id="no sum"),
        pytest.param(["<b>"], [[1.0]], id="no name"),
        pytest.param(["d_c", "d_c"], [[1.0], [1.0, 2.0]], id="blocks of two lengths"),
    ],
)
def test_what_is_no_sum_is_refused_in_one_line(tmp_path, names, values):
    path = tmp_path / "sums.parquet"
    pq.write_table(pa.table([names, [0] * len(names), values], schema=SCHEMA), path)
    with pytest.raises(ReportError, match=r"run `worm replay`") as caught:
        read_sums(path)
    assert "\n" not in str(caught.value)
