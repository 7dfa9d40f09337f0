"""Reads the VTU files of the program: points, and the fields at them."""
import re

import numpy as np

KINDS = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}
ARRAY = re.compile(rb'<DataArray type="(\w+)" Name="([^"]+)" NumberOfComponents="(\d+)"[^>]*offset="(\d+)"/>')


def read(path):
    """Arrays by name; those of several components [n, components], points under "Points"."""
    data = path.read_bytes()
    head = data.index(b"<AppendedData")
    start = data.index(b"_", head) + 1
    arrays = {}
    for kind, name, components, offset in ARRAY.findall(data[:head]):
        at = start + int(offset)
        size = int.from_bytes(data[at : at + 8], "little")
        values = np.frombuffer(data[at + 8 : at + 8 + size], KINDS[kind.decode()])
        arrays[name.decode()] = values if components == b"1" else values.reshape(-1, int(components))
    return arrays
