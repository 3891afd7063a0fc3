"""The README's moving picture, of the demo's results: `make demo`, then here in tests/
`python -m support.moving_picture` writes docs/moored_buoy.gif anew.

It is the animation of `m4e-fmi run --animate`, drawn by Chromium, with values of the results above
it: some waves at twice their speed, which begin and end alike.
"""

from __future__ import annotations

import io
import sys
import tempfile
from base64 import b64decode
from pathlib import Path

import numpy as np
from PIL import Image, ImageColor
from support.browser import browser

from m4e_fmi.report import animate_run
from m4e_fmi.results.results_file import Results, load_results

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs" / "moored_buoy.gif"
WIDTH, HEIGHT, TOP = 800, 390, 600
"""Pixels: of the picture, and the height of the window, which the animation follows."""
BETWEEN, SPEED, COLOURS = 100, 2.0, 49
"""Time between two pictures [ms], seconds of the run in one of the picture, colours."""
THIN, WATER = ("#b5452c", "#2a7f62", "#7a4fa3", "#22303c"), (232, 242, 248)
"""Colours of lines, and of the water behind them."""
SHORTEST, LONGEST, SETTLED = 14.0, 19.0, 60.0
"""Of the span of the run that is shown [s]: least and most, and its earliest start."""
VIEW = """
const style = document.createElement("style");
style.textContent = `body, html { background: #fff } h1, p { display: none }
  main { padding: 0 !important; max-width: none !important }
  .animation canvas { border: 0 !important } .animation .controls { display: none !important }
  .animation .legend { display: none !important }
  pre { position: fixed; top: 14px; left: 24px; margin: 0; color: #22303c;
    font: 21px/1.35 "DejaVu Sans", sans-serif }
  pre span { display: inline-block; margin-right: 26px }
  pre b { display: inline-block; min-width: 74px; text-align: right }`;
document.head.append(style);
const values = document.createElement("pre");
document.body.append(values);
window.dispatchEvent(new Event("resize"));
document.querySelector(".trails").checked = false;
player.eye.turn += 0.38; player.eye.rise += 0.17; player.eye.zoom = 0.52;
"""
SHOWN = {
    "wave": ("hydro.wave.elevation", 1.0, "m", 1),
    "power": ("generator.power", 1e-3, "kW", 0),
    "upwave line": ("mooring.line_1.fairlead_tension", 1e-3, "kN", 0),
}
"""What is above the picture: name, variable, factor, unit, digits."""
ALIKE = ("hydro.wave.elevation", "buoy.body.float.x", "buoy.body.float.z", "buoy.body.float.theta")


def span_of(results: Results) -> tuple[float, float]:
    """Start and length [s] of some large waves that begin and end most alike."""
    time = results.time
    step = float(time[1] - time[0])
    rows = np.array([results[name].values / np.std(results[name].values) for name in ALIKE])
    state = np.vstack(
        [rows, np.gradient(rows, axis=1) / np.std(np.gradient(rows, axis=1), axis=1)[:, None]]
    )
    found = []
    for n in range(round(SHORTEST / step), round(LONGEST / step)):
        apart = np.linalg.norm(state[:, n:] - state[:, :-n], axis=0)
        heights = np.std(np.lib.stride_tricks.sliding_window_view(rows[0], n + 1), axis=1)
        apart[(time[: apart.size] < SETTLED) | (heights < 1)] = np.inf
        found.append((apart.min(), float(time[apart.argmin()]), n * step))
    return min(found)[1:]


def pictures(results: Results, times: np.ndarray) -> list[Image.Image]:
    """The animation at each of the times [s]."""
    found = []
    with tempfile.TemporaryDirectory() as name, browser(Path(name)) as page:
        window = {"width": WIDTH, "height": TOP, "deviceScaleFactor": 1, "mobile": False}
        page.call("Emulation.setDeviceMetricsOverride", **window)
        page.open(animate_run(results, Path(name) / "buoy.html"))
        page.value(VIEW)
        clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT, "scale": 1}
        for time in times:
            texts = ""
            for what, (name, factor, unit, digits) in SHOWN.items():
                value = factor * np.interp(time, results.time, results[name].values)
                text = f"{value:.{digits}f}".replace("-", "−")
                texts += f"<span>{what} <b>{text}</b> {unit}</span>"
            page.value(f"values.innerHTML = `{texts}`; player.seek({time})")
            shot = page.call("Page.captureScreenshot", format="png", clip=clip)
            found.append(Image.open(io.BytesIO(b64decode(shot["data"]))).convert("RGB"))
    return found


def palette_of(image: Image.Image) -> Image.Image:
    """The colours of an image, with those of the thin lines, which are rare, and their edges."""
    thin = Image.new("RGB", (len(THIN), 3))
    for k, colour in enumerate(THIN):
        line = ImageColor.getrgb(colour)
        for n, share in enumerate((1.0, 0.7, 0.4)):
            mixed = tuple(
                round(share * a + (1 - share) * b) for a, b in zip(line, WATER, strict=True)
            )
            thin.putpixel((k, n), mixed)
    common = image.quantize(COLOURS).getpalette() or []
    for k in range(0, len(common), 3):
        if min(common[k : k + 3]) > 246:
            common[k : k + 3] = [255, 255, 255]  # the paper
    found = Image.new("P", (1, 1))
    found.putpalette(common[: 3 * COLOURS] + list(thin.tobytes()))
    return found


def write(results: Results, path: Path) -> None:
    """Write the moving picture of the demo's results to `path` (.gif)."""
    start, length = span_of(results)
    count = round(length / SPEED / BETWEEN * 1000)
    shown = pictures(results, start + length / count * np.arange(count))
    palette = palette_of(shown[0])
    first, *rest = (image.quantize(palette=palette, dither=Image.Dither.NONE) for image in shown)
    first.save(path, save_all=True, append_images=rest, duration=BETWEEN, loop=0, optimize=True)
    print(
        f"{path.name}: {start:.1f} s to {start + length:.1f} s, {path.stat().st_size / 1e6:.2f} MB"
    )


if __name__ == "__main__":
    write(load_results(sys.argv[1] if sys.argv[1:] else ROOT / "build" / "moored_buoy.nc"), PICTURE)
