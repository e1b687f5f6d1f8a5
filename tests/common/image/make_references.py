#!/usr/bin/env python3
"""Makes tests/data/images/: one picture in many kinds of files, by programs that are not the project's. By hand:
  apt-get install python3-pil libtiff-tools && tests/common/image/make_references.py
What the pictures show is written down in image_files_test.cpp, too."""
import os
import struct
import subprocess
import sys
import zlib

from PIL import Image

W, H = 37, 21
FOLDER = os.path.join(os.path.dirname(os.path.abspath(sys.argv[0])), "..", "..", "data", "images")


def grey(x, y):
    return (7 * x + 13 * y) % 256


def wide(x, y):
    return (2711 * x + 977 * y) % 65536


def colour(x, y):
    return grey(x, y), (x * x + 3 * y) % 256, (255 - 5 * x + 11 * y) % 256


def wide_colour(x, y):
    return wide(x, y), (65535 - 31 * x * y) % 65536, (12345 + 511 * x + 3 * y) % 65536


def black(x, y):
    return 255 if (x // 3 + y // 2) % 2 else 0


def path(name):
    return os.path.join(FOLDER, name)


def picture(mode, of):
    made = Image.new(mode, (W, H))
    made.putdata([of(x, y) for y in range(H) for x in range(W)])
    return made


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(name, colour_type, bits, pixels, interlaced=False, extra=b""):
    """pixels(x, y): a pixel's bytes, or of fewer than 8 bits its number."""
    passes = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
    data = b""
    for x0, y0, dx, dy in passes if interlaced else [(0, 0, 1, 1)]:
        for y in range(y0, H, dy):
            row = [pixels(x, y) for x in range(x0, W, dx)]
            if not row:
                continue
            if bits < 8:
                text = "".join(format(n, "0%db" % bits) for n in row)
                text += "0" * (-len(text) % 8)
                packed = bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
            else:
                packed = b"".join(row)
            data += b"\0" + packed
    head = struct.pack(">IIBBBBB", W, H, bits, colour_type, 0, 0, 1 if interlaced else 0)
    with open(path(name), "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra)
        file.write(chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b""))


def exif(orientation):
    return b"II*\0\x08\0\0\0\x01\0" + struct.pack("<HHIHH", 0x0112, 3, 1, orientation, 0) + b"\0\0\0\0"


def shown(name, reference):
    """What another program reads of a file, as a PNG of plain numbers."""
    decoded = Image.open(path(name))
    decoded = decoded if decoded.mode == "L" else decoded.convert("RGB")
    as_bytes = lambda x, y: bytes([decoded.getpixel((x, y))] if decoded.mode == "L" else decoded.getpixel((x, y)))
    png(reference, 0 if decoded.mode == "L" else 2, 8, as_bytes)


def pngs():
    picture("L", grey).save(path("grey8.png"))
    picture("RGB", colour).save(path("colour8.png"))
    picture("RGBA", lambda x, y: colour(x, y) + (40 * y % 256,)).save(path("colour8_alpha.png"))
    picture("LA", lambda x, y: (grey(x, y), 40 * y % 256)).save(path("grey8_alpha.png"))
    picture("1", black).save(path("black.png"))
    picture("RGB", colour).quantize(16).save(path("palette.png"))
    shown("palette.png", "palette_shown.png")
    picture("I;16", wide).save(path("grey16.png"))
    png("colour16.png", 2, 16, lambda x, y: struct.pack(">HHH", *wide_colour(x, y)))
    png("grey16_interlaced.png", 0, 16, lambda x, y: struct.pack(">H", wide(x, y)), interlaced=True)
    png("colour8_interlaced.png", 2, 8, lambda x, y: bytes(colour(x, y)), interlaced=True)
    png("grey4.png", 0, 4, lambda x, y: grey(x, y) >> 4)
    png("grey8_turned.png", 0, 8, lambda x, y: bytes([grey(x, y)]), extra=chunk(b"eXIf", exif(6)))


def tiffcp(name, source, *options):
    subprocess.run(["tiffcp", *options, path(source), path(name)], check=True)


def tagged(name, source, tag, value):
    with open(path(source), "rb") as file, open(path(name), "wb") as copy:
        copy.write(file.read())
    subprocess.run(["tiffset", "-s", str(tag), str(value), path(name)], check=True)


def bare_tiff(name, bits, data, samples=1, meaning=1, form=None, planes=1, further=()):
    """Little-endian, one strip, or one for each plane."""
    size = len(data) // planes
    data += b"\0" * (len(data) % 2)
    starts = 8 if planes == 1 else 8 + len(data)
    sizes = size if planes == 1 else starts + 4 * planes
    if planes > 1:
        data += b"".join(struct.pack("<I", 8 + size * i) for i in range(planes)) + struct.pack("<I", size) * planes
    entries = [(256, 4, 1, W), (257, 4, 1, H), (258, 3, 1, bits), (259, 3, 1, 1), (262, 3, 1, meaning)]
    entries += [(273, 4, planes, starts), (277, 3, 1, samples), (278, 4, 1, H), (279, 4, planes, sizes)]
    entries += [(284, 3, 1, 2)] if planes > 1 else []
    entries += [(339, 3, 1, form)] if form else []
    entries += further
    directory = struct.pack("<H", len(entries))
    for entry in entries:
        directory += struct.pack("<HHII", *entry)
    with open(path(name), "wb") as file:
        file.write(b"II*\0" + struct.pack("<I", 8 + len(data)) + data + directory + b"\0\0\0\0")


def packed(bits, of):
    data = b""
    for y in range(H):
        text = "".join(format(of(x, y), "0%db" % bits) for x in range(W))
        text += "0" * (-len(text) % 8)
        data += bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))
    return data


