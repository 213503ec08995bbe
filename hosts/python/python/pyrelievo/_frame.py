"""Frames: a surface seen from one viewpoint, and the picture of it."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _relievo
from ._settings import INPUTS, rows, typed

#: Layers that arrays can be given for.
LAYERS = ("color", "normal", "depth", "height", "position", "mask", "object", "coverage", "occlusion", "importance", "albedo")

Floats: TypeAlias = NDArray[np.float32]
Path: TypeAlias = str | os.PathLike[str]


class Finding(NamedTuple):
    """A conclusion about an input."""

    subject: str
    conclusion: str
    evidence: str
    flag: str


def array_of(name: str, layer: Any) -> np.ndarray:
    """A layer as an array of a type that is taken as it is: what NumPy can view is not copied."""
    if hasattr(layer, "detach"):  # a tensor that remembers how it was computed
        layer = layer.detach()
    if not hasattr(layer, "__array__") and hasattr(layer, "__dlpack__"):
        array = np.from_dlpack(layer)
    else:
        array = np.asarray(layer)
    if array.dtype == object:
        raise TypeError(f"{name} is no array of numbers; give one of rows, columns and channels")
    if array.dtype.kind == "f" and array.dtype.itemsize > 4:
        return array.astype(np.float32)
    return array if array.dtype.isnative else array.astype(array.dtype.newbyteorder("="))


def is_named(layer: Any) -> bool:
    """Whether a layer is a name or a path, or several, rather than an array."""
    parts = layer if isinstance(layer, (list, tuple)) else [layer]
    return any(isinstance(part, (str, os.PathLike)) for part in parts)


def refuse_numbers(objects: np.ndarray) -> None:
    """Refuses the numbers of objects, which would be taken for shares."""
    if objects.dtype.kind in "iu" or (objects >= 2).any():
        raise ValueError(
            "object holds numbers of objects; give where the chosen ones are, as ids == 7, or shares of 0..1"
        )


def camera_text(camera: Any) -> str | None:
    """A camera as the text of a camera file."""
    if camera is None:
        return None
    if isinstance(camera, Mapping):
        plain = {name: np.asarray(value).tolist() for name, value in camera.items()}
        return json.dumps(plain)
    if not isinstance(camera, (str, os.PathLike)):
        raise TypeError(f"camera is {camera!r}; give a dict, or the path of a file")
    with open(camera, encoding="utf-8") as file:
        return file.read()


class Frame:
    """A surface seen from one viewpoint, and the picture of it, of arrays.

    ``color`` is rows x columns x 3, linear red, green and blue; a fourth channel is alpha, by which colours are
    multiplied. Integers count as sRGB. ``normal`` is rows x columns x 3 in view space: x right, y up, z toward the
    viewer; integers count as 0..1. ``depth`` lies along the view axis. ``mask`` tells where and how far a picture is
    changed, 0..1, ``object`` how much of each pixel the chosen objects cover, as ``ids == 7``, and ``coverage`` where a
    surface is, above one half. ``camera`` is a dict or a file, as for ``relievo --camera``. Other settings tell how layers
    are read, as on the command line: ``normal_space="world"``, ``normal_flip="y"``, ``depth_kind="white-far"``. Nothing is
    guessed where there are normals.

    Without them normals are those of the surface that ``depth`` shows, or ``position`` with a camera, or ``height``, seen
    from above: ``height_scale`` pixels high at 1. As on the command line, depth from 0 to 1 of no ``depth_kind`` is taken
    for white-near, and a camera that is missing for one 44 degrees across. What is guessed so is in ``warnings``, and
    every function that uses the frame warns of it.
    """

    def __init__(
        self,
        color: ArrayLike | None = None,
        normal: ArrayLike | None = None,
        *,
        camera: Mapping[str, Any] | Path | None = None,
        pixel_aspect: float = 1.0,
        height_scale: float | None = None,
        **layers: Any,
    ):
        layers |= {"color": color, "normal": normal}
        given = {name: layers.pop(name, None) for name in LAYERS}
        for name, layer in given.items():
            if is_named(layer):
                raise ValueError(f"{name} is {layer!r}; give an array, or load() a file with its layers")
        arrays = {name: array_of(name, layer) for name, layer in given.items() if layer is not None}
        if "object" in arrays:
            refuse_numbers(arrays["object"])
        self._frame = _relievo.Frame.of_arrays(
            arrays, roles_of(layers), camera_text(camera), pixel_aspect, height_scale
        )

    @classmethod
    def _of(cls, inner: _relievo.Frame) -> Frame:
        frame = cls.__new__(cls)
        frame._frame = inner
        return frame

    @property
    def color(self) -> Floats | None:
        """The picture, rows x columns x 3, linear; None without one."""
        return self._frame.layer("color")

    @property
    def normal(self) -> Floats:
        """Unit normals in view space, rows x columns x 3; 0 where no surface is."""
        return self._frame.layer("normal")

    @property
    def depth(self) -> Floats | None:
        """Depth, rows x columns, larger farther away; None without it."""
        return _plane(self._frame.layer("depth"))

    @property
    def alpha(self) -> Floats | None:
        """Coverage of the picture, rows x columns, 0..1; None without it."""
        return _plane(self._frame.layer("alpha"))

    @property
    def albedo(self) -> Floats | None:
        """The surface's own colour, rows x columns x 3, linear; None without it."""
        return self._frame.layer("albedo")

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Where a surface is: rows x columns of bool."""
        return self._frame.layer("mask")[..., 0] > 0.5

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self._frame.shape

    @property
    def findings(self) -> list[Finding]:
        """What was concluded about the layers of a file, and why."""
        return [Finding(*finding) for finding in self._frame.findings]

    @property
    def warnings(self) -> list[str]:
        """Warnings about the layers; functions that use them warn likewise."""
        return self._frame.warnings

    @property
    def camera(self) -> str | None:
        """The camera in words; None if none is known."""
        return self._frame.camera

    @property
    def path(self) -> str | None:
        """The file that it is read from; None for arrays."""
        path = self._frame.path
        return None if path is None else os.fspath(path)

    def __repr__(self) -> str:
        rows, columns = self.shape
        return f"<pyrelievo.Frame {self.path or 'of arrays'}, {columns} x {rows}>"

    def _repr_png_(self) -> bytes:
        shown = self.color
        if shown is None:
            return _relievo.png((0.5 * self.normal + 0.5).astype(np.float32), False)
        return _relievo.png(shown, True)


def _plane(array: Floats | None) -> Floats | None:
    return None if array is None else array[..., 0]


def roles_of(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Settings that tell how layers are read, as names and texts."""
    known = rows("shape")
    for keyword in values:
        if keyword not in known or known[keyword].group != INPUTS:
            raise TypeError(f"a frame has no {keyword!r}; see help(pyrelievo.Frame) and help(pyrelievo.load)")
    return typed("shape", values)


