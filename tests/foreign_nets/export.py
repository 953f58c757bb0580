#!/usr/bin/env python3
"""Exports small depth nets of public architectures, with random weights, as they are published.

    python export.py OUT

For each NAME.onnx there is NAME.shape, the shape of its input. What comes behind the last dash of a name says how it
was made from the net without that ending: fp16 (float32 in and out), fp16io, int8, ext (weights in a second file).
Needs torch, transformers, onnx, onnxruntime and onnxconverter-common; `cargo xtask test --all` installs them.
"""
import inspect
import pathlib
import sys
import warnings

import onnx
import torch
from onnxconverter_common import float16
from onnxruntime.quantization import QuantType, quantize_dynamic
from transformers import (
    BeitConfig, DepthAnythingConfig, DepthAnythingForDepthEstimation, Dinov2Config, DPTConfig, DPTForDepthEstimation,
    GLPNConfig, GLPNForDepthEstimation, Swinv2Config,
)

warnings.filterwarnings("ignore")


class Depth(torch.nn.Module):
    """Gives only the depth of a transformers model whose answer varies."""

    def __init__(self, net):
        super().__init__()
        torch.manual_seed(7)
        with torch.no_grad():
            for name, p in net.named_parameters():
                if p.ndim >= 2:
                    p.copy_(torch.randn_like(p) / p[0].numel() ** 0.5)
                elif name.endswith("bias"):
                    p.add_(0.02 * torch.randn_like(p))
                else:
                    p.copy_(0.6 + 0.4 * torch.rand_like(p))
            # A head that ends in ReLU must not be dead.
            [p for _, p in net.named_parameters() if p.ndim == 1 and p.numel() == 1][-1].fill_(3.0)
        self.net = net.eval()

    def forward(self, pixel_values):
        return self.net(pixel_values=pixel_values).predicted_depth


def depth_anything(metric=False):
    body = Dinov2Config(image_size=70, patch_size=14, hidden_size=48, num_attention_heads=3, num_hidden_layers=4,
                        out_indices=[1, 2, 3, 4], reshape_hidden_states=False, apply_layernorm=True)
    kind = dict(depth_estimation_type="metric", max_depth=20) if metric else {}
    return DepthAnythingForDepthEstimation(DepthAnythingConfig(
        backbone_config=body, reassemble_hidden_size=48, neck_hidden_sizes=[16, 24, 32, 48], fusion_hidden_size=16,
        head_hidden_size=8, **kind))


def dpt():
    return DPTForDepthEstimation(DPTConfig(
        hidden_size=48, num_hidden_layers=4, num_attention_heads=3, intermediate_size=96, backbone_out_indices=[0, 1, 2, 3],
        image_size=64, neck_hidden_sizes=[16, 24, 32, 48], fusion_hidden_size=16))


def dpt_beit():
    body = BeitConfig(image_size=64, hidden_size=48, num_hidden_layers=4, num_attention_heads=3, intermediate_size=96,
                      use_relative_position_bias=True, reshape_hidden_states=False, out_indices=[1, 2, 3, 4])
    return DPTForDepthEstimation(DPTConfig(
        backbone_config=body, neck_hidden_sizes=[16, 24, 32, 48], fusion_hidden_size=16))


def dpt_swin():
    body = Swinv2Config(image_size=64, embed_dim=24, depths=[1, 1, 1, 1], num_heads=[1, 2, 3, 4], window_size=4,
                        out_features=["stage1", "stage2", "stage3", "stage4"])
    return DPTForDepthEstimation(DPTConfig(
        backbone_config=body, neck_hidden_sizes=[24, 48, 96, 192], fusion_hidden_size=16, add_projection=False,
        use_batch_norm_in_fusion_residual=False, use_bias_in_fusion_residual=True))


def glpn():
    return GLPNForDepthEstimation(GLPNConfig(
        depths=[1, 1, 1, 1], hidden_sizes=[16, 32, 48, 64], num_attention_heads=[1, 2, 3, 4], decoder_hidden_size=16))


# Name: net, height and width of the input, further forms.
NETS = {
    "depth_anything": (depth_anything, [70, 98], ["fp16", "fp16io", "int8", "ext"]),
    "depth_anything_metric": (lambda: depth_anything(True), [70, 98], []),
    "dpt": (dpt, [64, 64], ["fp16", "int8"]),
    "dpt_beit": (dpt_beit, [64, 64], []),
    "dpt_swin": (dpt_swin, [64, 64], []),
    "glpn": (glpn, [64, 96], []),
}


def form(kind, path, goal):
    if kind == "int8":
        quantize_dynamic(path, goal, weight_type=QuantType.QUInt8)
    elif kind == "ext":
        onnx.save(onnx.load(path), goal, save_as_external_data=True, location=goal.name + "_data", size_threshold=0)
    else:
        onnx.save(float16.convert_float_to_float16(onnx.load(path), keep_io_types=kind == "fp16"), goal)


def main():
    out = pathlib.Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    for name, (build, size, forms) in NETS.items():
        path = out / f"{name}.onnx"
        axes = {"pixel_values": {0: "batch_size", 1: "num_channels", 2: "height", 3: "width"},
                "predicted_depth": {0: "batch_size", 1: "height", 2: "width"}}
        # Before 2.5 PyTorch knew no other exporter.
        old = dict(dynamo=False) if "dynamo" in inspect.signature(torch.onnx.export).parameters else {}
        torch.onnx.export(Depth(build()), (torch.randn(1, 3, *size),), str(path), input_names=["pixel_values"],
                          output_names=["predicted_depth"], opset_version=17, dynamic_axes=axes, **old)
        made = [path]
        for kind in forms:
            made.append(out / f"{name}-{kind}.onnx")
            form(kind, path, made[-1])
        for file in made:
            file.with_suffix(".shape").write_text(f"1 3 {size[0]} {size[1]}\n")


if __name__ == "__main__":
    main()
