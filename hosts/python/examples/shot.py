#!/usr/bin/env python3
"""Enhances a shot in memory: frames keep all their layers, and get one more, relievo.Picture.

    python shot.py 'in/shot.####.exr' 'out/shot.####.exr' --camera 'in/shot.####.camera.json' scaling=0.8

OpenEXR reads and writes, so layers are arrays, and whatever else a pipeline does to them can come before or after. What
relievo chooses automatically, such as the curvature gain, it chooses once for the shot. --camera is only for normals in
world space; its files are those of `relievo --camera`, for frames whose data window is the whole picture.

Needs NumPy, pyrelievo and OpenEXR, all by pip.
"""

import argparse
import os
import re
import sys
from pathlib import Path

import numpy as np
import OpenEXR

import pyrelievo

#: The layers that a shape is found from, and that is to be enhanced.
ROLES = ("color", "normal", "depth")

#: The channels of layers without a name.
BARE = {"color": "RGBA", "depth": "Z"}

#: How layers are to be read: chosen for a shot, and told to each of its frames.
CONVENTIONS = ("normal_space", "normal_encoding", "normal_flip", "depth_kind")


def numbered(pattern: str, number: int) -> str:
    """The name of a frame: #### is its number."""
    return re.sub("#+", lambda marks: f"{number:0{len(marks[0])}d}", pattern)


def frames_of(pattern: str) -> list[int]:
    """The numbers of the frames on disk."""
    folder, name = os.path.split(pattern)
    before, marks, after = re.split("(#+)", name, maxsplit=1)
    number = re.compile(f"{re.escape(before)}(\\d{{{len(marks)},}}){re.escape(after)}")
    found = (number.fullmatch(path.name) for path in Path(folder or ".").iterdir())
    return sorted(int(match[1]) for match in found if match)


def channels_of(file: OpenEXR.File) -> dict[str, np.ndarray]:
    """The channels of all parts; those of a part that has a name are a layer of that name."""
    found = {}
    for part in file.parts:
        for name, channel in part.channels.items():
            is_whole = not part.name() or name.startswith(f"{part.name()}.")
            found[name if is_whole else f"{part.name()}.{name}"] = channel.pixels
    return found


def layer_of(channels: dict[str, np.ndarray], role: str, name: str) -> np.ndarray:
    """A layer as an array of rows, columns and components."""
    if name == "bare channels":
        own = {end: channels[end] for end in BARE[role] if end in channels}
    else:
        own = {key[len(name) + 1 :]: channels[key] for key in channels if f"{key}.".startswith(f"{name}.")}
    # A file has them in the order of the alphabet.
    components = [own[end] for end in "RGBAXYZ" if end in own] or list(own.values())
    return np.stack(components, axis=-1)


def enhance_shot(pattern: str, output: str, camera: str | None = None, **settings) -> list[int]:
    """Enhances all frames of a shot; returns their numbers."""
    frames = frames_of(pattern)
    if not frames:
        raise FileNotFoundError(f"{pattern}: no frame of this name is there")
    engine = pyrelievo.Engine()
    given = [(name.replace("_", "-"), value) for name, value in settings.items()]
    if camera:
        given.append(("camera", camera))

    # Five frames are looked at, spread over the shot.
    chosen = {name.replace("-", "_"): value for name, value in engine.choose("enhance", given, pattern, frames)}
    conventions = {name: chosen[name] for name in CONVENTIONS if name in chosen}
    look = {name: chosen[name] for name in ("curvature_gain", "white_level")} | settings
    findings = {found.subject: found.conclusion for found in pyrelievo.load(pattern, frame=frames[0]).findings}

    for number in frames:
        with OpenEXR.File(numbered(pattern, number), separate_channels=True) as file:
            channels = channels_of(file)
            layers = {role: layer_of(channels, role, findings[role]) for role in ROLES if role in findings}
            seen = numbered(camera, number) if camera else None
            frame = pyrelievo.Frame(**layers, camera=seen, **conventions)
            picture = pyrelievo.enhance(frame, engine=engine, **look)

            for end, plane in zip("RGB", np.moveaxis(picture, 2, 0), strict=True):
                name = f"relievo.Picture.{end}"
                file.parts[0].channels[name] = OpenEXR.Channel(name, plane.astype(layers["color"].dtype))
            for part in file.parts:
                # Lossy compression would take from the layers again.
                part.header["compression"] = OpenEXR.ZIP_COMPRESSION
            # Under its own name only when it is whole.
            path = numbered(output, number)
            file.write(f"{path}.part")
            os.replace(f"{path}.part", path)
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
