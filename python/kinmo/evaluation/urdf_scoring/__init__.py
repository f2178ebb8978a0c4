"""Anybody's URDF files, scored against PartNet-Mobility (docs/metrics.md, "URDF files")."""

from kinmo.evaluation.urdf_scoring.urdf_folders import FilesReport, find_urdf, score_files, summarise
from kinmo.evaluation.urdf_scoring.urdf_scores import ObjectScore, PartScore, score_urdf
from kinmo.evaluation.urdf_scoring.urdf_tables import failures_table, files_table

__all__ = [
    "FilesReport",
    "ObjectScore",
    "PartScore",
    "failures_table",
    "files_table",
    "find_urdf",
    "score_files",
    "score_urdf",
    "summarise",
]
