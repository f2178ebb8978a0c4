"""XML from unknown sources: UTF-8 of limited size, without document type and entities."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from kinmo.core.errors import InputError

MAX_XML_BYTES = 8 << 20
"""Largest robot file. A tree of elements takes some forty times the bytes of its text."""

_PADDING = b"\0\t\n\r "
"""Bytes before and after the text that robot simulators tolerate."""


def check_plain_xml(data: bytes, path: Path) -> None:
    """Raise InputError for XML with a document type or entities, which could expand to any size, and for UTF-16."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data or b"\0" in data:
        raise InputError(path, "expected XML in UTF-8 without document type or entities")


def parse_xml(data: bytes, path: Path) -> ET.Element:
    """The root element of a file. Raises InputError for anything but plain XML.

    Args:
        data: content of the file.
        path: the file, for messages.
    """
    data = data.strip(_PADDING)
    check_plain_xml(data, path)
    try:
        return ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise InputError(path, f"expected XML: {error}") from None
