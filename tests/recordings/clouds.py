"""Small PCD files."""

import struct

import numpy as np


def pcd(points, encoding, fields="xyz", kind="F", size=4, extra="", **words):
    """The bytes of a file; ``fields`` of one letter each, those besides x, y and z hold 7."""
    axes = {axis: points[:, k] for k, axis in enumerate("xyz")}
    dtype = np.dtype([(name, f"<{kind.lower()}{size}") for name in fields])
    rows = np.zeros(len(points), dtype)
    for name in fields:
        rows[name] = axes.get(name, 7)
    n = len(fields)
    header = {
        "VERSION": "0.7",
        "FIELDS": " ".join(fields),
        "SIZE": " ".join([str(size)] * n),
        "TYPE": " ".join([kind] * n),
        "COUNT": " ".join(["1"] * n),
        "WIDTH": len(points),
        "HEIGHT": 1,
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": len(points),
    } | words
    text = "# .PCD v0.7 - Point Cloud Data file format\n" + extra
    text += "".join(f"{word} {said}\n" for word, said in header.items() if said is not None)
    return f"{text}DATA {encoding}\n".encode() + body(rows, encoding)


def body(rows, encoding):
    if encoding == "ascii":
        return "".join(" ".join(str(v) for v in row) + "\n" for row in rows.tolist()).encode()
    if encoding == "binary":
        return rows.tobytes()
    plain = b"".join(rows[name].tobytes() for name in rows.dtype.names)
    packed = lzf(plain)
    return struct.pack("<II", len(packed), len(plain)) + packed


def lzf(data):
    """LZF with literals and references back: the longest match at the last place of a triple."""
    out, literal, last, at = bytearray(), bytearray(), {}, 0

    def flush():
        for k in range(0, len(literal), 32):
            some = literal[k : k + 32]
            out.extend([len(some) - 1, *some])
        literal.clear()

    while at < len(data):
        triple = data[at : at + 3]
        before = last.get(triple, -1)
        last[triple] = at
        if before < 0 or at - before > 8192 or len(triple) < 3:
            literal.append(data[at])
            at += 1
            continue
        length = 3
        while (
            length < 264 and at + length < len(data) and data[before + length] == data[at + length]
        ):
            length += 1
        flush()
        back = at - before - 1
        if length - 2 < 7:
            out.extend([(length - 2) << 5 | back >> 8, back & 255])
        else:
            out.extend([7 << 5 | back >> 8, length - 2 - 7, back & 255])
        at += length
    flush()
    return bytes(out)
