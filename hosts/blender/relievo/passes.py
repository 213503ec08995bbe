"""Passes of a render: which a command needs, and the file that they are read from."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy

#: What every command needs: the surface.
SURFACE = ("normal", "z", "position")

#: The light of a picture in parts, which enhance scales one by one.
LIGHT = (
    *(f"{lobe}_{part}" for lobe in ("diffuse", "glossy", "transmission") for part in ("direct", "indirect", "color")),
    "emit",
    "environment",
)

#: The surface's own colour.
ALBEDO = ("diffuse_color",)

#: What a command needs beside the surface.
FURTHER = {"enhance": LIGHT, "relight": ALBEDO, "hatch": ALBEDO}


def needed(scene: bpy.types.Scene) -> tuple[str, ...]:
    """The passes that the command of a scene is best given."""
    settings = scene.relievo
    by_name = ("cryptomatte_object",) if getattr(settings, settings.command).object else ()
    return (*SURFACE, *FURTHER.get(settings.command, ()), *by_name)


def missing(scene: bpy.types.Scene, names: tuple[str, ...]) -> list[tuple[bpy.types.ViewLayer, str]]:
    """Passes that are off, in the view layers that are rendered, as properties of those."""
    layers = [layer for layer in scene.view_layers if layer.use]
    flags = [f"use_pass_{name}" for name in names]
    return [(layer, flag) for layer in layers for flag in flags if not getattr(layer, flag)]


@contextmanager
def restored(settings: Any) -> Iterator[None]:
    """Puts the values of a group of settings back at the end, after errors too."""
    plain = ("ENUM", "BOOLEAN", "INT", "FLOAT", "STRING")
    names = [p.identifier for p in settings.bl_rna.properties if p.type in plain and not p.is_readonly]
    before = {name: value for name in names if isinstance(value := getattr(settings, name), (str, bool, int, float))}
    try:
        yield
    finally:
        # In the order of the table: the kind of file comes before what only some kinds have.
        for name, value in before.items():
            if getattr(settings, name) != value:
                setattr(settings, name, value)


def set_file_format(image: Any, name: str) -> None:
    """Sets the format of files; from 5.0 on each belongs to a kind of media."""
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE" if name == "OPEN_EXR_MULTILAYER" else "IMAGE"
    image.file_format = name


def save_passes(scene: bpy.types.Scene, path: Path) -> None:
    """Saves the passes of the last render, as 32 bits each."""
    results = (image for image in bpy.data.images if image.type == "RENDER_RESULT")
    result = next(results, None)
    if result is None:
        raise ValueError("there is no render yet: render the scene first")
    image = scene.render.image_settings
    with restored(image):
        set_file_format(image, "OPEN_EXR_MULTILAYER")
        image.color_depth = "32"
        # Written and read several times faster than ZIP, for twice the size.
        image.exr_codec = "RLE"
        image.use_preview = False
        try:
            result.save_render(str(path), scene=scene)
        except RuntimeError as error:
            raise ValueError("there is no render to be read: render the scene first") from error


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder for passes, removed at the end."""
    with tempfile.TemporaryDirectory(prefix="relievo_", dir=bpy.app.tempdir or None) as folder:
        yield Path(folder)
