"""Write the positions of a result as a CSV table, as any other tracker would.

python docs/examples/tracks_to_csv.py RESULTS TABLE.csv
"""

import sys
from pathlib import Path

import pyarrow.csv
import pyarrow.parquet as pq

COLUMNS = ["stamp_ns", "head_x_mm", "head_y_mm", "centroid_x_mm", "centroid_y_mm", "width_mm"]


def main(results: str, table: str) -> None:
    """Write time, head, centroid and width of each frame; an empty cell is not known."""
    tracks = pq.read_table(Path(results) / "tracks.parquet", columns=COLUMNS)
    Path(table).parent.mkdir(parents=True, exist_ok=True)
    pyarrow.csv.write_csv(tracks, table)


if __name__ == "__main__":
    main(*sys.argv[1:])
