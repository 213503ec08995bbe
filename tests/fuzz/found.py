#!/usr/bin/env python3
"""Writes the files of found/ that are not text, from scratch; found/README.md says what each showed."""

import pathlib
import struct
import zlib

from files import attribute, bumps, chunk, colored_png, exr, hdr, png, tiff

FOUND = pathlib.Path(__file__).parent / "found"


def words(*line, extra=b""):
    """A file of command_line: words, an empty line, the file `extra`."""
    return "\n".join(line).encode("utf-8", "surrogateescape") + b"\n\n" + extra


def untyped(name):
    """An attribute without a type: what would be its type belongs to its value."""
    value = b"string\0relievo"
    return name.encode() + b"\0\0" + struct.pack("<i", len(value)) + value


def dwa(counter, value):
    """A chunk of DWA data in which one of eleven counters claims `value`."""
    counters = [2] + [0] * 10
    counters[counter] = value
    body = struct.pack("<11q", *counters) + bytes(16)
    return struct.pack("<ii", 0, len(body)) + body


def files():
    small = {"R": lambda x, y: 0.5, "G": lambda x, y: 0.5, "B": lambda x, y: x / 4}
    yield "exr_to_frame/attribute_without_type", exr(small, 4, 3, more=untyped("software"))
    windows = {"square": (0, 0, 32767, 32767), "line": (0, 0, 1 << 29, 0), "largest": (-1 << 31, -1 << 31, (1 << 31) - 1, (1 << 31) - 1),
               "inverted": (10, 10, 0, 0), "empty": (0, 0, -1, -1)}
    for name, window in windows.items():
        yield f"exr_to_frame/window_{name}", exr(small, 4, 3, window=window)
    for number in (10, 12, 99):
        yield f"exr_to_frame/compression_{number}", exr(small, 4, 3, compression=number)
    for name, size in {"zero": (0, 20), "largest": ((1 << 32) - 1, (1 << 32) - 1), "int_max": ((1 << 31) - 1, (1 << 31) - 1)}.items():
        yield f"exr_to_frame/tiles_{name}", exr(small, 4, 3, tiles=size)
    for counter in range(1, 11):
        yield f"exr_to_frame/dwa_counter_{counter}", exr(small, 4, 3, compression=8, chunks=[dwa(counter, 1 << 34)])
    yield "exr_to_frame/cut", exr(bumps(), 12, 9)[:-700]
    names = {"escape": "\x1b]0;x\x07", "bidi": "a\u202eb", "lines": "a\nb\rc", "long": "n" * 300}
    for name, layer in names.items():
        odd = {f"{layer}.{c}": (lambda x, y: 0.5) for c in "XYZ"}
        yield f"exr_to_frame/layer_{name}", exr(small | odd, 4, 3, part=layer, more=attribute(layer, "string", layer.encode()))
    bad = [float("nan"), float("inf"), float("-inf"), 1e38, -1e38]
    spoiled = {name: (lambda x, y: bad[(x + y) % 5]) for name in bumps()}
    yield "exr_to_frame/not_finite", exr(spoiled, 12, 9)
    for width, height in ((0, 0), (0, 7), (7, 0)):
        yield f"pictures/zero_{width}x{height}_hdr", hdr(width, height)
        yield f"pictures/zero_{width}x{height}_png", png(width, height, b"")
        yield f"pictures/zero_{width}x{height}_tiff", tiff(width, height, [])
    yield "pictures/claims_a_million_rows_hdr", hdr(8, 1 << 20, b"")
    yield "pictures/not_finite_tiff", tiff(8, 4, [float("nan"), float("inf"), -1e38] * 32)
    zero = hdr(0, 0)
    yield "command_line/zero_as_input", words("shape", "extra", "-o", "out.png", extra=zero)
    yield "command_line/zero_as_normals", words("enhance", "plain.png", "--normal", "extra", "-o", "out.png", extra=zero)
    yield "command_line/zero_as_environment", words("relight", "frame.exr", "--environment", "extra", "-o", "out.exr", extra=zero)
    yield "command_line/zero_as_lit_sphere", words("relight", "frame.exr", "--lit-sphere", "extra", "-o", "out.exr", extra=zero)
    # 18,000 rows of 18,000 pixels of one bit, all black: 41 KB that become more than a gigabyte.
    yield "command_line/inspect_large_png", words("inspect", "extra", extra=png(18000, 18000, bytes(18000 * 2251), kind=0, bits=1))
    recipe = 'version = 1\ncommand = "shape"\nscale = [' + "2," * 5000 + "]\n"
    yield "command_line/scales_by_the_thousand", words("run", "extra", "frame.exr", "-o", "out.exr", extra=recipe.encode())
    wild = [1e10, float("-inf"), 1e38, 65504.0]
    covered = bumps() | {"A": lambda x, y: wild[(x + 3 * y) % 4] if x * y % 5 == 0 else float(x > 8)}
    del covered["Z"]
    yield "command_line/wild_coverage", words("hatch", "extra", "--style", "engraving", "-o", "out.svg", extra=exr(covered, 24, 18))
    yield "command_line/tile_at_a_large_scale", words("shape", "frame.exr", "--wrap", "xy", "--scale", "1000", "-o", "out.png")
    yield "command_line/tile_drawn", words("hatch", "frame.exr", "--wrap", "xy", "--mask", "N.Z", "-o", "out.exr")
    bomb = chunk(b"iCCP", b"x\0\0" + zlib.compress(bytes(300 << 20), 9))
    yield "pictures/profile_of_300_mib", colored_png(8, 6, bomb)
    yield "command_line/json_of_a_name_in_bytes", words("inspect", "--json", "bytes\udcff\udcfe.exr")


def main():
    for name, data in files():
        path = FOUND / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


if __name__ == "__main__":
    main()
