"""Results: arrays of a command, as images of Blender and as files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np
import pyrelievo

from .passes import restored, set_file_format

class Result(NamedTuple):
    """An array that a command has made, of rows x columns, or x channels."""

    name: str
    #: A picture is shown like the render, a drawing as it is, data without any colour space.
    kind: str
    pixels: np.ndarray
    alpha: np.ndarray | None = None


def results_of(
    recipe: pyrelievo.Recipe,
    path: Path,
    number: int | None,
    has_alpha: bool,
    progress: Callable[[str, float], None],
) -> list[Result]:
    """What a recipe makes of the passes in a file, or in that of a frame of an animation."""
    frame = pyrelievo.load(path, frame=number)
    made = recipe(frame, progress=progress)
    match recipe.command:
        case "map":
            return [Result(f"map.{name}", "data", pixels) for name, pixels in made.items()]
        case "shape":
            return [Result("curvature", "data", made.kappa)]
        case "hatch":
            return [Result("hatch", "drawing", made.paper)]
        case command:
            return [Result(command, "picture", made, frame.alpha if has_alpha else None)]


def image_of(result: Result) -> bpy.types.Image:
    """The image of a result, of 32-bit floats in scene-linear light. One of the same name is replaced."""
    height, width = result.pixels.shape[:2]
    buffer = np.ones((height, width, 4), np.float32)
    buffer[..., :3] = result.pixels if result.pixels.ndim == 3 else result.pixels[..., None]
    if result.alpha is not None and result.alpha.shape == (height, width):
        buffer[..., 3] = result.alpha
    image = image_named(f"relievo.{result.name}", width, height, result.kind == "data")
    image.use_view_as_render = result.kind == "picture"
    image.alpha_mode = "PREMUL"
    # Blender's rows go upward.
    image.pixels.foreach_set(np.ascontiguousarray(buffer[::-1]).ravel())
    image.update()
    return image


def image_named(name: str, width: int, height: int, is_data: bool) -> bpy.types.Image:
    """The image of a name and a size; where another has the name, what uses that gets the new one."""
    held = bpy.data.images.get(name)
    if held is not None and tuple(held.size) == (width, height) and held.is_float and held.has_data:
        return held
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=is_data)
    if held is not None:
        held.user_remap(image)
        bpy.data.images.remove(held)
        image.name = name
    return image


def save(result: Result, image: bpy.types.Image, scene: bpy.types.Scene, stem: str) -> Path:
    """Writes an image: a picture as the scene would be written, a drawing in plain sRGB, data as EXR."""
    settings = scene.render.image_settings
    with restored(settings), restored(settings.view_settings):
        if result.kind == "data":
            set_file_format(settings, "OPEN_EXR")
            settings.color_depth = "32"
        elif scene.render.is_movie_format or settings.file_format == "OPEN_EXR_MULTILAYER":
            set_file_format(settings, "OPEN_EXR" if not scene.render.is_movie_format else "PNG")
        if result.kind == "drawing":
            settings.color_management = "OVERRIDE"
            view = settings.view_settings
            view.view_transform, view.look, view.exposure, view.gamma = "Standard", "None", 0, 1
        path = Path(f"{stem}{scene.render.file_extension}")
        path.parent.mkdir(parents=True, exist_ok=True)
        image.save_render(str(path), scene=scene)
    return path


def show(context: bpy.types.Context, image: bpy.types.Image) -> Any:
    """Shows an image in the Image Editor that is at hand; returns the editor, None without one."""
    editors = [context.space_data]
    if context.screen is not None:
        editors += [area.spaces.active for area in context.screen.areas]
    editor = next((e for e in editors if e is not None and e.type == "IMAGE_EDITOR"), None)
    if editor is not None:
        editor.image = image
    return editor
