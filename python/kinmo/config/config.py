"""Configuration of everything that kinmo trains."""

from __future__ import annotations

from dataclasses import dataclass, field

from kinmo.config.motion import AxisConfig, GnnConfig, RankingConfig, RefinementConfig
from kinmo.config.scans import AncshConfig, ScansConfig


@dataclass(frozen=True)
class Config:
    """All settings, by section."""

    gnn: GnnConfig
    """Motion GNN."""
    axis: AxisConfig
    """Axis-selection network."""
    ranking: RankingConfig
    """Ranking networks."""
    ancsh: AncshConfig
    """Networks for scans."""
    scans: ScansConfig = field(default_factory=ScansConfig)
    """Scanning."""
    refinement: RefinementConfig = field(default_factory=RefinementConfig)
    """Refinement and acceptance of joints."""
