"""The commands as functions. Their settings, defaults and sentences come from the program's own table."""

from __future__ import annotations

import os
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping
from inspect import Parameter, Signature
from typing import Any

import numpy as np

from . import _relievo
from ._frame import LAYERS, Frame, Path, is_named, load
from ._results import Drawing, Shape, views
from ._settings import INPUTS, Row, rows, typed

#: What a frame of arrays takes beside its layers.
FRAME = ("camera", "pixel_aspect", "height_scale", "normal_space", "normal_encoding", "normal_flip", "depth_kind")

#: What every function takes beside layers and settings.
OPTIONS = ("out", "dtype", "engine", "progress")

#: The leading arguments of each command.
LEADING = {command: ("normal",) for command in _relievo.commands()} | {"enhance": ("color", "normal")}

#: What each makes: the first words of its help.
SENTENCES = {
    "enhance": (
        "Brings out the shape in the shading that a picture already has.",
        "The picture, rows x columns x 3, float32, linear.",
        ">>> picture = pyrelievo.enhance(color, normal, scaling=0.8)",
    ),
    "relight": (
        "Lights the surface anew: lights, an environment or a lit sphere, bent and scaled by curvature.",
        "The picture, rows x columns x 3, float32, linear.",
        '>>> picture = pyrelievo.relight(normal, light=(135, 40), method="warp")',
    ),
    "shape": (
        "Finds the shape of the surface: silhouettes, creases, curvature and its directions.",
        "A Shape, whose layers are attributes.",
        ">>> kappa = pyrelievo.shape(normal, scale=4).kappa",
    ),
    "hatch": (
        "Draws the surface: strokes along its curvature, lines along its edges.",
        "A Drawing, which NumPy takes for an array of rows x columns, 1 for paper and 0 for ink.",
        '>>> drawing = pyrelievo.hatch(normal, color=color, style="pencil")',
    ),
    "map": (
        "Makes grey maps for textures: curvature, its convex and concave parts, edges, height, occlusion.",
        "Maps by name, rows x columns, float32.",
        '>>> maps = pyrelievo.map(normal, map=("curvature", "height"))',
    ),
}

_default: _relievo.Engine | None = None


def default_engine() -> _relievo.Engine:
    """The engine of calls that name none, made with the first of them."""
    global _default
    if _default is None:
        _default = _relievo.Engine()
    return _default


def frame_of(
    command: str, leading: tuple[Any, ...], given: Mapping[str, Any]
) -> tuple[Frame, dict[str, Any]]:
    """The frame that a command is called with, and the settings that are left."""
    names = LEADING[command]
    if len(leading) > len(names):
        raise TypeError(f"{command}() takes {len(names)} positional arguments, and {len(leading)} were given")
    layers = {name: layer for name, layer in zip(names, leading, strict=False) if layer is not None}
    settings: dict[str, Any] = {}
    for name, value in given.items():
        is_layer = name in LAYERS and not is_named(value)
        if value is not None:
            (layers if is_layer or name in FRAME else settings)[name] = value
    if not layers:
        wanted = f"{' and '.join(names)}, depth or height, or a frame"
        raise TypeError(f"{command}() is called without anything; give {wanted}")
    first = next(iter(layers.values()))
    if isinstance(first, (Frame, str, os.PathLike)):
        if len(layers) > 1:
            more = list(layers)[1]
            raise TypeError(f"{more} goes with arrays; a frame or a file has its own, as load() reads them")
        return (first if isinstance(first, Frame) else load(first)), settings
    return Frame(**layers), settings


def finished(command: str, make: Callable[..., _relievo.Made], out: Any, dtype: Any = None) -> Any:
    """What a function gives, of what was made."""
    is_shown = dtype is not None and np.dtype(dtype) == np.uint8
    if dtype is not None and not is_shown and np.dtype(dtype) != np.float32:
        raise ValueError(f"dtype is {np.dtype(dtype)}; give float32, or uint8 for what a PNG holds")
    if is_shown and command not in ("enhance", "relight", "hatch"):
        raise TypeError("dtype is that of a picture, of enhance, relight or hatch")
    made = make("shown" if is_shown else "planes")
    for said in made.warnings:
        warnings.warn(said, stacklevel=3)
    if out is not None and command not in ("enhance", "relight"):
        raise TypeError("out takes a picture, of enhance or relight")
    if is_shown:
        pixels = made.shown()
        return pixels if (pixels[..., 3] < 255).any() else np.ascontiguousarray(pixels[..., :3])
    match command:
        case "shape":
            return Shape._of(made)
        case "hatch":
            return Drawing(made, lambda: make("lines"))
        case "map":
            return {name: view for name, _, view in views(made) if name in made.map_names}
        case _:
            return made.picture(out)


