"""Functions, their settings, and how they end."""

import doctest
import inspect
import os
import re
import signal
import threading
import time

import numpy as np
import pytest

import pyrelievo
from pyrelievo import _relievo

FUNCTIONS = [pyrelievo.enhance, pyrelievo.relight, pyrelievo.shape, pyrelievo.hatch, pyrelievo.map]


def test_examples_run(ball):
    done = doctest.testmod(pyrelievo, extraglobs={"pyrelievo": pyrelievo, **ball})
    assert done.attempted >= 6 + len(FUNCTIONS) and done.failed == 0


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_every_setting_is_an_argument(function):
    parameters = inspect.signature(function).parameters
    for row in _relievo.settings(function.__name__):
        keyword = {"as": "as_"}.get(row["name"], row["name"].replace("-", "_"))
        if row["group"] in ("Inputs", "Output", "Sequence") or row["name"] == "bits":
            continue
        assert keyword in parameters, keyword
        assert parameters[keyword].kind is parameters[keyword].KEYWORD_ONLY
        assert f"\n{keyword}" in function.__doc__
    assert not re.search("--[a-z]", function.__doc__)


def test_settings_are_checked(ball):
    for settings, error, said in [
        ({"scaling": -1}, ValueError, "^--scaling is -1; give 0"),
        ({"scaling": "strong"}, ValueError, "invalid value 'strong' for '--scaling"),
        ({"curvature": 1}, TypeError, "unexpected keyword argument 'curvature'"),
        ({"solver": "magic"}, ValueError, "possible values: chebyshev, explicit"),
        ({"dtype": "int16"}, ValueError, "give float32, or uint8"),
        ({"progress": 3}, TypeError, "not callable"),
    ]:
        with pytest.raises(error, match=said):
            pyrelievo.enhance(**ball, **settings)
    with pytest.raises(TypeError, match="out takes a picture"):
        pyrelievo.shape(ball["normal"], out=ball["color"])
    with pytest.raises(TypeError, match="without anything"):
        pyrelievo.shape(None)
    with pytest.warns(UserWarning, match="is past 1.19"):
        pyrelievo.enhance(**ball, scaling=1.5)


def test_a_picture_that_is_missing(ball):
    for lacking in [
        lambda: pyrelievo.enhance(None, ball["normal"]),
        lambda: pyrelievo.enhance(None, ball["normal"], scaling=0),
        lambda: pyrelievo.hatch(ball["normal"], tone="picture"),
        lambda: pyrelievo.relight(ball["normal"], light=(135, 40), albedo_from="estimate"),
    ]:
        with pytest.raises(ValueError, match="picture"):
            lacking()


def test_a_fault_of_our_own_is_an_exception():
    """A frame with more samples than addresses, of one byte, is refused by nobody before its planes are made."""
    normal = np.broadcast_to(np.uint8(255), (2**31 - 2, 2**30 + 2**20, 3))
    with pytest.raises(RuntimeError, match=r"^a fault of relievo itself \(capacity overflow at .+\); please report it$"):
        pyrelievo.Frame(normal=normal)


@pytest.mark.parametrize("number", [0, 1, 7.0, True, False, np.int64(0), ["camera.json"]])
def test_numbers_are_no_files(ball, number):
    depth = ball["depth"]
    for opens in [
        lambda: pyrelievo.normals(depth, number),
        lambda: pyrelievo.Frame(normal=ball["normal"], camera=number),
        lambda: pyrelievo.shape(ball["normal"], depth=depth, camera=number),
    ]:
        with pytest.raises(TypeError, match="^camera is .*; give a dict, or the path of a file$"):
            opens()
    for opens in [pyrelievo.load, pyrelievo.Recipe.read, pyrelievo.Recipe("enhance").write]:
        with pytest.raises(TypeError):
            opens(number)
    with pytest.raises(TypeError):
        next(pyrelievo.process(number, "shape"))


def test_files_that_are_not_there(bust, tmp_path):
    with pytest.raises(FileNotFoundError):
        pyrelievo.load(tmp_path / "none.exr")
    with pytest.raises(FileNotFoundError):
        pyrelievo.enhance(str(tmp_path / "none.exr"))
    with pytest.raises(FileNotFoundError):
        list(pyrelievo.process(str(tmp_path / "none.####.exr"), "shape"))
    broken = tmp_path / "broken.exr"
    with open(bust, "rb") as whole:
        broken.write_bytes(whole.read(5000))
    with pytest.raises(OSError, match="broken.exr"):
        pyrelievo.load(broken).color
    with pytest.raises(ValueError, match="^object is 'Head'; give an array, or load"):
        pyrelievo.Frame(normal=np.ones((4, 4, 3), np.float32), object="Head")


