"""Scoring of URDF files from any tool against PartNet-Mobility (docs/background/metrics.md, "URDF files")."""

from kinmo.evaluation.urdf_scoring.urdf_figures import summarise_urdf_scores, urdf_failures_table, urdf_table
from kinmo.evaluation.urdf_scoring.urdf_folders import find_urdf, score_urdf_folder
from kinmo.evaluation.urdf_scoring.urdf_scores import score_urdf

__all__ = ["find_urdf", "score_urdf", "score_urdf_folder", "summarise_urdf_scores", "urdf_failures_table", "urdf_table"]
