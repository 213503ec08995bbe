"""The examples run as they are, and give what they say."""

import base64
import io
import json
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest

import pyrelievo
from conftest import FIXTURES, channels_of

EXAMPLES = FIXTURES.parent / "hosts/python/examples"


def shot(*words):
    """Runs the example; returns what it says."""
    command = [sys.executable, "-W", "error", EXAMPLES / "shot.py", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ChildProcessError(done.stderr)
    return done.stdout


def test_a_shot_keeps_its_layers_and_gets_one_more(tmp_path):
    pattern, camera = FIXTURES / "wheel.####.exr", FIXTURES / "wheel.####.camera.json"
    words = [pattern, tmp_path / "out.####.exr", "--camera", camera, "scaling=0.8", "iterations=4"]
    assert shot(*words).startswith("2 frames: ")
    made = dict(pyrelievo.process(pattern, "enhance", roles={"camera": camera}, scaling=0.8, iterations=4))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.0001.exr", "out.0002.exr"]
    for number, picture in made.items():
        before = channels_of(FIXTURES / f"wheel.{number:04}.exr")
        after = channels_of(tmp_path / f"out.{number:04}.exr")
        for name, pixels in before.items():
            assert after.pop(name).tobytes() == pixels.tobytes()
        assert list(after) == [f"relievo.Picture.{end}" for end in "BGR"]
        enhanced = np.dstack([after[f"relievo.Picture.{end}"] for end in "RGB"])
        assert enhanced.dtype == np.float16
        np.testing.assert_array_equal(enhanced, picture.astype(np.float16))


def test_a_shot_in_parts(tmp_path):
    """A picture of bare channels in one part, view-space normals in another."""
    frame = pyrelievo.load(FIXTURES / "bust.exr")
    color, normal = frame.color.astype(np.float16), frame.normal.astype(np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    files = {
        "whole": OpenEXR.File(dict(header), {"RGB": color, **xyz(normal)}),
        "parts": OpenEXR.File(
            [OpenEXR.Part(dict(header), {"RGB": color}, "rgba"), OpenEXR.Part(dict(header), xyz(normal), "normal")]
        ),
    }
    for name, file in files.items():
        path = tmp_path / f"{name}.0007.exr"
        file.write(str(path))
        shot(tmp_path / f"{name}.####.exr", tmp_path / f"out.{name}.####.exr")
        after = channels_of(tmp_path / f"out.{name}.0007.exr")
        expected = pyrelievo.enhance(pyrelievo.load(path)).astype(np.float16)
        np.testing.assert_array_equal(after["relievo.Picture.G"], expected[..., 1])


def xyz(normal):
    return {f"normal.{end}": np.ascontiguousarray(normal[..., at]) for at, end in enumerate("XYZ")}


def test_a_shot_that_is_not_there(tmp_path):
    with pytest.raises(ChildProcessError, match=r"^error: .*no\.####\.exr: no frame of this name is there$"):
        shot(tmp_path / "no.####.exr", tmp_path / "out.####.exr")


def test_a_frame_goes_through_openimageio(tmp_path, bust):
    """All channels are kept in their types, and the added ones are the module's, in half floats.

    OpenImageIO reads half floats below the normal ones, 2^-14, as 0.
    """
    pytest.importorskip("OpenImageIO")
    out = tmp_path / "out.exr"
    subprocess.run([sys.executable, "-W", "error", EXAMPLES / "frame_oiio.py", bust, out, "scaling=0.8"], check=True)
    before, after = channels_of(bust), channels_of(out)
    for name, pixels in before.items():
        kept = after.pop(name)
        assert kept.dtype == pixels.dtype
        np.testing.assert_allclose(kept, pixels, rtol=0, atol=2**-14)
    assert sorted(after) == [f"relievo.Picture.{end}" for end in "BGR"]
    made = pyrelievo.enhance(pyrelievo.load(bust), scaling=0.8).astype(np.float16)
    for at, end in enumerate("RGB"):
        np.testing.assert_allclose(after[f"relievo.Picture.{end}"], made[..., at], rtol=0, atol=2**-14)


def test_the_notebook_runs():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    for module in ("ipykernel", "matplotlib", "PIL"):
        pytest.importorskip(module)
    path = EXAMPLES / "first_look.ipynb"
    assert all(not cell.get("outputs") for cell in json.loads(path.read_text())["cells"])
    notebook = nbformat.read(path, as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(EXAMPLES)}})
    client.execute()
    data = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", ())]
    shown = [kinds["image/png"] for kinds in data if "image/png" in kinds]
    # The render, two pictures, two curvatures, one relit, one drawing.
    assert len(shown) == 5
    assert all(picture_of(png).std() > 10 for png in shown)


def picture_of(png):
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(base64.b64decode(png))).convert("L"))