def test_frames_tell_how_they_were_read(bust):
    frame = pyrelievo.load(bust)
    assert frame.shape == (360, 480) and frame.path == bust
    assert any(f.subject == "normal space" and f.conclusion == "world" for f in frame.findings)
    assert frame._repr_png_().startswith(b"\x89PNG")
    lengths = np.linalg.norm(frame.normal, axis=2)
    assert lengths.max() < 1 + 1e-5 and (lengths[~frame.mask] == 0).all()


def test_progress_is_told_and_may_raise(ball):
    told = []
    pyrelievo.enhance(**ball, progress=lambda stage, done: told.append((stage, done)))
    assert told[-1] == ("done", 1.0) and [done for _, done in told] == sorted(done for _, done in told)

    def stop(stage, done):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        pyrelievo.enhance(**ball, progress=stop)


def waves(rows, columns):
    """Normals of waves, and a picture."""
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float32)
    slopes = [0.5 * np.sin(x / 17) * np.cos(y / 23), 0.5 * np.cos(x / 31) * np.sin(y / 11)]
    normal = np.dstack([*slopes, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return np.repeat(normal[..., 2:], 3, axis=2), normal


def test_ctrl_c_stops_a_run():
    frame = pyrelievo.Frame(*waves(1500, 1500))
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        # Half a minute and more, if nobody stops it.
        pyrelievo.shape(frame, iterations=50_000, solver="explicit")
    timer.join()


def test_enlarging_tells_its_progress_and_can_be_interrupted(ball):
    told = []

    def tell(stage, done):
        told.append((stage, done))

    def interrupt(stage, done):
        tell(stage, done)
        os.kill(os.getpid(), signal.SIGINT)

    pyrelievo.hatch(**ball, enlarge=2, progress=tell)
    stages, shares = zip(*told, strict=True)
    assert stages[0] == "enlarge" and told[-1] == ("done", 1.0)
    assert list(shares) == sorted(shares) and stages.count("enlarge") > 5
    told.clear()
    with pytest.raises(KeyboardInterrupt):
        # Enlarging takes seconds, and a minute what comes after it.
        pyrelievo.hatch(*waves(400, 400)[1:], color=waves(400, 400)[0], enlarge=8, progress=interrupt)
    assert {stage for stage, _ in told} == {"enlarge"}


def test_other_threads_go_on_meanwhile():
    """Python runs while the engine does: a second thread counts on."""
    frame = pyrelievo.Frame(*waves(700, 700))
    counted, is_over = 0, False

    def count():
        nonlocal counted
        while not is_over:
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    pyrelievo.shape(frame, iterations=2000, solver="explicit", engine=pyrelievo.Engine(threads=1))
    is_over = True
    thread.join()
    assert counted > 10


def test_two_threads_give_what_one_gives(ball):
    expected = pyrelievo.hatch(**ball).paper
    engine, made = pyrelievo.Engine(threads=1), [None] * 4

    def draw(at):
        made[at] = pyrelievo.hatch(**ball, engine=engine).paper

    threads = [threading.Thread(target=draw, args=(at,)) for at in range(len(made))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for paper in made:
        np.testing.assert_array_equal(paper, expected)


def test_a_thousand_runs_keep_no_memory(ball):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    frame = pyrelievo.Frame(**ball)
    for _ in range(200):
        pyrelievo.enhance(frame)
    before = resident()
    for _ in range(1000):
        pyrelievo.enhance(frame)
        pyrelievo.Frame(**ball)
    # A picture that stays would add 1,000 times 48 KiB.
    assert resident() - before < 8 << 20


def test_engines_are_checked():
    assert pyrelievo.Engine(threads=3, backend="cpu")
    for threads in [0, 513]:
        with pytest.raises(ValueError, match=f"^threads is {threads}; give 1 to 512$"):
            pyrelievo.Engine(threads=threads)
    with pytest.raises(ValueError, match="give auto, cpu or gpu"):
        pyrelievo.Engine(backend="tpu")
