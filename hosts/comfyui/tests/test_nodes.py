"""The nodes, called as the server calls them, make what the module makes."""

import json
import sys
import types
import warnings

import numpy as np
import pytest

import pyrelievo
from conftest import FIXTURES, PACKAGE
from pyrelievo._settings import rows

NAMES = {"RelievoShape": "shape", "RelievoEnhance": "enhance", "RelievoRelight": "relight", "RelievoHatch": "hatch"}


def linear(shown):
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4).astype(np.float32)


def frame_of(node_inputs):
    """The frame of the first images, with layers as the module takes them."""
    color = node_inputs.get("image")
    layers = {"normal": node_inputs["normal"][0], "normal_encoding": "unsigned"}
    return pyrelievo.Frame(None if color is None else linear(color[0]), **layers)


def test_the_nodes(server):
    assert list(server.nodes) == list(NAMES) == list(server.names)
    for name, node in server.nodes.items():
        assert node.DESCRIPTION == getattr(pyrelievo, NAMES[name]).__doc__.splitlines()[0]
        assert len(node.RETURN_NAMES) == len(node.RETURN_TYPES)
        assert callable(getattr(node, node.FUNCTION)) and node.CATEGORY


@pytest.mark.parametrize("name", NAMES)
def test_inputs_are_those_of_the_table(server, name):
    inputs = server.inputs(name)
    json.dumps(inputs)  # as they go to the browser
    table, count = rows(NAMES[name]), 0
    for key, (kind, options, is_required) in inputs.items():
        assert options["tooltip"] and "IN or a file" not in options["tooltip"], key
        assert is_required or kind in ("IMAGE", "MASK") or options["advanced"]
        if kind in ("IMAGE", "MASK") or key in ("normal_flip", "depth_kind"):
            continue
        count += 1
        row, default = table[key], options["default"]
        assert default == ("" if row.default is None else row.default if kind != "STRING" else str(row.default))
        assert options["tooltip"].startswith(row.help.rstrip("."))
        server.checked(kind, options, default)
        if kind == "FLOAT":
            # The browser shows as many digits as the step has.
            assert abs(default / options["step"] - round(default / options["step"])) < 1e-6, key
    assert count >= 11
    with pytest.raises(AssertionError):
        server.checked(*inputs["iterations"][:2], 201)


def test_words_and_numbers_have_their_widgets(server):
    hatch = server.inputs("RelievoHatch")
    kinds = {name: hatch[name][0] for name in ("style", "seed", "key_share", "lines_only", "white_point", "levels")}
    assert kinds.pop("style") == ["auto", "pen", "pencil", "lines", "engraving", "stipple"]
    assert kinds == dict(seed="INT", key_share="FLOAT", lines_only="BOOLEAN", white_point="STRING", levels="INT")


def test_enhance(server, ball):
    made = server.call("RelievoEnhance", **ball, scaling=0.8, iterations=4)[0]
    expected = pyrelievo.enhance(frame_of(ball), scaling=0.8, iterations=4, dtype=np.uint8)
    assert np.abs(made[0] * 255 - expected).max() <= 0.51
    # Finer than bytes, where highlights are as they were.
    fine = pyrelievo.enhance(frame_of(ball), scaling=0.8, iterations=4)
    assert np.mean(np.abs(linear(made[0]) - fine) < 1e-5) > 0.9
    # Nothing to do: the image as it was.
    np.testing.assert_allclose(server.call("RelievoEnhance", **ball, scaling=0)[0], ball["image"], atol=1e-6)
    np.testing.assert_allclose(made[0, 0, 0], ball["image"][0, 0, 0], atol=1e-6)


def test_relight(server, ball):
    given = {"method": "warp", "shininess": 12.5, "material": "phong", "highlights": "clip"}
    made = server.call("RelievoRelight", normal=ball["normal"], light="135,40 20,30,0.2,0.3,0.9", **given)[0]
    lights = [(135, 40), (20, 30, 0.2, 0.3, 0.9)]
    expected = pyrelievo.relight(frame_of({"normal": ball["normal"]}), light=lights, dtype=np.uint8, **given)
    assert np.abs(made[0] * 255 - expected).max() <= 0.51


