"""Writes python/pyrelievo/__init__.pyi from the settings that the module itself has.

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
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._relievo import Engine

__all__ = {all}

_Floats: TypeAlias = NDArray[np.float32]
_Path: TypeAlias = str | PathLike[str]
# What a setting takes that is neither a switch, a word nor a number: as typed, or as its parts.
_Value: TypeAlias = str | float | bool | Sequence[Any] | Mapping[str, Any]

class Finding(NamedTuple):
    subject: str
    conclusion: str
    evidence: str
    flag: str

class Frame:
    def __init__(
        self,
        color: ArrayLike | None = None,
        normal: ArrayLike | None = None,
        *,
        camera: Mapping[str, Any] | _Path | None = None,
        pixel_aspect: float = 1.0,
        height_scale: float | None = None,
        **layers: Any,
    ) -> None: ...
    @property
    def color(self) -> _Floats | None: ...
    @property
    def normal(self) -> _Floats: ...
    @property
    def depth(self) -> _Floats | None: ...
    @property
    def alpha(self) -> _Floats | None: ...
    @property
    def albedo(self) -> _Floats | None: ...
    @property
    def mask(self) -> NDArray[np.bool_]: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def findings(self) -> list[Finding]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def camera(self) -> str | None: ...
    @property
    def path(self) -> str | None: ...

def load(path: _Path, *, frame: int | None = None, **roles: Any) -> Frame: ...
def normals(
    depth: ArrayLike,
    camera: Mapping[str, Any] | _Path | None = None,
    *,
    depth_kind: str | None = "z",
    pixel_aspect: float = 1.0,
) -> _Floats: ...

class Shape:
    scales: dict[float, Shape]
    choices: dict[str, str]
    def __init__(self, layers: dict[str, _Floats], choices: dict[str, str] | None = None) -> None: ...
    def __getattr__(self, name: str) -> _Floats: ...
    def __iter__(self) -> Iterator[str]: ...
    def __getitem__(self, name: str) -> _Floats: ...
    def __dir__(self) -> list[str]: ...

class Drawing:
    paper: _Floats
    choices: dict[str, str]
    def __init__(self, made: Any, lines: Any) -> None: ...
    def svg(self) -> str: ...
    def __getattr__(self, name: str) -> _Floats: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...

class Recipe:
    command: str
    def __init__(self, command: str, **settings: Any) -> None: ...
    @classmethod
    def read(cls, path: _Path) -> Recipe: ...
    @classmethod
    def parse(cls, text: str) -> Recipe: ...
    @property
    def settings(self) -> list[tuple[str, str]]: ...
    def toml(self) -> str: ...
    def write(self, path: _Path) -> None: ...
    def __call__(
        self,
        *arrays: Any,
        out: _Floats | None = None,
        dtype: Any = None,
        engine: Engine | None = None,
        progress: Callable[[str, float], Any] | None = None,
        **settings: Any,
    ) -> Any: ...

def process(
    pattern: _Path,
    command: str,
    *,
    frames: Any = None,
    engine: Engine | None = None,
    progress: Callable[[int, int], Any] | None = None,
    roles: Mapping[str, Any] | None = None,
    **settings: Any,
) -> Iterator[tuple[int, Any]]: ...
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
