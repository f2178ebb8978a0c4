//! The seam to parry: the only file that names its types.