def test_hatch(server, ball):
    drawing, ink = server.call("RelievoHatch", **ball, style="pencil", seed=3, contour_width=1.5)
    expected = pyrelievo.hatch(frame_of(ball), style="pencil", seed=3, contour_width=1.5)
    np.testing.assert_allclose(ink[0], 1 - expected.paper, atol=1e-6)
    shown = pyrelievo.hatch(frame_of(ball), style="pencil", seed=3, contour_width=1.5, dtype=np.uint8)
    assert np.abs(drawing[0] * 255 - shown).max() <= 0.51
    assert server.call("RelievoHatch", **ball, enlarge="2")[0].shape == (1, 128, 128, 3)


def test_shape(server, ball):
    curvature, convex, concave, silhouettes, creases = server.call("RelievoShape", normal=ball["normal"], scale="3")
    expected = pyrelievo.shape(frame_of({"normal": ball["normal"]}), scale=3)
    np.testing.assert_allclose(curvature[0, ..., 1], 0.5 + 0.5 * expected.kappa, atol=1e-6)
    np.testing.assert_allclose(convex[0] - concave[0], expected.kappa, atol=1e-6)
    np.testing.assert_array_equal(silhouettes[0], expected.silhouette)
    np.testing.assert_array_equal(creases[0], expected.crease)
    assert convex[0, 32, 32] > 0 and convex[0, 0, 0] == 0


def test_sockets(server, ball):
    """Directions of normal maps, masks, depth, alpha and grey."""
    expected = server.call("RelievoEnhance", **ball)[0]
    is_ball = ball["normal"].max(axis=3, keepdims=True) > 0
    for axes, at in {"y": [1], "x": [0], "xy": [0, 1]}.items():
        flipped = ball["normal"].copy()
        flipped[..., at] = np.where(is_ball, 1 - flipped[..., at], 0)
        made = server.call("RelievoEnhance", image=ball["image"], normal=flipped, normal_flip=axes)[0]
        np.testing.assert_allclose(made, expected, atol=1e-4)
    mask = np.zeros((1, 64, 64), np.float32)
    mask[:, :, 32:] = 1
    half = server.call("RelievoEnhance", **ball, mask=mask)[0]
    np.testing.assert_allclose(half[:, :, :32], ball["image"][:, :, :32], atol=1e-6)
    np.testing.assert_array_equal(half[:, :, 32:], expected[:, :, 32:])
    with_alpha = np.concatenate([ball["image"], np.ones((1, 64, 64, 1), np.float32)], axis=3)
    np.testing.assert_array_equal(server.call("RelievoEnhance", **{**ball, "image": with_alpha})[0], expected)
    assert server.call("RelievoEnhance", **{**ball, "image": ball["image"][..., :1]})[0].shape == (1, 64, 64, 3)
    # A nearer half of a flat wall has an edge, in depth that is white near or far.
    wall = {"normal": np.full((1, 64, 64, 3), (0.5, 0.5, 1), np.float32)}
    steps = np.repeat(np.where(np.arange(64) < 32, 0.9, 0.1)[None, None, :, None], 64, axis=1).repeat(3, axis=3)
    for kind, depth in {"white-near": steps, "white-far": 1 - steps}.items():
        edges = server.call("RelievoShape", **wall, depth=depth.astype(np.float32), depth_kind=kind)[3]
        assert edges[0, 30, 30:34].max() == 1 and edges[0, 30, :28].max() == 0
    with pytest.raises(ValueError, match=r"give an array .* of the frame's size"):
        server.call("RelievoEnhance", image=ball["image"], normal=ball["normal"][:, :32])


@pytest.mark.parametrize("name", NAMES)
def test_a_depth_map_in_the_place_of_normals(server, ball, name, caplog):
    """Its normals are those that the module finds; that the camera is a guess is logged."""
    far = 1 - np.sqrt(np.maximum(1 - np.sum((2 * ball["normal"][..., :2] - 1) ** 2, axis=3, keepdims=True), 0))
    depth = np.round(255 * (0.9 - 0.8 * far)).astype(np.uint8)
    given = {"depth": (depth.repeat(3, axis=3) / np.float32(255)).astype(np.float32)}
    given |= {"image": ball["image"]} if name in ("RelievoEnhance", "RelievoRelight") else {}
    made = server.call(name, **given)[0][0]
    assert any("the camera is not known" in record.message for record in caplog.records)
    color = linear(ball["image"][0]) if "image" in given else None
    # Images of 8 bits are taken as such: their steps are rounding, not relief.
    frame = pyrelievo.Frame(color, depth=depth[0, ..., 0], depth_kind="white-near")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if name == "RelievoShape":
            expected = 0.5 + 0.5 * pyrelievo.shape(frame).kappa[..., None]
        else:
            expected = getattr(pyrelievo, NAMES[name])(frame, dtype=np.uint8) / np.float32(255)
    assert np.abs(made - expected).max() <= 0.51 / 255
    with pytest.raises(ValueError, match="^normal is missing; give it, or what shows the surface: depth"):
        server.call(name, **{key: value for key, value in given.items() if key == "image"})


