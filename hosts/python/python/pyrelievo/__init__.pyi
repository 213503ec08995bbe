# Written by stubs.py from the table of settings. Not to be edited.
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._relievo import Engine

__all__ = ["Drawing", "Engine", "Finding", "Frame", "Recipe", "Shape", "enhance", "hatch", "load", "map", "normals", "process", "relight", "shape"]

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
def shape(
    normal: ArrayLike | Frame | _Path | None = None,
    *,
    color: ArrayLike | str | None = None,
    depth: ArrayLike | str | None = None,
    height: ArrayLike | str | None = None,
    position: ArrayLike | str | None = None,
    mask: ArrayLike | str | None = None,
    object: ArrayLike | str | None = None,
    coverage: ArrayLike | str | None = None,
    occlusion: ArrayLike | str | None = None,
    importance: ArrayLike | str | None = None,
    albedo: ArrayLike | str | None = None,
    camera: Mapping[str, Any] | _Path | None = None,
    pixel_aspect: float = 1.0,
    height_scale: float | None = None,
    normal_space: str | None = None,
    normal_encoding: str | None = None,
    normal_flip: str | None = None,
    depth_kind: str | None = None,
    out: _Floats | None = None,
    dtype: Any = None,
    engine: Engine | None = None,
    progress: Callable[[str, float], Any] | None = None,
    wrap: Literal["none", "x", "y", "xy", "auto"] | Sequence[str] | None = "none",
    iterations: float | Sequence[float] | None = 10,
    scale: float | Sequence[float] | None = None,
    reference_height: float | Sequence[float] | Literal["none"] | None = "none",
    solver: Literal["chebyshev", "explicit"] | Sequence[str] | None = "chebyshev",
    tolerance: float | Sequence[float] | None = 0.0001,
    foreshortening: float | Sequence[float] | None = 0,
    silhouette: _Value | None = "0.008,0.012",
    crease: _Value | None = "45,80",
    direction_step: float | Sequence[float] | Literal["auto"] | None = "auto",
    curvature_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    write: _Value | None = None,
    dpi: _Value | None = None,
    height_tolerance: float | Sequence[float] | None = 0.0001,
    height_detail: float | Sequence[float] | None = 32,
    occlusion_radius: float | Sequence[float] | None = 32,
    occlusion_slices: float | Sequence[float] | None = 8,
) -> Shape: ...
def enhance(
    color: ArrayLike | Frame | _Path,
    normal: ArrayLike | None = None,
    *,
    depth: ArrayLike | str | None = None,
    height: ArrayLike | str | None = None,
    position: ArrayLike | str | None = None,
    mask: ArrayLike | str | None = None,
    object: ArrayLike | str | None = None,
    coverage: ArrayLike | str | None = None,
    occlusion: ArrayLike | str | None = None,
    importance: ArrayLike | str | None = None,
    albedo: ArrayLike | str | None = None,
    camera: Mapping[str, Any] | _Path | None = None,
    pixel_aspect: float = 1.0,
    height_scale: float | None = None,
    normal_space: str | None = None,
    normal_encoding: str | None = None,
    normal_flip: str | None = None,
    depth_kind: str | None = None,
    out: _Floats | None = None,
    dtype: Any = None,
    engine: Engine | None = None,
    progress: Callable[[str, float], Any] | None = None,
    wrap: Literal["none", "x", "y", "xy", "auto"] | Sequence[str] | None = "none",
    iterations: float | Sequence[float] | None = 10,
    scale: float | Sequence[float] | None = None,
    reference_height: float | Sequence[float] | Literal["none"] | None = "none",
    solver: Literal["chebyshev", "explicit"] | Sequence[str] | None = "chebyshev",
    tolerance: float | Sequence[float] | None = 0.0001,
    foreshortening: float | Sequence[float] | None = 0,
    silhouette: _Value | None = "0.008,0.012",
    crease: _Value | None = "45,80",
    direction_step: float | Sequence[float] | Literal["auto"] | None = "auto",
    curvature_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    write: _Value | None = None,
    dpi: _Value | None = None,
    lobes: bool | Literal["auto", "on", "off"] | Sequence[str] | None = "auto",
    diffuse: _Value | None = None,
    specular: _Value | None = None,
    light_group: _Value | None = None,
    scaling: float | Sequence[float] | None = 1,
    scaling_ambient: float | Sequence[float] | None = None,
    scaling_diffuse: float | Sequence[float] | None = None,
    scaling_specular: float | Sequence[float] | None = None,
    invariant_point: float | Sequence[float] | None = 0.25,
    anisotropy: float | Sequence[float] | None = 0,
    white_level: float | Sequence[float] | Literal["auto"] | None = "auto",
    term_white_level: _Value | None = None,
    mix: float | Sequence[float] | None = 1,
    blur_fade: float | Sequence[float] | None = 1,
    exposure: float | Sequence[float] | Literal["auto"] | None = "auto",
    highlights: Literal["compress", "clip"] | Sequence[str] | None = "compress",
) -> NDArray[Any]: ...
def relight(
    normal: ArrayLike | Frame | _Path | None = None,
    *,
    color: ArrayLike | str | None = None,
    depth: ArrayLike | str | None = None,
    height: ArrayLike | str | None = None,
    position: ArrayLike | str | None = None,
    mask: ArrayLike | str | None = None,
    object: ArrayLike | str | None = None,
    coverage: ArrayLike | str | None = None,
    occlusion: ArrayLike | str | None = None,
    importance: ArrayLike | str | None = None,
    albedo: ArrayLike | str | None = None,
    camera: Mapping[str, Any] | _Path | None = None,
    pixel_aspect: float = 1.0,
    height_scale: float | None = None,
    normal_space: str | None = None,
    normal_encoding: str | None = None,
    normal_flip: str | None = None,
    depth_kind: str | None = None,
    out: _Floats | None = None,
    dtype: Any = None,
    engine: Engine | None = None,
    progress: Callable[[str, float], Any] | None = None,
    wrap: Literal["none", "x", "y", "xy", "auto"] | Sequence[str] | None = "none",
    iterations: float | Sequence[float] | None = 10,
    scale: float | Sequence[float] | None = None,
    reference_height: float | Sequence[float] | Literal["none"] | None = "none",
    solver: Literal["chebyshev", "explicit"] | Sequence[str] | None = "chebyshev",
    tolerance: float | Sequence[float] | None = 0.0001,
    foreshortening: float | Sequence[float] | None = 0,
    silhouette: _Value | None = "0.008,0.012",
    crease: _Value | None = "45,80",
    direction_step: float | Sequence[float] | Literal["auto"] | None = "auto",
    curvature_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    write: _Value | None = None,
    dpi: _Value | None = None,
    light: _Value | None = None,
    area_light: _Value | None = None,
    point_light: _Value | None = None,
    environment: _Value | None = None,
    lit_sphere: _Value | None = None,
    environment_rotate: float | Sequence[float] | None = 0,
    environment_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    middle_light: float | Sequence[float] | Literal["auto"] | None = "auto",
    samples: float | Sequence[float] | Literal["auto"] | None = "auto",
    light_error: float | Sequence[float] | None = None,
    ambient: float | Sequence[float] | None = 0.1,
    method: Literal["plain", "warp", "scale", "both"] | Sequence[str] | None = "both",
    warp: float | Sequence[float] | None = 4,
    contrast: float | Sequence[float] | None = 0,
    warp_by: Literal["auto", "lookups", "lights"] | Sequence[str] | None = "auto",
    scaling: float | Sequence[float] | None = 1,
    scaling_ambient: float | Sequence[float] | None = None,
    scaling_diffuse: float | Sequence[float] | None = None,
    scaling_specular: float | Sequence[float] | None = None,
    invariant_point: float | Sequence[float] | None = 0.25,
    anisotropy: float | Sequence[float] | None = 0,
    white_level: float | Sequence[float] | Literal["auto"] | None = "auto",
    albedo_from: Literal["auto", "layer", "estimate", "picture", "white"] | Sequence[str] | None = "auto",
    material: Literal["lambert", "phong", "blinn-phong", "toon", "sublambert", "ashikhmin-shirley", "mirror", "glass"] | Sequence[str] | None = "lambert",
    diffuse_gain: float | Sequence[float] | None = 0.9,
    specular_gain: float | Sequence[float] | None = None,
    shininess: float | Sequence[float] | None = 32,
    flatness: float | Sequence[float] | None = 0.5,
    coat: _Value | None = "80,80",
    reflectance: float | Sequence[float] | None = 0.05,
    tangent: _Value | None = "curvature",
    ior: float | Sequence[float] | None = 1.5,
    thin: bool = False,
    toon_levels: float | Sequence[float] | None = None,
    toon_softness: float | Sequence[float] | None = 0.15,
    specular_mask: _Value | None = None,
    back: _Value | None = None,
    behind: _Value | None = None,
    surroundings: _Value | None = None,
    surroundings_camera: _Value | None = None,
    hit_position: _Value | None = None,
    search_steps: _Value | None = 128,
    mix: float | Sequence[float] | None = 1,
    blur_fade: float | Sequence[float] | None = 1,
    exposure: float | Sequence[float] | Literal["auto"] | None = "auto",
    highlights: Literal["compress", "clip"] | Sequence[str] | None = "compress",
) -> NDArray[Any]: ...
def hatch(
    normal: ArrayLike | Frame | _Path | None = None,
    *,
    color: ArrayLike | str | None = None,
    depth: ArrayLike | str | None = None,
    height: ArrayLike | str | None = None,
    position: ArrayLike | str | None = None,
    mask: ArrayLike | str | None = None,
    object: ArrayLike | str | None = None,
    coverage: ArrayLike | str | None = None,
    occlusion: ArrayLike | str | None = None,
    importance: ArrayLike | str | None = None,
    albedo: ArrayLike | str | None = None,
    camera: Mapping[str, Any] | _Path | None = None,
    pixel_aspect: float = 1.0,
    height_scale: float | None = None,
    normal_space: str | None = None,
    normal_encoding: str | None = None,
    normal_flip: str | None = None,
    depth_kind: str | None = None,
    out: _Floats | None = None,
    dtype: Any = None,
    engine: Engine | None = None,
    progress: Callable[[str, float], Any] | None = None,
    wrap: Literal["none", "x", "y", "xy", "auto"] | Sequence[str] | None = "none",
    iterations: float | Sequence[float] | None = 10,
    scale: float | Sequence[float] | None = None,
    reference_height: float | Sequence[float] | Literal["none"] | None = "none",
    solver: Literal["chebyshev", "explicit"] | Sequence[str] | None = "chebyshev",
    tolerance: float | Sequence[float] | None = 0.0001,
    foreshortening: float | Sequence[float] | None = 0,
    silhouette: _Value | None = "0.008,0.012",
    crease: _Value | None = "45,80",
    direction_step: float | Sequence[float] | Literal["auto"] | None = "auto",
    curvature_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    write: _Value | None = None,
    dpi: _Value | None = None,
    light: _Value | None = None,
    area_light: _Value | None = None,
    point_light: _Value | None = None,
    environment: _Value | None = None,
    lit_sphere: _Value | None = None,
    environment_rotate: float | Sequence[float] | None = 0,
    environment_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    middle_light: float | Sequence[float] | Literal["auto"] | None = "auto",
    samples: float | Sequence[float] | Literal["auto"] | None = "auto",
    light_error: float | Sequence[float] | None = None,
    ambient: float | Sequence[float] | None = 0.1,
    method: Literal["plain", "warp", "scale", "both"] | Sequence[str] | None = "both",
    warp: float | Sequence[float] | None = 4,
    contrast: float | Sequence[float] | None = 0,
    warp_by: Literal["auto", "lookups", "lights"] | Sequence[str] | None = "auto",
    scaling: float | Sequence[float] | None = 1,
    scaling_ambient: float | Sequence[float] | None = None,
    scaling_diffuse: float | Sequence[float] | None = None,
    scaling_specular: float | Sequence[float] | None = None,
    invariant_point: float | Sequence[float] | None = 0.25,
    anisotropy: float | Sequence[float] | None = 0,
    white_level: float | Sequence[float] | Literal["auto"] | None = "auto",
    albedo_from: Literal["auto", "layer", "estimate", "picture", "white"] | Sequence[str] | None = "auto",
    material: Literal["lambert", "phong", "blinn-phong", "toon", "sublambert", "ashikhmin-shirley", "mirror", "glass"] | Sequence[str] | None = "lambert",
    diffuse_gain: float | Sequence[float] | None = 0.9,
    specular_gain: float | Sequence[float] | None = None,
    shininess: float | Sequence[float] | None = 32,
    flatness: float | Sequence[float] | None = 0.5,
    coat: _Value | None = "80,80",
    reflectance: float | Sequence[float] | None = 0.05,
    tangent: _Value | None = "curvature",
    ior: float | Sequence[float] | None = 1.5,
    thin: bool = False,
    toon_levels: float | Sequence[float] | None = None,
    toon_softness: float | Sequence[float] | None = 0.15,
    specular_mask: _Value | None = None,
    back: _Value | None = None,
    behind: _Value | None = None,
    surroundings: _Value | None = None,
    surroundings_camera: _Value | None = None,
    hit_position: _Value | None = None,
    search_steps: _Value | None = 128,
    mix: float | Sequence[float] | None = 1,
    blur_fade: float | Sequence[float] | None = 1,
    exposure: float | Sequence[float] | Literal["auto"] | None = "auto",
    highlights: Literal["compress", "clip"] | Sequence[str] | None = "compress",
    tone: Literal["auto", "enhance", "picture", "relight"] | Sequence[str] | None = "auto",
    key_share: float | Sequence[float] | None = 0.65,
    background: Literal["strokes", "plain", "none"] | Sequence[str] | None = "plain",
    halo: float | Sequence[float] | None = 1,
    tone_levels: _Value | None = "auto",
    white_point: float | Sequence[float] | Literal["auto"] | None = "auto",
    black_point: float | Sequence[float] | None = 0,
    tone_gamma: float | Sequence[float] | None = 2.2,
    directions: Literal["max", "min", "both"] | Sequence[str] | None = "both",
    fallback: _Value | None = 45,
    passes: float | Sequence[float] | None = 3,
    smoothing: float | Sequence[float] | None = 6,
    enlarge: _Value | None = 1,
    size: _Value | None = None,
    page: _Value | None = None,
    margin: _Value | None = 12,
    landscape: bool | Literal["auto", "on", "off"] | Sequence[str] | None = "auto",
    style: _Value | None = "pen",
    ink: Literal["antialiased", "bilevel"] | Sequence[str] | None = "antialiased",
    stroke_scale: _Value | None = "auto",
    stroke_width: float | Sequence[float] | None = None,
    stroke_length: _Value | None = None,
    stroke_spacing: float | Sequence[float] | None = None,
    wobble: float | Sequence[float] | None = None,
    pressure: float | Sequence[float] | None = None,
    at_edges: Literal["meet", "stop"] | Sequence[str] | None = "meet",
    seed: _Value | None = 1,
    plotter: bool | Literal["auto", "on", "off"] | Sequence[str] | None = "auto",
    pens: _Value | None = None,
    levels: float | Sequence[float] | None = 16,
    sets: _Value | None = 1,
    contours: bool | Literal["on", "off"] | Sequence[str] | None = "on",
    contour_width: float | Sequence[float] | None = 2,
    crease_width: float | Sequence[float] | None = 0.6,
    object_lines: Literal["auto", "off"] | Sequence[str] | None = "auto",
    depth_emphasis: float | Sequence[float] | None = 0.4,
    jump_emphasis: _Value | None = 0.5,
    shortest_contour: _Value | None = 12,
    contour_taper: _Value | None = 10,
    contour_smoothing: _Value | None = 24,
    interior: bool | Literal["on", "off"] | Sequence[str] | None = "on",
    line_detail: float | Sequence[float] | None = 1,
    line_scale: float | Sequence[float] | None = 1,
    line_width: float | Sequence[float] | None = 2.3,
    ridge_width: float | Sequence[float] | None = 0.7,
    shadow_width: float | Sequence[float] | None = 0,
    line_strength: float | Sequence[float] | None = 0.5,
    line_depth: float | Sequence[float] | None = 0.2,
    line_light: float | Sequence[float] | None = 0.2,
    line_levels: _Value | None = "auto",
    lines_only: bool = False,
    object_angle: _Value | None = None,
) -> Drawing: ...
def map(
    normal: ArrayLike | Frame | _Path | None = None,
    *,
    color: ArrayLike | str | None = None,
    depth: ArrayLike | str | None = None,
    height: ArrayLike | str | None = None,
    position: ArrayLike | str | None = None,
    mask: ArrayLike | str | None = None,
    object: ArrayLike | str | None = None,
    coverage: ArrayLike | str | None = None,
    occlusion: ArrayLike | str | None = None,
    importance: ArrayLike | str | None = None,
    albedo: ArrayLike | str | None = None,
    camera: Mapping[str, Any] | _Path | None = None,
    pixel_aspect: float = 1.0,
    height_scale: float | None = None,
    normal_space: str | None = None,
    normal_encoding: str | None = None,
    normal_flip: str | None = None,
    depth_kind: str | None = None,
    out: _Floats | None = None,
    dtype: Any = None,
    engine: Engine | None = None,
    progress: Callable[[str, float], Any] | None = None,
    iterations: float | Sequence[float] | None = 10,
    scale: float | Sequence[float] | None = None,
    reference_height: float | Sequence[float] | Literal["none"] | None = "none",
    solver: Literal["chebyshev", "explicit"] | Sequence[str] | None = "chebyshev",
    tolerance: float | Sequence[float] | None = 0.0001,
    foreshortening: float | Sequence[float] | None = 0,
    silhouette: _Value | None = "0.008,0.012",
    direction_step: float | Sequence[float] | Literal["auto"] | None = "auto",
    curvature_gain: float | Sequence[float] | Literal["auto"] | None = "auto",
    write: _Value | None = None,
    dpi: _Value | None = None,
    height_tolerance: float | Sequence[float] | None = 0.0001,
    height_detail: float | Sequence[float] | None = 32,
    occlusion_radius: float | Sequence[float] | None = 32,
    occlusion_slices: float | Sequence[float] | None = 8,
    map: Literal["curvature", "convex", "concave", "edges", "height", "occlusion", "residual", "normals"] | Sequence[str] | None = "curvature",
    as_: Literal["opengl", "directx", "opencv", "stablenormal", "world", "xy"] | Sequence[str] | None = "opengl",
    detail: _Value | None = None,
    flatten: bool = False,
    sum: _Value | None = None,
    wrap: Literal["none", "x", "y", "xy", "auto"] | Sequence[str] | None = "auto",
    crease: _Value | None = "15,45",
) -> dict[str, _Floats]: ...