def load(path: Path, *, frame: int | None = None, **roles: Any) -> Frame:
    """A frame of a file: an EXR with the layers of a render, or a photo with its normal map.

    Layers are found as the command line finds them; settings of its group *Inputs* tell otherwise:
    ``normal="normals.png"``, ``depth="none"``, ``normal_space="world"``. ``frame`` is a number that goes where the
    names of a sequence have #### or %04d. Files are read when a layer or a result is asked for, as far as it needs them.
    """
    path = os.fspath(path)
    if frame is None and not os.path.exists(path):
        # Said at once, as open() would.
        with open(path, "rb"):
            pass
    return Frame._of(_relievo.Frame.of_file(path, roles_of(roles), frame))


def normals(
    depth: ArrayLike,
    camera: Mapping[str, Any] | Path | None = None,
    *,
    depth_kind: str | None = "z",
    pixel_aspect: float = 1.0,
) -> Floats:
    """Normals of the surface that a depth shows: rows x columns x 3, view space, 0 where no surface is.

    ``depth`` is rows x columns of distances, along the view axis unless ``depth_kind`` tells otherwise, and 0 where
    nothing is. ``camera`` is a dict or a file, as for Frame; one that is missing is guessed, with a warning. Normals
    follow the steps between neighbouring pixels, so they show the facets of a mesh; a step that leads to another surface
    is no slope.

    >>> pyrelievo.normals(np.full((4, 4), 2.0), {"focal_px": 100})[1, 1].tolist()
    [0.0, 0.0, 1.0]
    """
    frame = Frame(depth=depth, camera=camera, depth_kind=depth_kind, pixel_aspect=pixel_aspect)
    for said in frame.warnings:
        warnings.warn(said, stacklevel=2)
    return frame.normal
