"""The Python of the README and the guide runs, in a folder of its own, and gives what the command line writes."""

import re

import numpy as np
import pytest
from PIL import Image

from conftest import FIXTURES
from test_command_line import relievo

ROOT = FIXTURES.parent
BLOCKS = [
    (page, code)
    for page in ("README.md", "docs/guide/python.md")
    for code in re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)
]


@pytest.mark.parametrize(("page", "code"), BLOCKS, ids=lambda value: value.splitlines()[0][:20])
@pytest.mark.filterwarnings("default")
def test_blocks_run(page, code, tmp_path, monkeypatch):
    (tmp_path / "fixtures").symlink_to(FIXTURES)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, page, "exec"), {})


def test_the_readmes_example_is_the_command_lines(tmp_path, monkeypatch):
    (tmp_path / "fixtures").symlink_to(FIXTURES)
    monkeypatch.chdir(tmp_path)
    (code,) = (code for page, code in BLOCKS if page == "README.md")
    made = {}
    exec(code, made)
    assert relievo(["enhance", "fixtures/bust.exr", "-o", "out.png", "-q"]) == 0
    shown = np.asarray(Image.open("out.png").convert("RGB"), np.float32) / 255
    # Where the display keeps to sRGB, below its shoulder, half a step of 8 bits.
    linear = made["picture"].astype(np.float64).clip(0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    alpha = made["frame"].alpha
    whole = (encoded.max(axis=2) < 0.5) & (alpha == 1 if alpha is not None else True)
    assert whole.sum() > 1000
    assert np.abs(encoded - shown)[whole].max() <= 0.5 / 255 + 1e-6
