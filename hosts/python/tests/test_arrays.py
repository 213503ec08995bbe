"""Arrays of any kind give the right result, or one exception that tells what to give."""

import numpy as np
import pytest

import pyrelievo


def test_what_is_taken_for_the_same(ball):
    """Layouts and types that hold the same numbers give the same picture."""
    expected = pyrelievo.enhance(**ball)
    normal = ball["normal"]
    flipped = normal[::-1, ::-1].copy()[::-1, ::-1]
    wide = np.zeros((64, 128, 4), np.float32)
    wide[:, ::2, :3] = normal
    planar = np.ascontiguousarray(normal.transpose(2, 0, 1)).transpose(1, 2, 0)
    swapped = normal.astype(normal.dtype.newbyteorder(">"))
    read_only = normal.copy()
    read_only.flags.writeable = False
    same = [flipped, wide[:, ::2, :3], np.asfortranarray(normal), planar, swapped, normal.astype(np.float64), read_only]
    for other in same:
        kept = np.array(other, copy=True)
        np.testing.assert_array_equal(pyrelievo.enhance(**{**ball, "normal": other}), expected)
        np.testing.assert_array_equal(other, kept)


def test_types_that_round(ball):
    """Half floats are off by their rounding; integers of normals count as 0..1, those of colours as sRGB."""
    half = pyrelievo.Frame(**{name: layer.astype(np.float16) for name, layer in ball.items()})
    # A component below 1 rounds by at most 2^-12.
    inside = half.mask & pyrelievo.Frame(**ball).mask
    assert np.abs(half.normal - ball["normal"])[inside].max() < 2**-11
    stored = np.round((0.5 * ball["normal"] + 0.5) * 65535).astype(np.uint16)
    sixteen = pyrelievo.Frame(normal=stored, coverage=inside)
    assert np.abs(sixteen.normal - ball["normal"])[inside].max() < 2 / 65535
    grey = pyrelievo.Frame(color=np.full((64, 64, 3), 188, np.uint8), normal=ball["normal"])
    # sRGB 188 is ((188/255 + .055)/1.055)^2.4.
    assert abs(grey.color[5, 5, 0] - ((188 / 255 + 0.055) / 1.055) ** 2.4) < 1e-6


def test_out_is_written_in_place(ball):
    frame = pyrelievo.Frame(**ball)
    expected = pyrelievo.enhance(frame)
    for out in [np.empty((64, 64, 3), np.float32), np.empty((3, 64, 64), np.float32).transpose(1, 2, 0)]:
        assert pyrelievo.enhance(frame, out=out) is out
        np.testing.assert_array_equal(out, expected)
    fixed = np.empty((64, 64, 3), np.float32)
    fixed.flags.writeable = False
    for out in [np.empty((64, 64)), np.empty((64, 63, 3), np.float32), fixed, np.empty((64, 64, 3)), "out"]:
        with pytest.raises(ValueError, match=r"^out .*give a writable float32 array of the shape \(64, 64, 3\)"):
            pyrelievo.enhance(frame, out=out)


@pytest.mark.parametrize(
    ("layer", "array", "error", "said"),
    [
        ("normal", np.zeros((64, 64), np.float32), ValueError, "normals has 1 channels; give 3 or 4"),
        ("normal", np.zeros(5, np.float32), ValueError, r"normal has the shape \(5,\)"),
        ("normal", np.zeros((0, 4, 3), np.float32), ValueError, "at least one pixel"),
        ("normal", np.zeros((4, 4, 3), complex), TypeError, "normal holds complex128"),
        ("normal", np.zeros((4, 4, 3), np.int64), TypeError, "normal holds int64"),
        ("normal", object(), TypeError, "normal is no array of numbers"),
        ("normal", "Normal", ValueError, "normal is 'Normal'|no such file|cannot open|No such file"),
        ("depth", np.zeros((64, 63), np.float32), ValueError, "depth"),
        ("color", np.zeros((64, 64, 2), np.float32), ValueError, "color has 2 channels; give 1, 3 or 4"),
        ("mask", np.zeros((3, 3), np.float32), ValueError, "mask"),
    ],
)
def test_what_cannot_be_used_is_said(ball, layer, array, error, said):
    with pytest.raises(error, match=said):
        pyrelievo.enhance(**{**ball, layer: array})


@pytest.mark.parametrize(
    ("command", "settings"),
    [
        ("enhance", {"object": "Head"}),
        ("relight", {"albedo": "Albedo", "light": (135, 40)}),
        ("relight", {"material": "mirror", "surroundings": "around.exr"}),
        ("hatch", {"object_angle": "Head=30"}),
        ("enhance", {"light_group": "key=135,40"}),
    ],
)
def test_arrays_have_no_layers_to_name(ball, command, settings):
    """A setting that would be left unheeded is refused."""
    color, normal = ball["color"], ball["normal"]
    leading = (color, normal) if command == "enhance" else (normal,)
    with pytest.raises(ValueError, match="the frame is made of arrays: leave it out, or load a file"):
        getattr(pyrelievo, command)(*leading, **settings)


def test_enlargements_keep_to_memory():
    """A billion pixels take 164 GB, more than there is."""
    normal = np.broadcast_to(np.float32([0, 0, 1]), (2000, 2000, 3))
    with pytest.raises(ValueError, match="^--enlarge makes a drawing of 32000x32000 pixels, and memory for it is not"):
        pyrelievo.hatch(normal, enlarge=16)


