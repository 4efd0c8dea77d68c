"""The report: figures and numbers beside the paper's, of one trial or of several pooled."""

from worm_analysis.report.pooled_report import write_pooled_report
from worm_analysis.report.report import write_report

__all__ = ["write_pooled_report", "write_report"]
