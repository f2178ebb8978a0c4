"""Scoring of URDF files from any tool against PartNet-Mobility (docs/background/metrics.md, "URDF files")."""

from kinmo.evaluation.urdf_scoring.urdf_folders import UrdfReport, find_urdf, score_urdf_folder, summarise_urdf_scores
from kinmo.evaluation.urdf_scoring.urdf_scores import ObjectScore, PartScore, score_urdf
from kinmo.evaluation.urdf_scoring.urdf_tables import urdf_failures_table, urdf_table

__all__ = [
    "ObjectScore",
    "PartScore",
    "UrdfReport",
    "find_urdf",
    "score_urdf",
    "score_urdf_folder",
    "summarise_urdf_scores",
    "urdf_failures_table",
    "urdf_table",
]