def test_numbers_that_are_none(ball):
    """NaN and infinity are pixels without surface, and leave others as they are."""
    normal = ball["normal"].copy()
    normal[10:12, 30:33] = np.nan
    normal[40, 40] = np.inf
    color = ball["color"].copy()
    color[20, 20] = np.nan
    made = pyrelievo.enhance(color, normal, depth=ball["depth"])
    assert np.isfinite(made).all()
    for command in (pyrelievo.shape, pyrelievo.hatch, pyrelievo.map):
        command(np.full((9, 7, 3), np.nan, np.float32))
    assert pyrelievo.enhance(np.ones((1, 1, 3), np.float32), [[[0.0, 0.0, 1.0]]]).shape == (1, 1, 3)


def test_a_mask_tells_how_far_a_picture_is_changed(ball):
    """Half of a mask of 0.5 is the mean of both pictures, and where it is 0 nothing is changed."""
    mask = np.full((64, 64), 0.5, np.float32)
    mask[:, :32] = 0
    whole = pyrelievo.enhance(**ball, scaling=1)
    half = pyrelievo.enhance(**ball, mask=mask, scaling=1)
    np.testing.assert_array_equal(half[:, :32], ball["color"][:, :32])
    np.testing.assert_allclose(half[:, 32:], 0.5 * (whole + ball["color"])[:, 32:], atol=1e-6)
    # Of a shape it tells where the surface is.
    kappa = pyrelievo.shape(ball["normal"], mask=mask + 0.25).kappa
    assert (kappa[:, :31] == 0).all() and (kappa[20:40, 40] > 0).all()


def test_objects_are_a_mask_of_their_own(ball):
    """Chosen by number, a ball is changed and nothing else; a mask and an object are multiplied."""
    ids = np.full((64, 64), 3, np.uint16)
    ids[:, 32:] = 7
    whole = pyrelievo.enhance(**ball)
    chosen = pyrelievo.enhance(**ball, object=ids == 7)
    np.testing.assert_allclose(chosen, np.where(ids[..., None] == 7, whole, ball["color"]), atol=1e-6)
    assert np.abs(chosen - ball["color"]).max() > 0.01
    shares = np.where(ids == 7, np.float32(0.5), np.nan)
    product = pyrelievo.enhance(**ball, object=shares, mask=np.full((64, 64), 0.5, np.float32))
    quarter = np.where(ids == 7, np.float32(0.25), 0)
    np.testing.assert_array_equal(product, pyrelievo.enhance(**ball, mask=quarter))
    for numbers in (ids, ids.astype(np.int64), ids.astype(np.float32)):
        with pytest.raises(ValueError, match="^object holds numbers of objects; give where .* are, as ids == 7"):
            pyrelievo.enhance(**ball, object=numbers)
    with pytest.raises(ValueError, match="the frame is made of arrays: leave it out, or load a file"):
        pyrelievo.enhance(**ball, object=["Head", "!Ball"])


def test_normals_of_depth():
    """Two planes in perspective: steps between their points lie in them, so normals are exact up to rounding."""
    focal = 200
    y, x = np.mgrid[0:48, 0:64] + 0.5
    rays = np.dstack([(x - 32) / focal, (24 - y) / focal, np.full_like(x, -1)])
    tilted, far = np.array([0.48, -0.36, 0.8]), np.array([0, 0, 1.0])
    # n . (d ray) = n . p for a point p of the plane.
    depth = np.where(x < 32, -2 * 0.8 / (rays @ tilted), -6 / (rays @ far))
    depth[:, :4] = 0
    expected = np.where((x < 32)[..., None], tilted, far)
    expected[:, :4] = 0
    camera = {"focal_px": focal}
    made = pyrelievo.normals(depth, camera)
    # Depth rounds by up to 2^-24 of itself, focal * 2^-24 = 1.2e-5 of a step; a step to one side has two such ends.
    np.testing.assert_allclose(made, expected, atol=4e-5)
    distance = depth * np.linalg.norm(rays, axis=2)
    np.testing.assert_allclose(pyrelievo.normals(distance, camera, depth_kind="distance"), expected, atol=4e-5)
    # Without a camera it is one 1.25 of the longer side away: told, since slopes follow from it.
    with pytest.warns(UserWarning, match="^the camera is not known"):
        guessed = pyrelievo.normals(depth)
    np.testing.assert_array_equal(guessed, pyrelievo.normals(depth, {"focal_px": 1.25 * 64}))
    with pytest.raises(ValueError, match="^depth has 3 channels; give 1"):
        pyrelievo.normals(expected, camera)


def test_tensors_go_through_dlpack(ball):
    class Tensor:
        """What offers its memory by DLPack alone."""

        def __init__(self, array):
            self.array = array

        def __dlpack__(self, **options):
            return self.array.__dlpack__(**options)

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    tensors = {name: Tensor(layer) for name, layer in ball.items()}
    np.testing.assert_array_equal(pyrelievo.enhance(**tensors), pyrelievo.enhance(**ball))


def test_world_normals_take_a_camera(ball):
    """A camera that is turned by a quarter about its axis turns normals with it."""
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], np.float32)
    camera = {"world_to_camera": np.block([[turn, np.zeros((3, 1))], [np.zeros((1, 3)), 1]]), "focal_px": 100}
    frame = pyrelievo.Frame(normal=ball["normal"] @ turn, camera=camera, normal_space="world")
    np.testing.assert_allclose(frame.normal, pyrelievo.Frame(normal=ball["normal"]).normal, atol=1e-6)
    with pytest.raises(ValueError, match="camera is missing"):
        pyrelievo.Frame(normal=ball["normal"], normal_space="world")
    with pytest.raises(ValueError, match="^camera has neither|^camera "):
        pyrelievo.Frame(normal=ball["normal"], camera={"focal": 3})
