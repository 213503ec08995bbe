"""Settings: Python values as the texts that recipes and the command line have."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from keyword import iskeyword
from typing import Any

from . import _relievo

#: A flag of the command line within a sentence.
FLAG = re.compile(r"--([a-z][a-z-]*)")

#: The heading of settings that tell how layers are read.
INPUTS = "Inputs"

#: Headings of settings that concern files which are written, and sequences.
OF_FILES = ("Output", "Sequence")

#: Settings under these headings that matter without files.
KEPT = ("write", "dpi", "sample-frames")

#: Settings that concern files alone.
IDLE = ("bits",)


class Row:
    """One setting of a command."""

    def __init__(self, row: dict[str, Any]):
        self.name: str = row["name"]
        # As with_ for with.
        self.keyword = self.name.replace("-", "_") + "_" * iskeyword(self.name)
        self.group: str = row["group"]
        self.help: str = FLAG.sub(lambda flag: flag[1].replace("-", "_"), row["help"])
        self.common: bool = row["common"]
        self.unit: str = row["unit"]
        self.kind: str = row["kind"]
        self.words: list[str] = row.get("words", [])
        self.form: str = row.get("form", "")
        self.repeatable: bool = row.get("repeatable", False)
        # Of a number: the ends of its control, and how that moves between them.
        self.range: tuple[float, float] = row.get("range", (0, 0))
        self.logarithmic: bool = row.get("logarithmic", False)
        self.whole: bool = row.get("whole", False)
        self.default = False if self.kind == "switch" else parsed(row["default"])

    def texts(self, value: Any) -> list[str]:
        """The texts of a value: several for a list of a setting that may be given several times."""
        if isinstance(value, Mapping):
            return [f"{name}={text(one)}" for name, one in value.items()]
        if self.repeatable and isinstance(value, list):
            return [text(one) for one in value]
        if isinstance(value, bool) and "on" in self.words:
            return ["on" if value else "off"]
        return [text(value)]


def parsed(default: str | None) -> Any:
    """A default as a number where it is one."""
    for number in (int, float):
        try:
            return number(default)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            pass
    return default


def text(value: Any) -> str:
    """A value as it would be typed."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:
        return text(value.item())
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (Sequence, Iterable)):
        return ",".join(text(one) for one in value)
    raise TypeError(f"{value!r} is no value of a setting; give a number, a text, or several of them")


_rows: dict[str, dict[str, Row]] = {}


def rows(command: str) -> dict[str, Row]:
    """The settings of a command by keyword, in the order of its help."""
    if command not in _rows:
        _rows[command] = _read_rows(command)
    return _rows[command]


def _read_rows(command: str) -> dict[str, Row]:
    found = (Row(row) for row in _relievo.settings(command))
    return {row.keyword: row for row in found if row.name in KEPT or not (row.group in OF_FILES or row.name in IDLE)}


def typed(command: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Settings that are given, as names and texts."""
    known = rows(command)
    pairs = []
    for keyword, value in values.items():
        row = known.get(keyword.replace("-", "_"))
        if row is None:
            raise TypeError(f"{command}() got an unexpected keyword argument '{keyword}'")
        if value is not None:
            pairs += [(row.name, one) for one in row.texts(value)]
    return pairs
