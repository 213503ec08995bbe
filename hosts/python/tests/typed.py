"""What an editor knows: checked by pyright, not run."""

from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import pyrelievo

normal = np.zeros((4, 4, 3), np.float32)
shape = pyrelievo.shape(normal, scale=[2, 8], solver="explicit")
assert_type(shape.kappa, NDArray[np.float32])
assert_type(pyrelievo.map(normal, map=("curvature", "height")), dict[str, NDArray[np.float32]])
assert_type(pyrelievo.hatch("render.exr", interior=True).svg(), str)
pyrelievo.relight(normal, light=(135, 40), method="warp", mask=normal[..., 0])
pyrelievo.enhance(pyrelievo.load("render.exr", normal="N"), curvature_gain="auto", scaling=1.5)
assert_type(pyrelievo.normals(normal[..., 0], {"focal_px": 900}), NDArray[np.float32])
pyrelievo.enhance(normal, depth=normal[..., 0])
pyrelievo.shape(height=normal[..., 0], height_scale=20)
pyrelievo.enhance(normal, normal, object=normal[..., 0] > 0.5)
pyrelievo.enhance(normal, normal, solver="magic")  # pyright: ignore[reportArgumentType]
pyrelievo.enhance(normal, normal, curvature=1)  # pyright: ignore[reportCallIssue]
