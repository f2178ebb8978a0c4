"""What evaluation leaves in a workspace. Nothing here needs torch."""

SETTINGS = ("parts_given", "hierarchy_given")
"""A folder of tables each."""
PRINTED = ("overview_micro", "angle", "distance")
"""The tables that go to the terminal; all of them are written."""
EXAMPLES = "examples.jsonl"
"""Answers to true joints, for the report's pictures."""
