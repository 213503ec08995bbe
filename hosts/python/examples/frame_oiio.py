#!/usr/bin/env python3
"""Enhances a frame in memory and writes it with OpenImageIO, with all its channels and three more.

    python frame_oiio.py in/frame.exr out/frame.exr scaling=0.8

pyrelievo reads the layers and finds what they mean; OpenImageIO keeps the others, and writes any format that it knows.

Needs pyrelievo and OpenImageIO, both by pip.
"""

import sys

import OpenImageIO as oiio
import pyrelievo

NAMES = tuple(f"relievo.Picture.{end}" for end in "RGB")


def enhance_frame(source: str, output: str, **settings) -> None:
    """Adds the enhanced picture to the channels of a frame."""
    picture = pyrelievo.enhance(pyrelievo.load(source), **settings)

    frame = oiio.ImageBuf(source)
    spec = oiio.ImageSpec(frame.roi, oiio.HALF)
    spec.nchannels, spec.channelnames = len(NAMES), NAMES
    added = oiio.ImageBuf(spec)
    added.set_pixels(added.roi, picture)

    whole = oiio.ImageBufAlgo.channel_append(frame, added)
    native = frame.nativespec()
    whole.set_write_format([*native.get_channelformats(), *len(NAMES) * [oiio.HALF]])
    if not whole.write(output):
        raise OSError(whole.geterror())


def main() -> None:
    if len(sys.argv) < 3:
        sys.exit("usage: frame_oiio.py IN OUT [SETTING=VALUE ...]")
    source, output, *settings = sys.argv[1:]
    try:
        enhance_frame(source, output, **dict(setting.split("=", 1) for setting in settings))
    except (OSError, ValueError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
