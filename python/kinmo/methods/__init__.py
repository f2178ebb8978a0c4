"""The two methods that predict joints of shapes: the paper's and kinmo's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinmo.core.errors import InputError
from kinmo.learning.model_folder import ModelFolder, trained_or_shipped

if TYPE_CHECKING:
    from kinmo.methods.method import Method

METHOD_MODELS: dict[str, tuple[str, ...]] = {"kinmo": ("grouping", "ranking", "limits"), "paper": ("gnn_fine", "axis")}
"""Models of each method, by the name of the method."""
DEFAULT_METHOD = "kinmo"
"""Method of `kinmo predict` and the Python API."""


def load_trained_or_shipped(name: str, models: ModelFolder, device: str = "auto") -> Method:
    """Load a method as `load_method` does. If none of its networks is in the folder, those that come with kinmo are used."""
    return load_method(name, trained_or_shipped(models, METHOD_MODELS.get(name, ())), device)


def load_method(name: str, models: ModelFolder, device: str = "auto") -> Method:
    """Load a trained method, `kinmo` or `paper`; its networks are read once as a check.

    Raises:
        InputError: There is no such method, or one of its networks is missing or cannot be read.
    """
    method: Method
    if name == "kinmo":
        from kinmo.methods.kinmo.kinmo_method import KinmoMethod

        method = KinmoMethod(models, device)
    elif name == "paper":
        from kinmo.methods.paper.paper_method import PaperMethod

        method = PaperMethod(models, models.config().refinement, device=device)
    else:
        raise InputError("--method", f"expected one of {', '.join(METHOD_MODELS)}, got {name}")
    method.check()
    return method
