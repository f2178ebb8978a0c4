"""Typed configurations, read from TOML.

`paper` has the sizes of the paper and its released code, `small` those that train on two CPU cores. A user's file has the same
keys, or extends one of these and changes single keys. docs/reference/config.md describes every field; it is generated from the
texts below the fields.
"""

from kinmo.config.bounds import Share
from kinmo.config.config import Config
from kinmo.config.config_files import builtin_configs, load_config
from kinmo.config.motion import (
    AxisConfig,
    ContinuedConfig,
    GnnConfig,
    PointEncoderConfig,
    RankingConfig,
    RefinementConfig,
)
from kinmo.config.scans import AncshConfig, AncshNetworkName, AncshWeights, MeanOver, ScansConfig, SensorConfig
from kinmo.config.training import Precision, TrainingConfig

__all__ = [
    "AncshConfig",
    "AncshNetworkName",
    "AncshWeights",
    "AxisConfig",
    "Config",
    "ContinuedConfig",
    "GnnConfig",
    "MeanOver",
    "PointEncoderConfig",
    "Precision",
    "RankingConfig",
    "RefinementConfig",
    "ScansConfig",
    "SensorConfig",
    "Share",
    "TrainingConfig",
    "builtin_configs",
    "load_config",
]