def test_a_batch_has_one_look(server, ball):
    """What is automatic is the median of all images; a single normal map serves them all."""
    dark = [ball["image"] * factor for factor in (1, 0.5, 0.1)]
    made = server.call("RelievoEnhance", image=np.concatenate(dark), normal=ball["normal"])[0]
    assert made.shape == (3, 64, 64, 3)
    # The white level of the middle one is that of all three.
    np.testing.assert_array_equal(made[1], server.call("RelievoEnhance", image=dark[1], normal=ball["normal"])[0][0])
    alone = server.call("RelievoEnhance", image=dark[2], normal=ball["normal"])[0][0]
    assert np.abs(made[2] - alone).max() > 0.01
    drawings, _ = server.call("RelievoHatch", image=np.concatenate(dark), normal=ball["normal"])
    assert drawings.shape == (3, 64, 64, 3)
    with pytest.raises(ValueError, match="normal has 2 images, others have 3; give as many, or one for all"):
        server.call("RelievoEnhance", image=np.concatenate(dark), normal=ball["normal"].repeat(2, axis=0))


def test_progress_and_interruption(server, ball, monkeypatch):
    class Interrupted(BaseException):
        pass

    shown, limit = [], 1001

    class Bar:
        def __init__(self, total):
            assert total == 1000

        def update_absolute(self, value):
            shown.append(value)

    def throw_if_interrupted():
        if shown and shown[-1] > limit:
            raise Interrupted

    comfy, utils, management = (types.ModuleType(name) for name in ("comfy", "utils", "model_management"))
    utils.ProgressBar, management.throw_exception_if_processing_interrupted = Bar, throw_if_interrupted
    monkeypatch.setitem(sys.modules, "comfy", comfy)
    monkeypatch.setitem(sys.modules, "comfy.utils", utils)
    monkeypatch.setitem(sys.modules, "comfy.model_management", management)
    two = {name: batch.repeat(2, axis=0) for name, batch in ball.items()}
    server.call("RelievoEnhance", **two)
    assert shown == sorted(shown) and shown[-1] == 1000
    limit = 400
    shown.clear()
    with pytest.raises(Interrupted):
        server.call("RelievoEnhance", **two)
    assert shown[-1] < 1000


def test_a_render(server):
    """The bust, as a workflow has it: 8 bits of picture and normal map."""
    frame = pyrelievo.load(FIXTURES / "bust.exr")
    normal = np.where(frame.mask[..., None], 0.5 + 0.5 * frame.normal, 0)
    image = pyrelievo.enhance(frame, scaling=0, dtype=np.uint8)[..., :3] / np.float32(255)
    eight = {"image": image[None], "normal": (np.round(normal * 255) / 255).astype(np.float32)[None]}
    made = server.call("RelievoEnhance", **eight)[0][0]
    expected = pyrelievo.enhance(frame, dtype=np.uint8)[..., :3] / np.float32(255)
    assert np.abs(made - expected)[frame.mask].mean() < 2 / 255


def test_the_example_runs(server):
    """All four nodes are in it, and each preview shows something."""
    workflow = json.loads((PACKAGE / "example.json").read_text())
    used = {node["class_type"] for node in workflow.values()}
    assert used == {*NAMES, "LoadImage", "PreviewImage"}
    shown = server.run(workflow)
    assert len(shown) == len(NAMES)
    assert all(image.std() > 0.05 for image in shown)


def test_the_package_names_one_version():
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    relievo = tomllib.loads((PACKAGE.parents[1] / "Cargo.toml").read_text())["package"]
    assert project["version"] == relievo["version"]
    assert (PACKAGE / "requirements.txt").read_text().splitlines() == project["dependencies"]
