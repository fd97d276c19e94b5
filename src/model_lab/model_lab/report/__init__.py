"""The report of a diagnosis: one HTML page that needs nothing else."""

from model_lab.report.page import write_report

__all__ = ["write_report"]
