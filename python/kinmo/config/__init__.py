"""Typed configurations, read from TOML.

`paper` has the sizes of the paper and its released code, `small` those that train on two CPU cores. A user's file has the same
keys, or extends one of these and changes single keys. docs/reference/config.md describes every field. It is generated from the
texts below the fields, by `tests/support/config_page.py`.
"""

from kinmo.config.config import Config, builtin_configs, load_config
from kinmo.config.motion import (
    AxisConfig,
    ContinuedConfig,
    GnnConfig,
    GroupingConfig,
    LimitsConfig,
    PointEncoderConfig,
    RankingConfig,
    RefinementConfig,
)
from kinmo.config.scans import AncshConfig, AncshNetworkName, MeanOver, ScansConfig, SensorConfig
from kinmo.config.training import Precision, TrainingConfig

__all__ = [
    "AncshConfig",
    "AncshNetworkName",
    "AxisConfig",
    "Config",
    "ContinuedConfig",
    "GnnConfig",
    "GroupingConfig",
    "LimitsConfig",
    "MeanOver",
    "PointEncoderConfig",
    "Precision",
    "RankingConfig",
    "RefinementConfig",
    "ScansConfig",
    "SensorConfig",
    "TrainingConfig",
    "builtin_configs",
    "load_config",
]
