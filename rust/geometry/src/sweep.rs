//! Free travel of a part along a joint.
