"""Anybody's URDF files, scored against PartNet-Mobility (docs/metrics.md, "URDF files")."""

from kinmo.evaluation.urdf_files.files import FilesReport, find_urdf, score_files, summarise
from kinmo.evaluation.urdf_files.scoring import ObjectScore, PartScore, score_urdf

__all__ = ["FilesReport", "ObjectScore", "PartScore", "find_urdf", "score_files", "score_urdf", "summarise"]
