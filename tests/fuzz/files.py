"""Small picture files from scratch, right ones and wrong ones: for attack.py and found.py."""

import math
import struct
import zlib


def attribute(name, kind, value):
    """An attribute of an EXR header; names may be any bytes."""
    return as_bytes(name) + b"\0" + as_bytes(kind) + b"\0" + struct.pack("<i", len(value)) + value


def as_bytes(text):
    return text if isinstance(text, bytes) else text.encode()


def box(window):
    return struct.pack("<4i", *window)


def exr(channels, width, height, *, window=None, compression=0, part=None, more=b"", chunks=None, tiles=None):
    """An EXR file of one part, 32-bit floats, uncompressed; channels maps names to functions of x and y.

    window, compression, tiles and chunks (a list of bytes) replace what would be true; more holds attributes.
    """
    window = window or (0, 0, width - 1, height - 1)
    names = sorted(channels, key=as_bytes)
    channel_list = b"".join(as_bytes(n) + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for n in names) + b"\0"
    long_names = 0x400 if any(len(as_bytes(n)) > 31 for n in names) else 0
    header = struct.pack("<II", 20000630, 2 | long_names | (0x200 if tiles else 0))
    header += attribute("channels", "chlist", channel_list)
    header += attribute("compression", "compression", bytes([compression]))
    header += attribute("dataWindow", "box2i", box(window))
    header += attribute("displayWindow", "box2i", box((0, 0, width - 1, height - 1)))
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if tiles:
        header += attribute("tiles", "tiledesc", struct.pack("<IIB", *tiles, 0))
    if part is not None:
        header += attribute("name", "string", as_bytes(part))
    header += more + b"\0"
    if chunks is None:
        rows = [[channels[n](x, y) for n in names for x in range(width)] for y in range(height)]
        chunks = [struct.pack("<ii", y, 4 * len(r)) + struct.pack(f"<{len(r)}f", *r) for y, r in enumerate(rows)]
    offsets, at = b"", len(header) + 8 * len(chunks)
    for chunk in chunks:
        offsets += struct.pack("<Q", at)
        at += len(chunk)
    return header + offsets + b"".join(chunks)


def bumps(number=0):
    """The layers of a frame: bumps with slopes of up to a half, and their picture."""

    def normal(x, y):
        x, y = (x + number) / 4, y / 4
        slope = 0.5 * math.sin(x) * math.cos(y), -0.5 * math.cos(x) * math.sin(y)
        length = math.hypot(*slope, 1)
        return slope[0] / length, slope[1] / length, 1 / length

    layers = {f"N.{axis}": lambda x, y, i=i: normal(x, y)[i] for i, axis in enumerate("XYZ")}
    layers.update({name: lambda x, y: 0.8 * normal(x, y)[2] for name in "RGB"})
    layers["Z"] = lambda x, y: 5 + 0.01 * (x + y)
    return layers


def chunk(name, data):
    """A chunk of a PNG."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(width, height, rows, *, kind=2, bits=8, more=b""):
    """A PNG file; rows are the bytes of all rows, each with its filter; more holds chunks of metadata."""
    head = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    body = chunk(b"IDAT", zlib.compress(rows, 9))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + more + body + chunk(b"IEND", b"")


def exif(entries, count=None):
    """A block of EXIF: entries are (tag, type, count, four bytes of value); count replaces their number."""
    table = b"".join(struct.pack("<HHI", *entry[:3]) + entry[3] for entry in entries)
    return b"II*\0" + struct.pack("<IH", 8, len(entries) if count is None else count) + table + bytes(4)


def with_exif(jpeg, block):
    """A JPEG with a block of EXIF in front."""
    block = b"Exif\0\0" + block
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", 2 + len(block)) + block + jpeg[2:]


def colored_png(width, height, more=b""):
    """A PNG that passes for a photo and for a normal map."""
    row = lambda y: bytes([0]) + b"".join(bytes([96 + 64 * x // width, 160 - 64 * y // height, 240]) for x in range(width))
    return png(width, height, b"".join(row(y) for y in range(height)), more=more)


def hdr(width, height, pixels=None):
    """A Radiance HDR file without run lengths."""
    pixels = bytes([128, 128, 140, 129]) * (width * height) if pixels is None else pixels
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + pixels


def tiff(width, height, samples=None):
    """A TIFF file of floats in red, green and blue."""
    samples = [0.5] * (3 * width * height) if samples is None else samples
    data = struct.pack(f"<{len(samples)}f", *samples)
    bits = struct.pack("<6H", 32, 32, 32, 3, 3, 3)
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 3, 8), (259, 3, 1, 1), (262, 3, 1, 2), (273, 4, 1, 20),
               (277, 3, 1, 3), (278, 4, 1, height), (279, 4, 1, len(data)), (339, 3, 3, 14)]
    table = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *e) for e in entries) + bytes(4)
    return b"II*\0" + struct.pack("<I", 20 + len(data)) + bits + data + table