def _function(command: str) -> Callable[..., Any]:
    own = {name: row for name, row in rows(command).items() if is_own(row)}
    defaults = {name: row.default for name, row in own.items()}

    def function(*leading: Any, **given: Any) -> Any:
        bound = signature.bind_partial(*leading, **given).arguments
        options = {name: bound.pop(name, None) for name in OPTIONS}
        given = {name: value for name, value in bound.items() if name not in LEADING[command]}
        leading = tuple(bound[name] for name in LEADING[command] if name in bound)
        given = {n: v for n, v in given.items() if not (n in defaults and _equal(v, defaults[n]))}
        frame, settings = frame_of(command, leading, given)
        texts = typed(command, settings)
        engine = options["engine"] or default_engine()

        def make(form: str = "planes") -> _relievo.Made:
            return engine.run(command, texts, frame._frame, form, options["progress"])

        return finished(command, make, options["out"], options["dtype"])

    signature = signature_of(command)
    function.__name__ = function.__qualname__ = command
    function.__module__ = "pyrelievo"
    function.__doc__ = doc_of(command)
    function.__signature__ = signature  # type: ignore[attr-defined]
    return function


def _equal(value: Any, default: Any) -> bool:
    """Whether a value is the default, as it would be typed."""
    return isinstance(value, (str, int, float, bool)) and type(value) is type(default) and value == default


def is_own(row: Row) -> bool:
    """Whether a setting is one of the function, rather than of the frame or a sequence."""
    return row.name in ("wrap", "object") or row.group not in (INPUTS, "Sequence")


def signature_of(command: str) -> Signature:
    """The arguments of a command: layers, then its settings."""
    names = LEADING[command]
    given = [
        Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=Parameter.empty if name == "color" else None)
        for name in names
    ]
    layers = [name for name in LAYERS if name not in names]
    defaults: dict[str, Any] = dict.fromkeys([*layers, *FRAME])
    defaults["pixel_aspect"] = 1.0
    defaults |= dict.fromkeys(OPTIONS)
    for name, row in rows(command).items():
        if name not in defaults and name not in names and is_own(row):
            defaults[name] = row.default
    own = [Parameter(name, Parameter.KEYWORD_ONLY, default=value) for name, value in defaults.items()]
    return Signature([*given, *own])


def doc_of(command: str) -> str:
    """The help of a command."""
    sentence, returns, example = SENTENCES[command]
    names = " and ".join(LEADING[command])
    lines = [
        sentence,
        "",
        f"Takes {names} as arrays of rows x columns x 3, with further layers by name; or, in the place of arrays, a Frame",
        "or the path of a file. Without normal, depth or height show the surface. See Frame for layers and what they hold.",
        "",
        f"    {example}",
        "",
        f"Returns: {returns}",
        "",
        "Raises ValueError for settings and arrays that cannot be used, OSError for files.",
        "",
        "out: a float32 array that a picture is written to. dtype: uint8 for a picture as a PNG holds it, in sRGB, with",
        "exposure and highlights; float32 otherwise. engine: an Engine, for its threads, device or memory.",
        "progress: called with the name of each stage and the share of the work that is done.",
    ]
    groups = list(dict.fromkeys(row.group for row in rows(command).values()))
    group = None
    for row in sorted(rows(command).values(), key=lambda row: groups.index(row.group)):
        if not is_own(row):
            continue
        if row.group != group:
            group = row.group
            lines += ["", group, "-" * len(group)]
        words = f" One of {', '.join(row.words)}." if row.kind == "choice" else ""
        unit = f" [{row.unit}]" if row.unit else ""
        entry = f"{row.keyword}{unit}: {row.help.rstrip('.')}.{words}"
        lines += textwrap.wrap(entry, 110, subsequent_indent="    ")
    return "\n".join(lines) + "\n"


enhance = _function("enhance")
relight = _function("relight")
shape = _function("shape")
hatch = _function("hatch")
map = _function("map")


def process(
    pattern: Path,
    command: str,
    *,
    frames: Any = None,
    engine: _relievo.Engine | None = None,
    progress: Callable[[int, int], Any] | None = None,
    roles: Mapping[str, Any] | None = None,
    **settings: Any,
) -> Iterator[tuple[int, Any]]:
    """What a command makes of the frames of a sequence, one after another: pairs of a number and the result.

    ``pattern`` has #### or %04d where numbers go; ``frames`` are those on disk, unless they are given. Everything that
    is chosen automatically is chosen once for all frames, from five of them. ``roles`` are settings for ``load``, in
    whose names numbers go too. ``progress`` is called with how many frames are done, and of how many. Drawings are
    drawn anew for each frame; the command line moves their strokes with the surface.
    """
    pattern = os.fspath(pattern)
    if frames is None:
        frames = _relievo.frames_on_disk(pattern)
        if frames is None:
            raise ValueError(f"{pattern} has no #### or %04d for the numbers of frames")
        if not frames:
            raise FileNotFoundError(f"{pattern}: no frame of this name is there")
    frames = [int(number) for number in frames]
    own = engine or default_engine()
    given = typed(command, {**(roles or {}), **settings})
    given = own.choose(command, given, pattern, frames)
    for done, number in enumerate(frames):
        frame = _relievo.Frame.of_file(pattern, [], number)

        def make(form: str = "planes", frame: _relievo.Frame = frame) -> _relievo.Made:
            return own.run(command, given, frame, form, None)

        yield number, finished(command, make, None)
        if progress is not None:
            progress(done + 1, len(frames))
