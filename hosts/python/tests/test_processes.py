"""Processes that are forked, spawned or served do what the one does that started them; none waits for ever."""

import gc
import hashlib
import multiprocessing
import os
import signal
import threading
import time

import numpy as np
import pytest

import pyrelievo
from conftest import FIXTURES, ball_layers
from pyrelievo import _relievo

BUST = str(FIXTURES / "bust.exr")

#: Seconds after which a worker counts as hanging; it takes one or two.
PATIENCE = 60

#: From 3.12 on Python warns of threads at each fork.
pytestmark = pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")


LAYERS = ball_layers()
COLOR, NORMAL = LAYERS["color"], LAYERS["normal"]
ENGINE = pyrelievo.Engine(threads=2)


def command_line(folder):
    """The codes of two commands: one has threads of its own, the other the module's."""
    out = str(folder / f"{os.getpid()}.png")
    commands = ["inspect", BUST], ["enhance", BUST, "-q", "-o", out]
    return bytes(_relievo.run_command_line(["relievo", *words]) for words in commands)


#: What workers do, by name: of a folder to write in.
CALLS = {
    "by_engine": lambda _: pyrelievo.enhance(COLOR, NORMAL, engine=ENGINE),
    "by_frame": lambda _: pyrelievo.Frame(COLOR, NORMAL).normal,
    "findings": lambda _: repr(pyrelievo.load(BUST).findings).encode(),
    "thumbnail": lambda _: pyrelievo.load(BUST)._repr_png_(),
    "enhanced": lambda _: pyrelievo.enhance(COLOR, NORMAL, out=np.empty_like(COLOR)),
    "shown": lambda _: pyrelievo.enhance(BUST, dtype=np.uint8),
    "relit": lambda _: pyrelievo.relight(NORMAL, light=(135, 40)),
    "shape": lambda _: pyrelievo.shape(NORMAL, scale=(2, 4)).kappa,
    "drawn": lambda _: pyrelievo.hatch(NORMAL, color=COLOR, enlarge=2).svg().encode(),
    "maps": lambda _: pyrelievo.map(NORMAL, map=("curvature", "height"))["height"],
    "normals": lambda _: pyrelievo.normals(np.full((40, 40), 2.0), {"focal_px": 100}),
    "sequence": lambda _: [made.kappa for _, made in pyrelievo.process(str(FIXTURES / "wheel.####.exr"), "shape")][-1],
    "recipe": lambda _: pyrelievo.Recipe.parse(pyrelievo.Recipe("enhance", scaling=0.7).toml())(COLOR, NORMAL),
    "settings": lambda _: repr(_relievo.settings("hatch")).encode(),
    "command_line": command_line,
}


def digest(call, folder):
    return hashlib.sha256(CALLS[call](folder)).hexdigest()


def digests(calls, folder):
    return [digest(call, folder) for call in calls]


def worked(method, work, *given):
    """What a worker makes of it, of a pool that then ends, as the signal tells it to."""
    with multiprocessing.get_context(method).Pool(1) as pool:
        return pool.apply_async(work, given).get(timeout=PATIENCE)


@pytest.mark.parametrize("call", CALLS)
def test_after_a_fork_each_call_is_as_before(call, tmp_path):
    expected = digest(call, tmp_path)
    assert worked("fork", digest, call, tmp_path) == expected


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_workers_of_each_kind_do_all_calls(method, tmp_path):
    expected = digests(list(CALLS), tmp_path)
    assert worked(method, digests, list(CALLS), tmp_path) == expected


def grandchild(folder):
    """What a worker's own child makes, after both did the same."""
    read, write = os.pipe()
    digest("by_engine", folder)
    if os.fork() == 0:
        os.write(write, digest("by_engine", folder).encode())
        os._exit(0)
    os.close(write)
    with open(read) as file:
        return file.read()


def test_a_fork_of_a_fork(tmp_path):
    expected = digest("by_engine", tmp_path)
    assert worked("fork", grandchild, tmp_path) == expected


def test_a_fork_in_the_middle_of_a_run(tmp_path):
    """Locks that another thread holds as the process is forked are held by nobody in the child."""
    frame, begun, over = pyrelievo.Frame(np.tile(COLOR, (8, 8, 1)), np.tile(NORMAL, (8, 8, 1))), threading.Event(), []

    def run():
        def stop(stage, done):
            begun.set()
            if over:
                raise InterruptedError

        with pytest.raises(InterruptedError):
            while True:
                pyrelievo.hatch(frame, engine=ENGINE, progress=stop)

    expected = digest("by_engine", tmp_path)
    thread = threading.Thread(target=run)
    thread.start()
    assert begun.wait(PATIENCE)
    try:
        for _ in range(10):
            assert worked("fork", digest, "by_engine", tmp_path) == expected
    finally:
        over.append(True)
        thread.join()


def waits(ready):
    ready.set()
    time.sleep(PATIENCE)


def test_a_worker_ends_by_a_signal_after_a_command_line(tmp_path):
    """The thread that hears signals for the command line is not there to end it."""
    command_line(tmp_path)
    context = multiprocessing.get_context("fork")
    ready = context.Event()
    worker = context.Process(target=waits, args=(ready,))
    worker.start()
    assert ready.wait(PATIENCE)
    worker.terminate()
    worker.join(PATIENCE / 2)
    assert worker.exitcode == -signal.SIGTERM


def device():
    try:
        return str(pyrelievo.Engine(backend="gpu"))
    except RuntimeError as error:
        return str(error)


def test_a_gpu_does_not_survive_a_fork(tmp_path):
    if device().startswith("no GPU"):
        pytest.skip(device())
    assert worked("fork", device).startswith("no GPU: its driver belongs to the process that this one was forked off")
    # By default the CPU does it then.
    assert worked("fork", digest, "enhanced", tmp_path)


def without_engine():
    """Drops an engine of the parent, whose threads are not there to be joined."""
    global ENGINE
    del ENGINE
    return gc.collect() >= 0


def test_an_engine_of_the_parent_can_be_dropped():
    pyrelievo.enhance(COLOR, NORMAL, engine=ENGINE)
    assert worked("fork", without_engine)
