"""Reports of a diagnosis and of a learned curve: HTML pages that need nothing else."""

from model_lab.report.page import write_learned, write_report

__all__ = ["write_learned", "write_report"]
