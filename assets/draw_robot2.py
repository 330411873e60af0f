"""Draw the robot "robot2": a print of a photo, a person in a red jacket before blue sky."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from draw_face import paint_face
from draw_person import Person, head_frame
from draw_solids import lit, march, normals, openness, unit_vector
from draw_tools import chroma, noise, palette, ramp
from PIL import Image

SIZE = 112.0  # work-area px, the width of the picture
WIDTH, HEIGHT, BORDER = 392, 490, 7  # picture px; the border is the print's white edge
FINER = 2  # samples along a picture px while drawing
SPAN, TOP = 5.0, 2.24  # head units: across the photo, and from the eyes to its upper edge
FAR = -2.0  # behind the person
SUN = unit_vector(-0.52, 0.58, 0.63)
GLINT = unit_vector(SUN[0], SUN[1], SUN[2] + 1)  # half way from the sun to the viewer

# Levels of the sky from the shoulders up. They, and those of the jacket from its seams to where
# the sun meets it, keep their colour even in the shadow of the work area.
SKY = ((0.3, (78, 142, 240)), (0.65, (50, 112, 224)), (1.0, (30, 84, 198)))
CLOUD = np.array([190.0, 218.0, 255.0])
JACKET = (
    (0.35, (112, 2, 14)),
    (0.75, (172, 12, 22)),
    (1.05, (214, 32, 36)),
    (1.3, (242, 92, 88)),
)
SKIN, HAIR = np.array([0.74, 0.44, 0.31]), np.array([0.105, 0.055, 0.028])
HAIR_GLOSS = np.array([0.20, 0.135, 0.085])
SHIRT = np.array([0.55, 0.56, 0.58])
MOST_RED = 26.0  # V - 128 that skin and hair may reach, well below that of a red marker


@dataclass
class Surface:
    """What the camera sees of the person: points (3, n), which part, normals, light."""

    p: np.ndarray
    part: np.ndarray
    normal: np.ndarray
    opened: np.ndarray
    sun: np.ndarray

    @classmethod
    def of(cls, person: Person, p: np.ndarray) -> Surface:
        """The surface of a person at points."""
        normal = normals(person, p)
        light = lit(person, p + 0.01 * normal, SUN.astype(np.float32))
        part = np.argmin(person.parts(p), axis=0)
        return cls(p, part, normal, openness(person, p, normal), light)

    def light(self) -> np.ndarray:
        """Light (n, 3): the sun, the sky above, and what the surroundings throw back."""
        right, up, front = self.normal
        direct = self.sun * np.clip((SUN @ self.normal + 0.12) / 1.12, 0, None)
        ambient = self.opened * (0.62 + 0.38 * up)
        fill = self.opened * np.clip(0.5 * right + 0.6 * front, 0, None)
        colours = np.array([[1.55, 1.42, 1.24], [0.27, 0.30, 0.36], [0.24, 0.22, 0.21]])
        return np.stack([direct, ambient, fill], -1) @ colours

    def gloss(self, sharpness: float) -> np.ndarray:
        """The sun's reflection (n,)."""
        return self.sun * np.clip(GLINT @ self.normal, 0, 1) ** sharpness


def shade(surface: Surface, person: Person) -> np.ndarray:
    """Levels (n, 3) of the person's surface."""
    q, light = head_frame(surface.p), surface.light()
    tone = person.strands.tone_at(q)
    skin = paint_face(q, np.broadcast_to(SKIN, light.shape)) * light
    skin += 0.05 * surface.gloss(18)[:, None]
    sheen = surface.gloss(6) * (0.4 + 0.6 * np.clip(0.5 + 0.5 * tone, 0, 1.5))
    hair = np.clip(0.85 + 0.40 * tone, 0.3, 2.2)[:, None] * HAIR * light
    hair += sheen[:, None] * HAIR_GLOSS
    linear = np.choose(surface.part[:, None], (skin, hair, hair, SHIRT * light))
    brightness = light.mean(1) + 0.25 * surface.gloss(24)
    jacket = palette(brightness ** (1 / 2.2), JACKET)
    return np.where(
        surface.part[:, None] == person.JACKET,
        jacket,
        less_red(255 * np.clip(linear, 0, 1) ** (1 / 2.2)),
    )


def less_red(rgb: np.ndarray) -> np.ndarray:
    """Levels whose V stays below what a red marker has; softly, and the brightness stays."""
    _, v = chroma(rgb)
    knee = 0.7 * MOST_RED
    over = np.clip(v - knee, 0, None)
    allowed = np.where(over > 0, knee + (MOST_RED - knee) * np.tanh(over / (MOST_RED - knee)), v)
    share = np.where(over > 0, allowed / np.maximum(v, 1e-3), 1)[..., None]
    grey = rgb @ np.array([0.299, 0.587, 0.114])
    return grey[..., None] + share * (rgb - grey[..., None])


def sky(x: np.ndarray, y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Levels of a blue sky, deeper above, with thin clouds."""
    high = (y - y.min()) / (y.max() - y.min())
    veil = noise(rng, x.shape, (34, 120)) + 0.6 * noise(rng, x.shape, (12, 50))
    veil += 0.25 * noise(rng, x.shape, (4, 14))
    rgb = palette(high, SKY)
    return rgb + 0.30 * ramp(veil, 0.2, 2.6)[..., None] * (CLOUD - rgb)


def photo() -> np.ndarray:
    """Levels of the photo, FINER samples a picture px."""
    width, height = FINER * (WIDTH - 2 * BORDER), FINER * (HEIGHT - 2 * BORDER)
    unit = SPAN / width
    right = ((np.arange(width) + 0.5) * unit - SPAN / 2).astype(np.float32)
    up = (TOP - (np.arange(height) + 0.5) * unit).astype(np.float32)
    x, y = np.meshgrid(right, up)
    person = Person(np.random.default_rng(12))
    z = march(person, x.ravel(), y.ravel(), 1.6, FAR)
    hit = np.flatnonzero(z > FAR)
    p = np.stack([x.ravel()[hit], y.ravel()[hit], z[hit]])
    rgb = sky(x, y, np.random.default_rng(6)).reshape(-1, 3)
    rgb[hit] = shade(Surface.of(person, p), person)
    return rgb.reshape(height, width, 3)


def draw_robot2() -> Image.Image:
    """The print's RGBA picture, opaque; the person's head is up."""
    size = (WIDTH - 2 * BORDER, HEIGHT - 2 * BORDER)
    layers = [Image.fromarray(layer.astype(np.float32)) for layer in np.moveaxis(photo(), -1, 0)]
    small = np.stack([layer.resize(size, Image.Resampling.HAMMING) for layer in layers], -1)
    # The film's grain is grey: it leaves U and V alone.
    small += 1.5 * noise(np.random.default_rng(5), size[::-1], 0.6)[..., None]
    image = Image.fromarray(np.clip(np.round(small), 0, 255).astype(np.uint8))
    result = Image.new("RGBA", (WIDTH, HEIGHT), (236, 235, 230, 255))
    result.paste(image, (BORDER, BORDER))
    return result
