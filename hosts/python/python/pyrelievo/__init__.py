"""Brings out the shape of surfaces in pictures, from their normals and depth.

Arrays in, arrays out: rows x columns x channels, float32, linear red, green and blue. Nothing that is given is changed.

>>> import numpy as np
>>> import pyrelievo
>>> y, x = np.mgrid[1:-1:64j, -1:1:64j].astype(np.float32)
>>> z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
>>> normal = np.dstack([x, y, z]) * (z > 0)[..., None]
>>> picture = pyrelievo.enhance(np.dstack([z, z, z]), normal)
>>> bool(picture[32, 32, 0] > z[32, 32])  # convex: brighter
True

Every command of the command line is a function here, with the same settings: ``enhance``, ``relight``, ``shape``,
``hatch`` and ``map``. Each takes arrays, or a frame that ``load`` has made of a file.
"""

import os

from . import _relievo
from ._commands import enhance, hatch, map, process, relight, shape
from ._frame import Finding, Frame, load, normals
from ._recipe import Recipe
from ._relievo import Engine
from ._results import Drawing, Shape

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_relievo.forked)

__all__ = ["Drawing", "Engine", "Finding", "Frame", "Recipe", "Shape", "enhance", "hatch", "load", "map", "normals", "process"]
__all__ += ["relight", "shape"]
