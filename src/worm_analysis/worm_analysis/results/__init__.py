"""The files of a results directory: schema, writer and reader of each in one module."""

from worm_analysis.results.parquet_table import Columns
from worm_analysis.results.results import Results, read_results
from worm_analysis.results.summary import chamber_of

__all__ = ["Columns", "Results", "chamber_of", "read_results"]
