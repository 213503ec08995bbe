"""Results are those of the command line on the same passes, and nothing else of Blender changes."""

from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest

from conftest import SIZE

FORMATS = {"file_format": "JPEG", "quality": 37, "color_mode": "BW"}


def channels_of(path):
    """The channels of an EXR, by the ends of their names."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}


def channel_of(channels, end):
    found = [pixels for name, pixels in channels.items() if name == end or name.endswith("." + end)]
    assert len(found) == 1, (end, list(channels))
    return found[0]


def pixels_of(image):
    """The pixels of an image, from its top."""
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[::-1]


@pytest.fixture
def made(rendered, relievo, command_line, tmp_path):
    """What the operator and the command line make of the last render."""

    def make(command, flags, names, **values):
        rendered.relievo.command = command
        for name, value in values.items():
            setattr(getattr(rendered.relievo, command), name, value)
        bpy.ops.relievo.bring_out()
        relievo.passes.save_passes(rendered, tmp_path / "passes.exr")
        whole = ["--layers", "results", "--layer-names", "short", "--depth-of-output", "float"]
        command_line(command, tmp_path / "passes.exr", "-o", tmp_path / "out.exr", *whole, *flags)
        channels = channels_of(tmp_path / "out.exr")
        return [channel_of(channels, name) for name in names]

    return make


@pytest.mark.parametrize(
    ("image", "command", "flags", "names", "values"),
    [
        ("enhance", "enhance", ["--scaling=2.2"], "RGB", {"scaling": 2.2}),
        (
            "relight",
            "relight",
            ["--light=135,40", "--light=20,30,1,0,0", "--method=warp"],
            "RGB",
            {"light": "135,40; 20,30,1,0,0", "method": "warp"},
        ),
        ("hatch", "hatch", ["--seed=3"], "R", {"seed": "3"}),
        ("map.height", "map", ["--map=height"], ["height"], {"map": "height"}),
        ("curvature", "shape", [], ["curvature.kappa"], {}),
    ],
)
def test_images_are_those_of_the_command_line(made, image, command, flags, names, values):
    planes = made(command, flags, names, **values)
    shown = bpy.data.images[f"relievo.{image}"]
    assert shown.is_float and tuple(shown.size) == SIZE
    # A picture is seen as the render is, what is measured without any colour space.
    assert shown.use_view_as_render == (names == "RGB")
    assert shown.colorspace_settings.is_data == (command in ("map", "shape"))
    for at, plane in enumerate(planes):
        np.testing.assert_array_equal(pixels_of(shown)[..., at], plane)
    # It is a picture, rather than left empty; curvature is of both signs.
    assert np.ptp(planes[0]) > 0.1
    assert command != "shape" or (planes[0].min() < -0.3 and planes[0].max() > 0.3)


def test_without_normals_depth_shows_the_surface(made, rendered, capfd):
    for layer in rendered.view_layers:
        layer.use_pass_normal = False
    bpy.ops.render.render(scene=rendered.name)
    planes = made("relight", ["--light=135,40"], "RGB", light="135,40")
    shown = pixels_of(bpy.data.images["relievo.relight"])[..., :3]
    np.testing.assert_array_equal(shown, np.dstack(planes))
    assert "Warning: Normals from depth: no layer holds any" in capfd.readouterr().out


def test_an_image_in_use_is_replaced_where_it_is_used(made, rendered):
    made("enhance", [], "R")
    user = bpy.data.textures.new("user", "IMAGE")
    user.image = bpy.data.images["relievo.enhance"]
    rendered.render.resolution_x = 100
    try:
        bpy.ops.render.render(scene=rendered.name)
        bpy.ops.relievo.bring_out()
    finally:
        rendered.render.resolution_x = SIZE[0]
    assert user.image.name == "relievo.enhance" and tuple(user.image.size) == (100, SIZE[1])
    bpy.data.textures.remove(user)


def test_transparent_films_keep_their_alpha(made, rendered, relievo, tmp_path):
    rendered.render.film_transparent = True
    try:
        bpy.ops.render.render(scene=rendered.name)
        bpy.ops.relievo.bring_out()
        relievo.passes.save_passes(rendered, tmp_path / "passes.exr")
    finally:
        rendered.render.film_transparent = False
    alpha = channel_of(channels_of(tmp_path / "passes.exr"), "Combined.A")
    np.testing.assert_array_equal(pixels_of(bpy.data.images["relievo.enhance"])[..., 3], alpha)
    assert alpha.min() == 0 and alpha.max() == 1


def test_lines(rendered, relievo, command_line, tmp_path):
    # Another command is chosen: drawings have their own settings.
    rendered.relievo.hatch.style = "engraving"
    relievo.passes.save_passes(rendered, tmp_path / "passes.exr")
    command_line("hatch", tmp_path / "passes.exr", "--style", "engraving", "-o", tmp_path / "out.svg")
    bpy.ops.relievo.save_svg(filepath=str(tmp_path / "own.svg"))
    assert (tmp_path / "own.svg").read_text() == (tmp_path / "out.svg").read_text()


def test_grease_pencil(rendered):
    before = set(bpy.data.objects)
    bpy.ops.relievo.grease_pencil()
    (drawing,) = set(bpy.data.objects) - before
    layers = drawing.data.layers
    # From 4.3 on a frame has a drawing.
    frames = [layer.frames[0] for layer in layers]
    strokes = sum(len(frame.drawing.strokes if hasattr(frame, "drawing") else frame.strokes) for frame in frames)
    bpy.data.objects.remove(drawing)
    assert strokes > 50


@pytest.mark.parametrize("command", ["enhance", "map"])
def test_needed_passes_are_switched_on(scene, relievo, command):
    scene.relievo.command = command
    further = scene.view_layers.new("Further")
    try:
        for layer in scene.view_layers:
            layer.use_pass_normal = layer.use_pass_diffuse_direct = False
        bpy.ops.relievo.switch_passes()
        assert all(layer.use_pass_normal and layer.use_pass_z and layer.use_pass_position for layer in scene.view_layers)
        assert all(layer.use_pass_diffuse_direct == (command == "enhance") for layer in scene.view_layers)
        assert not relievo.passes.missing(scene, relievo.passes.needed(scene))
    finally:
        scene.view_layers.remove(further)


@pytest.fixture
def formats(scene):
    """Formats that a user has chosen; they're still there at the end, and no temporary file is."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    for name, value in FORMATS.items():
        setattr(settings, name, value)
    yield settings
    assert {name: getattr(settings, name) for name in FORMATS} == FORMATS
    assert not list(Path(bpy.app.tempdir).glob("relievo_*"))


def test_formats_are_restored(rendered, formats):
    bpy.ops.relievo.bring_out()


def test_formats_are_restored_after_errors(rendered, formats):
    for layer in rendered.view_layers:
        layer.use_pass_normal = layer.use_pass_z = layer.use_pass_position = False
    bpy.ops.render.render(scene=rendered.name)
    with pytest.raises(RuntimeError) as raised:
        bpy.ops.relievo.bring_out()
    (line,) = str(raised.value).strip().splitlines()
    assert line.startswith("Error: The render: has no normal")
    assert line.endswith("switch the needed passes on in the sidebar, and render again")
    rendered.relievo.enhance.scaling = -1
    with pytest.raises(RuntimeError, match="Scaling is -1; give 0 to"):
        bpy.ops.relievo.bring_out()
