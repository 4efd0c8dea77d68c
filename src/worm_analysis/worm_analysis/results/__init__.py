"""A results directory as the recorder wrote it: read, checked, in arrays."""

from worm_analysis.results.errors import ReportError
from worm_analysis.results.tables import (
    Columns,
    Floats,
    Results,
    chamber_of,
    read_results,
)

__all__ = ["Columns", "Floats", "ReportError", "Results", "chamber_of", "read_results"]
