"""From shapes as they were read to what training reads of them."""

from kinmo.prepare.folder import Entry, PrepareReport, prepare_folder
from kinmo.prepare.shape import prepare_shape

__all__ = ["Entry", "PrepareReport", "prepare_folder", "prepare_shape"]
