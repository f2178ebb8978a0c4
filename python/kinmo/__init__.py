"""Joints for 3D objects: semi-weakly supervised kinematic motion prediction."""

from kinmo._core import __version__

__all__ = ["__version__"]
