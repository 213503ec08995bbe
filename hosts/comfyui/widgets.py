"""Inputs of the nodes, made from the table of settings: kinds, defaults, ranges and tooltips are the module's own."""

from __future__ import annotations

import math
from typing import Any

from pyrelievo._settings import Row, rows

#: Headings of settings that concern files, a camera, or layers that no node has.
LEFT_OUT = ("Inputs", "Output", "Sequence", "Light layers", "Mirrors and lenses", "Height and occlusion")

#: Settings under these headings that concern images too.
KEPT = ("wrap",)


def settings(command: str) -> dict[str, Row]:
    """The settings of a command that a node has, by keyword."""
    return {
        keyword: row
        for keyword, row in rows(command).items()
        # Those whose value is a NAME choose a layer or an object of a file.
        if row.name in KEPT or (row.group not in LEFT_OUT and "NAME" not in row.form)
    }


def step_of(row: Row) -> float:
    """A power of ten: a hundredth of the range or less; of a logarithmic one, at most its lowest value."""
    lowest, highest = row.range
    finest = lowest if row.logarithmic else (highest - lowest) / 100
    return 10.0 ** math.floor(math.log10(finest) + 1e-9)


def tooltip_of(row: Row) -> str:
    """The sentence of a setting, with what its widget does not show."""
    notes = [f"in {row.unit}"] if row.unit else []
    if row.kind == "number" and not has_number(row):
        notes.append(f"{row.range[0]:g} to {row.range[1]:g}" + "".join(f" or {word}" for word in row.words))
        if row.default is None:
            notes.append("empty: as if not given")
    elif row.kind == "text" and row.form and not (is_count(row) or words_of(row)):
        notes.append(row.form + (", several with spaces between" if row.repeatable else ""))
    return row.help.rstrip(".") + (f" ({'; '.join(notes)})." if notes else ".")


def has_number(row: Row) -> bool:
    """Whether every value of a setting is a number. Other numbers may be a word, or absent, and are typed as text."""
    return row.kind == "number" and not row.words and row.default is not None


def is_count(row: Row) -> bool:
    """Whether a text is a whole number, such as a seed."""
    return row.form == "N" and isinstance(row.default, int)


def words_of(row: Row) -> list[str]:
    """The words that a text is mostly one of, as in pen|pencil|lines|DIR; without what else it can be."""
    ways = row.form.split("|")
    words = [way for way in ways if way.islower()]
    return words if len(words) > len(ways) / 2 and len(words) > 1 else []


def widget_of(row: Row) -> tuple[Any, dict[str, Any]]:
    """The type and the options of a widget."""
    options: dict[str, Any] = {"tooltip": tooltip_of(row), "default": row.default}
    lowest, highest = row.range
    if row.kind == "choice":
        return row.words, options
    if row.kind == "switch":
        return "BOOLEAN", options
    if has_number(row) and row.whole:
        return "INT", options | {"min": int(lowest), "max": int(highest), "step": 1}
    if has_number(row):
        options |= {"default": float(row.default), "min": lowest, "max": highest, "step": step_of(row)}
        # Values between the steps can be typed.
        return "FLOAT", options | {"round": False}
    if is_count(row):
        return "INT", options | {"min": 0, "max": 2**31 - 1}
    if words := words_of(row):
        return words, options
    default = "" if row.default is None else str(row.default)
    return "STRING", options | {"default": default, "placeholder": row.form or row.name}


def widgets(command: str) -> dict[str, tuple[Any, dict[str, Any]]]:
    """The widgets of a command by keyword, in the order of its help."""
    return {keyword: widget_of(row) for keyword, row in settings(command).items()}


def given(command: str, values: dict[str, Any]) -> dict[str, Any]:
    """The settings that widgets hold: those that are empty or at their default are not given."""
    found = {}
    for keyword, row in settings(command).items():
        value = values.get(keyword)
        if isinstance(value, str):
            value = value.strip()
            if row.repeatable:
                value = value.split()
        if value not in (None, "", [], widget_of(row)[1]["default"]):
            found[keyword] = value
    return found
