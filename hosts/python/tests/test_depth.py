"""Arrays without normals: those of depth, heights or positions, as the command line makes them of files."""

import warnings

import numpy as np
import pytest

import pyrelievo

OpenEXR = pytest.importorskip("OpenEXR")
Image = pytest.importorskip("PIL.Image")

CAMERA = {"focal_px": 90}
GUESSED_CAMERA = "the camera is not known"
GUESSED_NEAR = "white is taken for near"
# Of an array alone: in the file the layer's own name tells nothing either, but it stands beside the picture.
GUESSED_DISTANCE = "nothing says whether it is distance"
GUESSED_HEIGHT = "how high heights are is not known"


@pytest.fixture
def relief():
    """Waves from 0 to 1, and a picture of them."""
    y, x = np.mgrid[0:48, 0:64].astype(np.float32)
    waves = 0.5 + 0.3 * np.sin(x / 9) * np.cos(y / 7) + 0.002 * x
    return {"waves": waves, "color": np.dstack([waves, waves, 1 - waves]).astype(np.float32)}


def eight_bits(layer):
    return np.round(layer * 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("name", "stored", "settings", "guessed"),
    [
        ("depth", lambda waves: 3 - waves, {}, [GUESSED_DISTANCE, GUESSED_CAMERA]),
        ("depth", lambda waves: 3 - waves, {"camera": CAMERA}, [GUESSED_DISTANCE]),
        ("depth", lambda waves: (3 - waves).astype(np.float16), {"camera": CAMERA}, [GUESSED_DISTANCE]),
        ("depth", lambda waves: 3 - waves, {"camera": CAMERA, "depth_kind": "distance"}, []),
        ("depth", lambda waves: waves, {}, [GUESSED_NEAR, GUESSED_CAMERA]),
        ("depth", eight_bits, {"camera": CAMERA}, [GUESSED_NEAR]),
        ("depth", eight_bits, {"depth_kind": "white-far"}, [GUESSED_CAMERA]),
        ("depth", lambda waves: 8 * waves, {"depth_kind": "height"}, [GUESSED_HEIGHT]),
        ("height", lambda waves: 8 * waves, {}, [GUESSED_HEIGHT]),
        ("height", eight_bits, {}, [GUESSED_HEIGHT]),
        ("height", eight_bits, {"height_scale": 7.5}, []),
    ],
)
def test_arrays_are_read_as_files_are(relief, tmp_path, name, stored, settings, guessed):
    """The normals, the picture and the warnings are those of the same samples in files."""
    layer = stored(relief["waves"])
    picture, roles = tmp_path / "picture.exr", dict(settings)
    channels = {"RGB": relief["color"]}
    if layer.dtype == np.uint8:
        Image.fromarray(layer).save(tmp_path / "layer.png")
        roles[name] = tmp_path / "layer.png"
    else:
        channels["measured"] = layer
        roles[name] = "measured"
    with OpenEXR.File({"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}, channels) as file:
        file.write(str(picture))
    if "camera" in roles:
        roles["camera"] = tmp_path / "camera.json"
        roles["camera"].write_text('{"focal_px": 90}')
    of_file = pyrelievo.load(picture, **roles)
    of_arrays = pyrelievo.Frame(relief["color"], **{name: layer}, **settings)
    assert of_arrays.mask.mean() > 0.98
    np.testing.assert_array_equal(of_arrays.normal, of_file.normal)
    np.testing.assert_array_equal(of_arrays.depth, of_file.depth)
    assert len(of_arrays.warnings) == len(guessed)
    assert all(what in said for what, said in zip(guessed, of_arrays.warnings, strict=True))
    # Beside them files tell that there is no layer of normals.
    others = [said for said in of_file.warnings if said not in of_arrays.warnings]
    assert len(others) == 1 and others[0].startswith("normals from ")
    pictures = []
    for frame in (of_arrays, of_file):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            pictures.append(pyrelievo.enhance(frame, scaling=1))
        assert [str(one.message) for one in told] == frame.warnings
    np.testing.assert_array_equal(*pictures)


def test_positions_are_a_surface_too():
    """A wall that leans by 0.25 to the right of the view: its normal is (-0.25, 0, 1) over its length."""
    y, x = np.mgrid[0:32, 0:40] + 0.5
    right, up = (x - 20) / 90, (16 - y) / 90
    depth = 4 / (1 + 0.25 * right)
    position = np.dstack([right * depth, up * depth, -depth])
    # z = -4 + 0.25 x, whose normal toward the viewer is (-0.25, 0, 1).
    frame = pyrelievo.Frame(position=position, camera={**CAMERA, "world_to_camera": np.eye(4)})
    expected = np.array([-0.25, 0, 1]) / np.hypot(0.25, 1)
    np.testing.assert_allclose(frame.normal, np.broadcast_to(expected, position.shape), atol=1e-4)
    assert frame.warnings == []
    with pytest.raises(ValueError, match="^position is in world space, and there is no camera; give one"):
        pyrelievo.Frame(position=position)


def test_alpha_tells_where_depth_is():
    """Depth that is white near marks nothing itself: what is transparent is no surface."""
    depth = np.full((16, 16), 0.5, np.float32)
    color = np.ones((16, 16, 4), np.float32)
    color[:, :6] = 0
    frame = pyrelievo.Frame(color, depth=depth, depth_kind="white-near", camera=CAMERA)
    np.testing.assert_array_equal(frame.mask, color[..., 3] > 0)


@pytest.mark.parametrize("function", ["enhance", "relight", "shape", "hatch", "map"])
@pytest.mark.parametrize("layer", ["depth", "height"])
def test_every_function_takes_them_for_normals(relief, function, layer):
    called = getattr(pyrelievo, function)
    leading = (relief["color"],) if function == "enhance" else ()
    settings = {"height_scale": 20} if layer == "height" else {"depth_kind": "white-near", "camera": CAMERA}
    given = {"light": (135, 40)} if function == "relight" else {}
    made = called(*leading, **{layer: relief["waves"]}, **settings, **given)
    normal = pyrelievo.Frame(**{layer: relief["waves"]}, **settings).normal
    assert np.linalg.norm(normal, axis=2) == pytest.approx(1, abs=1e-5)
    match function:
        case "shape":
            assert made.kappa.std() > 0.1
        case "map":
            assert made["curvature"].std() > 0.01
        case _:
            assert np.asarray(made).std() > 0.01


@pytest.mark.parametrize(
    ("names", "settings", "said"),
    [
        ("", {}, "^normal is missing; give it, or what shows the surface: depth, height, or position with a camera$"),
        ("height normal", {}, "^height stands for normals, depth and camera, and normal is given too; leave one"),
        ("height depth", {}, "and depth is given too"),
        ("height", {"camera": CAMERA}, "and camera is given too"),
        ("height", {"depth_kind": "z"}, "and depth_kind is given too"),
        ("depth", {"height_scale": 3}, "^height_scale is given, and no height; give height, or leave it out$"),
        ("height", {"height_scale": float("nan")}, "^--height-scale is NaN; give pixels$"),
        ("", {"depth": np.zeros((48, 64, 3))}, "^depth has 3 channels; give 1$"),
        ("", {"depth": np.zeros((48, 63))}, "is 48 rows of 64, for 63x48 pixels"),
        ("", {"depth": np.zeros((0, 4)), "color": None}, "give at least one pixel"),
    ],
)
def test_what_cannot_be_used_is_said(relief, names, settings, said):
    shown = {"normal": relief["color"], "depth": relief["waves"], "height": relief["waves"]}
    layers = {name: shown[name] for name in names.split()}
    with pytest.raises(ValueError, match=said):
        pyrelievo.enhance(**{"color": relief["color"], **layers, **settings})


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2)])
@pytest.mark.parametrize("value", [0, 1, 0.5, -3, 1e30, np.nan, np.inf, 65504])
@pytest.mark.filterwarnings("ignore")
def test_hostile_samples_give_a_picture(shape, value):
    for layers in [{"depth": np.full(shape, value, np.float32)}, {"height": np.full(shape, value, np.float32), "height_scale": 1e30}]:
        made = pyrelievo.enhance(np.ones((*shape, 3), np.float32), **layers)
        assert np.isfinite(made).all()
