"""What figures show is written under names that a pool's directory is known by."""

import re

from worm_analysis.report.figure_files import write_tables
from worm_analysis.report.panel import Panel
from worm_bringup.outputs.earlier_result import POOLED


def test_a_table_of_a_width_with_a_dot_is_a_file_of_ours(tmp_path):
    table = {"tau_h_s": [1.0, 2.0]}
    shown = Panel("fig-5", "", "", "", "", tables={"W1.999-walk": table, "": table})
    write_tables(shown, tmp_path / "tables")
    names = sorted(path.name for path in (tmp_path / "tables").iterdir())
    assert names == ["fig-5-W1-999-walk.csv", "fig-5.csv"]
    assert all(re.fullmatch(POOLED.files, f"tables/{name}") for name in names)
