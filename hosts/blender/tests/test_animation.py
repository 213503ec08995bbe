"""Animations: all frames with one set of automatic choices, as the command line makes them."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from test_results import channels_of, channel_of


@pytest.fixture
def animation(rendered, tmp_path):
    rendered.relievo.folder = str(tmp_path / "out")
    rendered.frame_set(2)
    settings = rendered.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    yield rendered
    assert rendered.frame_current == 2
    assert settings.file_format == "OPEN_EXR"
    assert not list(Path(bpy.app.tempdir).glob("relievo_*"))


@pytest.fixture
def compared(animation, relievo, command_line, tmp_path):
    """The channels of all frames, as the operator and as the command line make them of the same passes."""

    def compare(command, *flags):
        animation.relievo.command = command
        bpy.ops.relievo.bring_out_animation()
        for number in (1, 2, 3):
            animation.frame_set(number)
            bpy.ops.render.render(scene=animation.name)
            relievo.passes.save_passes(animation, tmp_path / f"passes.{number:04d}.exr")
        animation.frame_set(2)
        whole = ["--layers", "results", "--layer-names", "short", "--depth-of-output", "float", *flags]
        frames = ["--frames", "1-3"]
        command_line(command, tmp_path / "passes.####.exr", "-o", tmp_path / "line.####.exr", *whole, *frames)
        # By itself the last frame would choose otherwise: the test can tell.
        command_line(command, tmp_path / "passes.####.exr", "-o", tmp_path / "alone.####.exr", *whole, "--frames", "3")
        own = [channels_of(tmp_path / "out" / f"{command}_{number:04d}.exr") for number in (1, 2, 3)]
        line = [channels_of(tmp_path / f"line.{number:04d}.exr") for number in (1, 2, 3)]
        return own, line, channels_of(tmp_path / "alone.0003.exr")

    return compare


@pytest.mark.parametrize(
    ("command", "flags", "names"),
    # The command line draws each frame anew, too, when it follows no motion.
    [("enhance", [], "RGB"), ("hatch", ["--motion=none"], "R")],
)
def test_frames_are_those_of_the_command_line(compared, command, flags, names):
    own, line, alone = compared(command, *flags)
    for made, expected in zip(own, line, strict=True):
        for name in names:
            np.testing.assert_array_equal(made[name], channel_of(expected, name))
    assert (channel_of(alone, "R") != own[2]["R"]).any() and (own[0]["R"] != own[2]["R"]).any()
    assert command != "hatch" or own[0]["R"].min() < 0.1


def test_drawings_are_written_as_they_are(animation, tmp_path):
    animation.relievo.command = "hatch"
    animation.frame_end = 1
    animation.render.image_settings.file_format = "PNG"
    try:
        bpy.ops.relievo.bring_out_animation()
    finally:
        animation.frame_end = 3
        animation.render.image_settings.file_format = "OPEN_EXR"
    written = bpy.data.images.load(str(tmp_path / "out" / "hatch_0001.png"))
    pixels = np.array(written.pixels[:])
    bpy.data.images.remove(written)
    # Bare paper is white: no view transform for renders has darkened it.
    assert np.isclose(pixels.max(), 1, atol=1e-3) and animation.view_settings.view_transform != "Standard"


def test_frames_can_be_cancelled(animation, relievo, tmp_path):
    steps = relievo.operators.RELIEVO_OT_bring_out_animation.steps
    run = steps(None, bpy.context)
    for _ in run:
        # The second of three frames is at work.
        if (tmp_path / "out" / "enhance_0001.exr").exists():
            break
    run.close()
    written = [path.name for path in (tmp_path / "out").iterdir()]
    assert written == ["enhance_0001.exr"]


def test_one_is_at_work_at_a_time(animation):
    """Others are refused in one line, until it has ended, by an error too."""
    relievo, said = bpy.ops.relievo, []
    others = [relievo.bring_out, relievo.bring_out_animation, relievo.curvature, relievo.grease_pencil, relievo.save_svg]

    def start_others(*_):
        for other in others:
            with pytest.raises(RuntimeError) as raised:
                other()
            said.append(str(raised.value).strip())

    animation.frame_end = 1
    bpy.app.handlers.render_post.append(start_others)
    try:
        relievo.bring_out_animation()
    finally:
        bpy.app.handlers.render_post.remove(start_others)
        animation.frame_end = 3
    assert len(said) == len(others)
    advice = "Bring Out Shape of Animation is still at work: wait for it, or cancel it with Esc"
    assert all(line.endswith(advice) and "\n" not in line for line in said)
    animation.relievo.enhance.scaling = -1
    for _ in range(2):
        with pytest.raises(RuntimeError, match="Scaling is -1"):
            relievo.bring_out()


def test_a_folder_beside_no_file_is_an_error(animation):
    animation.relievo.folder = "//relievo/"
    with pytest.raises(RuntimeError, match="beside the .blend, which has no place yet"):
        bpy.ops.relievo.bring_out_animation()
