"""Functions give what the command line writes, bit for bit; half a step where its file has 8 bits."""

import subprocess
import sys

import numpy as np
import pytest

import pyrelievo
from conftest import FIXTURES, channel_of, channels_of

CASES = {
    "enhance": {"scaling": 0.8, "iterations": 20},
    "relight": {"light": [(135, 40), (20, 30, 0.2, 0.3, 0.9)], "method": "warp"},
    "shape": {"scale": [2, 6], "write": ["kappa", "direction.x", "relief", "curvature_6px.mean"]},
    "hatch": {"style": "pencil", "seed": 3},
    "map": {"map": ["curvature", "edges", "height", "occlusion"]},
}

#: Everything that a command makes, as it is.
WHOLE = ["--layers", "results", "--layer-names", "short", "--depth-of-output", "float", "-q"]


def relievo(words):
    """Runs the command line; returns its exit code."""
    return subprocess.run([sys.executable, "-m", "pyrelievo", *map(str, words)], check=False).returncode


def written(tmp_path, command, path, settings):
    """The channels that the command line writes of a file."""
    out = tmp_path / "out.exr"
    flags = []
    for name, value in settings.items():
        for one in value if name == "light" else [value]:
            texts = map(str, one) if isinstance(one, (list, tuple)) else [str(one)]
            flags.append(f"--{name}={','.join(texts)}")
    assert relievo([command, path, "-o", out, *WHOLE, *flags]) == 0
    return channels_of(out)


@pytest.mark.parametrize("command", ["enhance", "relight"])
def test_pictures(tmp_path, bust, command):
    channels = written(tmp_path, command, bust, CASES[command])
    made = getattr(pyrelievo, command)(pyrelievo.load(bust), **CASES[command])
    assert made.dtype == np.float32
    for at, name in enumerate("RGB"):
        np.testing.assert_array_equal(made[..., at], channel_of(channels, name))


def test_layers(tmp_path, bust):
    channels = written(tmp_path, "shape", bust, CASES["shape"])
    made = pyrelievo.shape(bust, **CASES["shape"])
    np.testing.assert_array_equal(made.kappa, channels["curvature.kappa"])
    np.testing.assert_array_equal(made.direction[..., 0], channels["direction.x"])
    np.testing.assert_array_equal(made.height, channels["relief.height"])
    np.testing.assert_array_equal(made.scales[6].curvature[..., 2], channels["curvature_6px.mean"])
    assert made.kappa.base is made.direction.base


def test_drawings(tmp_path, bust):
    channels = written(tmp_path, "hatch", bust, CASES["hatch"])
    made = pyrelievo.hatch(bust, **CASES["hatch"])
    np.testing.assert_array_equal(made.paper, channel_of(channels, "R"))
    np.testing.assert_array_equal(made.strokes, channels["strokes.hatching"])
    np.testing.assert_array_equal(made.contours, channels["strokes.contours"])
    np.testing.assert_array_equal(made.tone, channels["strokes.tone"])


def test_lines_are_those_of_an_svg(tmp_path, bust):
    out = tmp_path / "out.svg"
    assert relievo(["hatch", bust, "-o", str(out), "--style", "engraving", "-q"]) == 0
    assert pyrelievo.hatch(bust, style="engraving").svg() == out.read_text()


def test_maps(tmp_path, bust):
    channels = written(tmp_path, "map", bust, CASES["map"])
    made = pyrelievo.map(bust, **CASES["map"])
    assert list(made) == CASES["map"]["map"]
    for name, plane in made.items():
        np.testing.assert_array_equal(plane, channels[f"map.{name}"])


@pytest.mark.parametrize("command", ["enhance", "relight", "hatch"])
def test_bytes_are_those_of_a_png(tmp_path, bust, command):
    settings = {"light": [(135, 40)]} if command == "relight" else {}
    flags = ["--light=135,40"] if settings else []
    if command == "hatch":
        # Arrays are as large as their frame; a PNG of this is enlarged unless its style is named.
        flags = ["--style", "engraving"]
    out = tmp_path / "out.png"
    assert relievo([command, bust, "-o", str(out), "-q", *flags]) == 0
    # Read back as what it is, a picture of integers, which count as sRGB: the table is the same both ways.
    made = getattr(pyrelievo, command)(bust, dtype=np.uint8, **settings)
    shown = decoded_png(out)
    np.testing.assert_array_equal(made[..., :3].squeeze(), shown[..., :3])


def decoded_png(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"))


def test_a_photo_with_its_normal_map(tmp_path):
    photo, normals = FIXTURES / "inscription.color.jpg", FIXTURES / "inscription.normal.jpg"
    channels = written(tmp_path, "enhance", str(photo), {"normal": str(normals)})
    made = pyrelievo.enhance(pyrelievo.load(photo, normal=normals))
    np.testing.assert_array_equal(made[..., 0], channel_of(channels, "R"))


def test_a_sequence_has_one_gain(tmp_path):
    pattern = str(FIXTURES / "wheel.####.exr")
    gains = set()
    for number, made in pyrelievo.process(pattern, "shape"):
        one = pyrelievo.load(pattern, frame=number)
        gain = float(made.choices["curvature-gain"]) if "curvature-gain" in made.choices else None
        gains.add(gain)
        assert made.kappa.shape == one.shape
    assert len(gains) == 1


def test_drawings_of_a_sequence(tmp_path):
    """Each is drawn by itself, as the command line draws those without motion, with one tone for all."""
    pattern, out = str(FIXTURES / "wheel.####.exr"), tmp_path / "out.####.exr"
    assert relievo(["hatch", pattern, "-o", out, "--frames", "1-2", "--motion", "none", *WHOLE]) == 0
    levels = set()
    for number, drawing in pyrelievo.process(pattern, "hatch"):
        channels = channels_of(tmp_path / f"out.{number:04}.exr")
        np.testing.assert_array_equal(drawing.paper, channel_of(channels, "R"))
        levels.add(drawing.choices["tone-levels"])
    assert len(levels) == 1


def test_a_recipe_is_the_command_lines(tmp_path, bust):
    recipe = pyrelievo.Recipe("enhance", scaling=0.7, iterations=5)
    path = tmp_path / "look.toml"
    recipe.write(path)
    out = tmp_path / "out.exr"
    assert relievo(["run", path, bust, "-o", out, *WHOLE]) == 0
    red = channel_of(channels_of(out), "R")
    again = pyrelievo.Recipe.read(path)
    assert again.command == "enhance" and dict(again.settings)["scaling"] == "0.7"
    np.testing.assert_array_equal(again(pyrelievo.load(bust))[..., 0], red)
    # Settings of the call overrule it; a preset is a recipe too.
    plain = again(bust, scaling=0)
    np.testing.assert_array_equal(plain, pyrelievo.load(bust).color)
    assert pyrelievo.Recipe.read("portrait").command == "hatch"
