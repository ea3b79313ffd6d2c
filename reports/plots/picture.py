"""A finished picture: lossless WebP at twice the density of the screen, with its size on the page and its description."""

import io
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

CSS_DENSITY: Final = 96  # CSS pixels per inch, by definition
SHARPNESS: Final = 2  # picture pixels per CSS pixel: sharp on fine screens, and 192 dpi in print
COLOURS: Final = 32  # lines and their smoothed edges need no more, and every further one makes the file larger


@dataclass(frozen=True)
class Picture:
    """A picture for the page.

    Attributes:
        data: the file's content.
        mime: its type, e.g. "image/webp".
        width: CSS pixels.
        height: CSS pixels.
        alt: what it shows, in words.
    """

    data: bytes
    mime: str
    width: int
    height: int
    alt: str


def picture(figure: Figure, alt: str, colours: int = COLOURS) -> Picture:
    """Render a figure. Its size in inches is its size on the page at 96 CSS pixels per inch; pyplot is not involved.

    Args:
        figure: complete.
        alt: what it shows, in words.
        colours: how many different ones are kept.
    """
    figure.set_dpi(CSS_DENSITY * SHARPNESS)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    reduced = image.quantize(colours, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).convert("RGB")
    file = io.BytesIO()
    reduced.save(file, "WEBP", lossless=True, method=4)
    return Picture(file.getvalue(), "image/webp", round(image.width / SHARPNESS), round(image.height / SHARPNESS), alt)