def tiffs():
    for kind in ("raw", "tiff_lzw"):
        picture("L", grey).save(path("grey8_%s.tif" % kind), compression=kind)
    for kind in ("raw", "tiff_adobe_deflate"):
        picture("RGB", colour).save(path("colour8_%s.tif" % kind), compression=kind)
    for kind in ("raw", "packbits", "tiff_lzw"):
        picture("I;16", wide).save(path("grey16_%s.tif" % kind), compression=kind)
    picture("RGBA", lambda x, y: colour(x, y) + (255,)).save(path("colour8_alpha.tif"), compression="tiff_lzw")
    picture("1", black).save(path("black_group4.tif"), compression="group4")
    picture("RGB", colour).quantize(16).save(path("palette.tif"))
    tiffcp("grey8_tiles.tif", "grey8_raw.tif", "-t", "-w", "16", "-l", "16", "-c", "lzw:2")
    tiffcp("colour8_tiles.tif", "colour8_raw.tif", "-t", "-w", "16", "-l", "16", "-c", "zip")
    tiffcp("colour8_planes.tif", "colour8_raw.tif", "-p", "separate", "-r", "5", "-c", "lzw")
    tiffcp("grey16_big_endian.tif", "grey16_raw.tif", "-B", "-r", "4", "-c", "none")
    tiffcp("grey16_big_endian_lzw.tif", "grey16_raw.tif", "-B", "-r", "4", "-c", "lzw:2")
    tiffcp("grey16_tiles.tif", "grey16_raw.tif", "-t", "-w", "16", "-l", "16", "-c", "zip:2")
    tiffcp("colour8_jpeg.tif", "colour8_raw.tif", "-c", "jpeg:r:90")
    shown("colour8_jpeg.tif", "colour8_jpeg_shown.png")
    wide_colours = [wide_colour(x, y) for y in range(H) for x in range(W)]
    bare_tiff("wide.tif", 16, b"".join(struct.pack("<H", c) for p in wide_colours for c in p), samples=3, meaning=2)
    tiffcp("colour16_lzw.tif", "wide.tif", "-c", "lzw:2")
    planes = [b"".join(struct.pack("<H", p[c]) for p in wide_colours) for c in range(3)]
    bare_tiff("colour16_planes.tif", 16, b"".join(planes), samples=3, meaning=2, planes=3)
    os.remove(path("wide.tif"))
    bare_tiff("grey12_packed.tif", 12, packed(12, lambda x, y: wide(x, y) >> 4))
    bare_tiff("grey10_packed.tif", 10, packed(10, lambda x, y: wide(x, y) >> 6))
    bare_tiff("grey4.tif", 4, packed(4, lambda x, y: grey(x, y) >> 4))
    bare_tiff("floats.tif", 32, b"".join(struct.pack("<f", x) for x in range(W * H)), form=3)
    # Green, red; blue, green; black level and white level.
    pattern = [(33421, 3, 2, 0x20002), (33422, 1, 4, 0x01020001), (50714, 3, 1, 128), (50717, 3, 1, 65535)]
    bare_tiff("mosaic.tif", 16, b"".join(struct.pack("<H", wide(i % W, i // W)) for i in range(W * H)), meaning=32803, further=pattern)
    # With a tag whose value the tests change.
    tagged("turned.tif", "grey16_tiff_lzw.tif", 274, 2)
    tagged("turned6_colour.tif", "colour8_tiff_adobe_deflate.tif", 274, 6)
    tagged("turned8_palette.tif", "palette.tif", 274, 8)


def jpegs():
    smooth = Image.new("RGB", (W, H))
    smooth.putdata([(5 * x, 9 * y, 255 - 4 * x) for y in range(H) for x in range(W)])
    for name, image, options in (
        ("colour.jpg", smooth, {}),
        ("colour_444_progressive.jpg", smooth, {"subsampling": 0, "progressive": True}),
        ("grey.jpg", smooth.convert("L"), {}),
        ("inks.jpg", smooth.convert("CMYK"), {}),
        ("colour_turned.jpg", smooth, {"exif": b"Exif\0\0" + exif(8)}),
    ):
        image.save(path(name), quality=90, **options)
        if name not in ("inks.jpg", "colour_turned.jpg"):
            shown(name, name.replace(".jpg", "_shown.png"))


os.makedirs(FOLDER, exist_ok=True)
pngs()
tiffs()
jpegs()
