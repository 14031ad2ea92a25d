"""Compares what celfx writes with what others make of it: OpenImageIO, the Cryptomatte API, OpenColorIO.

decoders.py CELFX FOLDER    renders into FOLDER; exits with 1 and a line where something differs.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import PyOpenColorIO as ocio
from cryptomatte_api import Cryptomatte

CELFX, FOLDER = sys.argv[1], Path(sys.argv[2])
# What masks must be true to: a step of 8 bits.
STEP = 1 / 255


def need(is_so, what):
    if not is_so:
        sys.exit(f"decoders: {what}")


def render(shot, frame, layers, *more):
    command = [CELFX, "render", shot, "-q", "--frames", str(frame), "--set", "size=[160, 160]"]
    subprocess.run([*command, "-o", FOLDER / "picture.exr", "--layers", FOLDER / layers, *more], check=True)


def read(name):
    """Channels of a file by their names, and its description."""
    file = oiio.ImageInput.open(str(FOLDER / name))
    need(file, f"OpenImageIO cannot open {name}: {oiio.geterror()}")
    spec, pixels = file.spec(), file.read_image(format="float")
    return {channel: pixels[..., i] for i, channel in enumerate(spec.channelnames)}, spec


def is_near(a, b, bits=11):
    """Whether a half is that number."""
    return np.all(np.abs(a - b) <= np.abs(b) * 2.0**-bits + 2.0**-24)


def same_as_separate_files(shot, frame, layers):
    """One file has what the files of layers have, in types that compositors expect."""
    render(shot, frame, "each")
    render(shot, frame, "one.####.exr")
    one, spec = read(f"one.{frame:04}.exr")
    kinds = dict(zip(spec.channelnames, spec.channelformats or [spec.format] * spec.nchannels))
    picture, _ = read("picture.exr")
    for channel in "RGBA":
        need(kinds[channel] == oiio.HALF and is_near(one[channel], picture[channel]), f"{shot}: picture {channel}")
    for name in layers:
        each, _ = read(f"each/{name}.{frame:04}.exr")
        for channel, values in each.items():
            full = f"{name.replace('.', '_')}.{channel}"
            need(full in one, f"{shot}: no channel {full}")
            is_colour = channel != "Y" and name != "blur.object"
            need(kinds[full] == (oiio.HALF if is_colour else oiio.FLOAT), f"{shot}: {full} is {kinds[full]}")
            need(is_near(one[full], values) if is_colour else np.array_equal(one[full], values), f"{shot}: {full}")
    need(kinds["Z"] == oiio.FLOAT, f"{shot}: Z")
    for name in ["framesPerSecond", "worldToCamera", "worldToNDC", "chromaticities", "celfx/frame"]:
        need(spec.getattribute(name) is not None, f"{shot}: no {name}")
    return one


def masks(frame):
    """Masks by their names, as the Cryptomatte API decodes them."""
    [cryptomatte] = Cryptomatte.load(FOLDER / f"one.{frame:04}.exr")
    return cryptomatte.masks()


def smoke():
    one = same_as_separate_files("builtin:smoke", 24, ["smoke", "smoke.tone", "smoke.depth", "smoke.id"])
    found = masks(24)
    alpha, _ = read("each/smoke.0024.exr")
    need(np.abs(sum(found.values()) - alpha["A"]).max() <= STEP, "smoke: masks are not its alpha")
    for name, mask in found.items():
        number = float(name.removeprefix("smoke."))
        own = one["smoke_id.Y"] == number
        need(own.any() and np.abs(mask - alpha["A"])[own].max() <= STEP, f"smoke: mask {name}")
        # Elsewhere it has ink at most, where there is no number.
        need(mask[(one["smoke_id.Y"] > 0) & ~own].max(initial=0) <= STEP, f"smoke: mask {name} beyond its group")


def mesh():
    for frame in [1, 8]:
        one = same_as_separate_files("builtin:blur", frame, ["blur", "blur.depth", "blur.object", "blur.colour"])
        found = masks(frame)
        samples = np.stack([one[f"blur_object.{c}"] for c in "RGBA"], -1)
        shares = {n: (samples == n).mean(-1) for n in np.unique(samples) if n > 0}
        need(len(found) == len(shares) == 6, f"blur {frame}: {sorted(found)}")
        for name, mask in found.items():
            fits = [n for n, share in shares.items() if np.abs(share - mask).max() <= STEP]
            need(len(fits) == 1, f"blur {frame}: mask {name} is none of the objects'")
        covered = sum(found.values()) > 0
        need(np.array_equal(covered, one["Z"] < 1e9), f"blur {frame}: Z is not where the mesh is")
        near = np.where(covered, one["Z"], one["blur_depth.Y"].min())
        need(np.array_equal(near, np.where(covered, one["blur_depth.Y"], near)), f"blur {frame}: Z is not its depth")


def views():
    """Pictures of displays are those that OpenColorIO makes of the linear ones."""
    config = ocio.Config.CreateFromBuiltinConfig("cg-config-v4.0.0_aces-v2.0_ocio-v2.5")
    rec709 = ["Rec.1886 Rec.709 - Display", "Un-tone-mapped"]
    aces = ["sRGB - Display", "ACES 2.0 - SDR 100 nits (Rec.709)"]
    named = {"Rec.709": rec709, "ACES 2.0 SDR": aces, " / ".join(aces): aces}
    named["Display P3 - Display / Video (colorimetric)"] = ["Display P3 - Display", "Video (colorimetric)"]
    shot = [CELFX, "render", "builtin:flame", "-q", "--frames", "12", "--set", "size=[160, 160]"]
    shot += ["--set", "background=[0.2, 0.05, 0.4]"]
    subprocess.run([*shot, "-o", FOLDER / "linear.exr"], check=True)
    linear, _ = read("linear.exr")
    for name, (display, view) in named.items():
        run = [*shot, "-o", FOLDER / "view.png", "--set", f"output.view='{name}'"]
        done = subprocess.run(run, capture_output=True, text=True)
        if "built without OpenColorIO" in done.stderr:
            print(f"SKIPPED: decoders: the view {name}: {CELFX} was built without OpenColorIO")
            continue
        need(done.returncode == 0, done.stderr)
        transform = ocio.DisplayViewTransform("Linear Rec.709 (sRGB)", display, view)
        expected = np.ascontiguousarray(np.stack([linear[c] for c in "RGB"], -1))
        config.getProcessor(transform).getDefaultCPUProcessor().applyRGB(expected)
        found = oiio.ImageBuf(str(FOLDER / "view.png")).get_pixels(oiio.UINT8)[..., :3].astype(int)
        # Half a step, as codes are whole; and a thousandth of one, as functions of two libraries differ in their last digits.
        apart = np.abs(found - np.clip(expected, 0, 1) * 255).max()
        need(apart <= 0.501, f"view {name}: {apart} of 255 from OpenColorIO")


smoke()
mesh()
views()
print("decoders: all is as OpenImageIO", oiio.VERSION_STRING, "the Cryptomatte API and OpenColorIO", ocio.__version__, "have it")
