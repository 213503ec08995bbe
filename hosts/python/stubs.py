"""Writes python/pyrelievo/__init__.pyi from the settings that the module itself has; what takes none is typed where it is.

python stubs.py            write it
python stubs.py --check    fail if it is another
"""

import sys
from pathlib import Path

import pyrelievo
from pyrelievo._commands import FRAME, LEADING, OPTIONS, SENTENCES, is_own
from pyrelievo._frame import LAYERS
from pyrelievo._relievo import commands
from pyrelievo._settings import rows

STUB = Path(__file__).parent / "python/pyrelievo/__init__.pyi"

HEAD = '''\
# Written by stubs.py from the table of settings. Not to be edited.
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._commands import process as process
from ._frame import Finding as Finding, Frame as Frame, load as load, normals as normals
from ._recipe import Recipe as Recipe
from ._relievo import Engine as Engine
from ._results import Drawing as Drawing, Shape as Shape

__all__ = {all}

_Floats: TypeAlias = NDArray[np.float32]
_Path: TypeAlias = str | PathLike[str]
# What a setting takes that is neither a switch, a word nor a number: as typed, or as its parts.
_Value: TypeAlias = str | float | bool | Sequence[Any] | Mapping[str, Any]

'''

RETURNS = {
    "enhance": "NDArray[Any]",
    "relight": "NDArray[Any]",
    "shape": "Shape",
    "hatch": "Drawing",
    "map": "dict[str, _Floats]",
}

#: Types of what is no setting of a command.
OTHERS = dict.fromkeys(LAYERS, "ArrayLike | str | None") | {
    "camera": "Mapping[str, Any] | _Path | None",
    "pixel_aspect": "float",
    "height_scale": "float | None",
    "out": "_Floats | None",
    "dtype": "Any",
    "engine": "Engine | None",
    "progress": "Callable[[str, float], Any] | None",
}


def type_of(row):
    """The type of a setting."""
    words = ", ".join(f'"{word}"' for word in row.words)
    match row.kind:
        case "switch":
            return "bool"
        case "choice":
            boolean = "bool | " if "on" in row.words else ""
            return f"{boolean}Literal[{words}] | Sequence[str] | None"
        case "number":
            # Some take several, as scales do.
            several = "float | Sequence[float]"
            return f"{several} | Literal[{words}] | None" if words else f"{several} | None"
        case _:
            return "_Value | None"


def function(command):
    """The declaration of a function."""
    leading = LEADING[command]
    is_optional = " | None = None" if leading[0] == "normal" else ""
    lines = [f"    {leading[0]}: ArrayLike | Frame | _Path{is_optional},"]
    lines += [f"    {name}: ArrayLike | None = None," for name in leading[1:]]
    lines.append("    *,")
    own = {name: row for name, row in rows(command).items() if is_own(row)}
    names = [name for name in (*LAYERS, *FRAME, *OPTIONS) if name not in leading]
    for name in names:
        default = "1.0" if name == "pixel_aspect" else "None"
        lines.append(f"    {name}: {OTHERS.get(name, 'str | None')} = {default},")
    for name, row in own.items():
        if name not in names and name not in leading:
            default = f'"{row.default}"' if isinstance(row.default, str) else row.default
            lines.append(f"    {name}: {type_of(row)} = {default},")
    return "\n".join([f"def {command}(", *lines, f") -> {RETURNS[command]}: ..."]) + "\n"


def main():
    assert set(SENTENCES) == set(RETURNS) == set(commands())
    head = HEAD.replace("{all}", "[" + ", ".join(f'"{name}"' for name in pyrelievo.__all__) + "]")
    text = head + "".join(function(command) for command in commands())
    if "--check" not in sys.argv:
        STUB.write_text(text)
    elif STUB.read_text() != text:
        sys.exit(f"{STUB} is not what the settings say: run python stubs.py")


main()
