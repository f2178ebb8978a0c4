"""XML files of robots."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path


def numbers(values: Iterable[float]) -> str:
    """Numbers with all digits and without negative zeros, separated by spaces."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def write_xml(root: ET.Element, path: Path) -> Path:
    """Write an element as an indented file, and return its path."""
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
    return path
