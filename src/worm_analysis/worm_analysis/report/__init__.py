"""The report: a trial's figures and numbers beside the paper's, in one HTML file."""

from worm_analysis.report.errors import ReportError
from worm_analysis.report.report import write_report

__all__ = ["ReportError", "write_report"]
