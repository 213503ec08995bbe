"""Results: the layers of a shape, and drawings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _relievo
from ._frame import Floats


def views(made: _relievo.Made) -> Iterator[tuple[str, float | None, Floats]]:
    """The layers of what was made, as views on one buffer: name, further scale, rows x columns or x components."""
    names, buffer = made.layers()
    at = 0
    for name, sigma, count in names:
        planes = buffer[at : at + count]
        yield name, sigma, planes[0] if count == 1 else planes.transpose(1, 2, 0)
        at += count


class Shape:
    """The shape of a surface: layers as attributes, views on one buffer.

    Scalars are rows x columns, vectors rows x columns x components. ``kappa`` is the mapped curvature, -1..1, positive
    where convex; ``direction`` that of the stronger principal curvature. ``scales`` holds the curvature at further
    scales, by their sigma in pixels. ``choices`` are the settings that were chosen by themselves.
    """

    scales: dict[float, Shape]
    choices: dict[str, str]

    def __init__(self, layers: dict[str, Floats], choices: dict[str, str] | None = None):
        self._layers = layers
        self.scales = {}
        self.choices = choices or {}

    @classmethod
    def _of(cls, made: _relievo.Made) -> Shape:
        shape = cls({}, dict(made.choices))
        for name, sigma, view in views(made):
            own = shape if sigma is None else shape.scales.setdefault(sigma, cls({}))
            own._layers[name] = view
        return shape

    def __getattr__(self, name: str) -> Floats:
        try:
            return self.__dict__["_layers"][name]
        except KeyError:
            known = ", ".join(self.__dict__.get("_layers", {}))
            raise AttributeError(f"this shape has no {name}; it has {known}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._layers]

    def __iter__(self) -> Iterator[str]:
        return iter(self._layers)

    def __getitem__(self, name: str) -> Floats:
        return self._layers[name]

    def __repr__(self) -> str:
        return f"<pyrelievo.Shape of {', '.join(self._layers)}>"

    def _repr_png_(self) -> bytes | None:
        kappa = self._layers.get("kappa")
        if kappa is None:
            return None
        grey = np.repeat(0.5 + 0.5 * kappa[..., None], 3, axis=2)
        return _relievo.png(np.ascontiguousarray(grey, np.float32), False)


class Drawing:
    """A drawing: its paper as an array, its strokes as layers, and as an SVG.

    ``paper`` is rows x columns, 1 for bare paper and 0 for ink; NumPy takes a drawing for that array. ``strokes``,
    ``contours`` and ``interior`` are coverage by ink, where there are any, and ``tone`` what was asked of the strokes.
    """

    choices: dict[str, str]

    def __init__(self, made: _relievo.Made, lines: Any):
        self.paper: Floats = made.picture()[..., 0]
        self._layers = {name: view for name, _, view in views(made)}
        self._lines = lines
        self.choices = dict(made.choices)

    def svg(self) -> str:
        """The drawing in lines, as the text of an SVG: drawn anew, since lines differ from pixels."""
        return self._lines().svg

    def __getattr__(self, name: str) -> Floats:
        try:
            return self.__dict__["_layers"][name]
        except KeyError:
            raise AttributeError(f"this drawing has no {name}") from None

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.paper, dtype=dtype, copy=True if copy is None else copy)

    def __repr__(self) -> str:
        rows, columns = self.paper.shape
        return f"<pyrelievo.Drawing, {columns} x {rows}>"

    def _repr_png_(self) -> bytes:
        paper = np.repeat(self.paper[..., None], 3, axis=2)
        return _relievo.png(np.ascontiguousarray(paper), True)
