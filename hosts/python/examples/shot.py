#!/usr/bin/env python3
"""Enhances a shot in memory: frames keep all their layers, and get one more, relievo.Picture.

    python shot.py 'in/shot.####.exr' 'out/shot.####.exr' --camera 'in/shot.####.camera.json' scaling=0.8

relievo finds what the layers mean, and what it chooses automatically, such as the curvature gain, it chooses once for the
shot. OpenEXR adds the picture to the channels that are there, so whatever else a pipeline does to arrays can come before
or after. --camera is only for normals in world space; its files are those of `relievo --camera`.

Needs NumPy, pyrelievo and OpenEXR, all by pip.
"""

import argparse
import os
import re
import sys

import numpy as np
import OpenEXR

import pyrelievo


def numbered(pattern: str, number: int) -> str:
    """The name of a frame: #### is its number."""
    return re.sub("#+", lambda marks: f"{number:0{len(marks[0])}d}", pattern)


def write_with(source: str, output: str, picture: np.ndarray) -> None:
    """Copies a frame, with the picture as one more layer, in half floats."""
    with OpenEXR.File(source, separate_channels=True) as file:
        for end, plane in zip("RGB", np.moveaxis(picture, 2, 0), strict=True):
            name = f"relievo.Picture.{end}"
            file.parts[0].channels[name] = OpenEXR.Channel(name, plane.astype(np.float16))
        for part in file.parts:
            # Lossy compression would take from the layers again.
            part.header["compression"] = OpenEXR.ZIP_COMPRESSION
        # Under its own name only when it is whole.
        file.write(f"{output}.part")
        os.replace(f"{output}.part", output)


def enhance_shot(pattern: str, output: str, camera: str | None = None, **settings) -> list[int]:
    """Enhances all frames of a shot; returns their numbers."""
    frames = []
    for number, picture in pyrelievo.process(pattern, "enhance", roles={"camera": camera}, **settings):
        write_with(numbered(pattern, number), numbered(output, number), picture)
        frames.append(number)
    return frames


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", help="frames to read, with #### for the number")
    parser.add_argument("output", help="frames to write")
    parser.add_argument("--camera", help="cameras of the frames, with #### for the number")
    parser.add_argument("settings", nargs="*", metavar="SETTING=VALUE", help="as of pyrelievo.enhance")
    given = parser.parse_intermixed_args()
    settings = dict(setting.split("=", 1) for setting in given.settings)
    try:
        frames = enhance_shot(given.input, given.output, given.camera, **settings)
    except (OSError, ValueError) as error:
        sys.exit(f"error: {error}")
    print(f"{len(frames)} frames: {numbered(given.output, frames[0])} to {numbered(given.output, frames[-1])}")


if __name__ == "__main__":
    main()
