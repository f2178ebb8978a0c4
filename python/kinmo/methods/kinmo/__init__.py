"""The `kinmo` method: candidate joints of all parts are ranked by networks, and moving parts are grouped into bodies."""
