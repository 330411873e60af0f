// Lines and dots over the camera's picture, set off against any floor.

const OVERLAY_WIDTH = 1.5; // px on the screen
const halos = new Map();

/**
 * Return a contrasting outline colour: black or white, the farther one from `color`.
 */
export function haloOf(pen, color) {
  if (!halos.has(color)) {
    pen.fillStyle = color; // comes back as #rrggbb
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(String(pen.fillStyle).slice(at, at + 2), 16));
    const isDark = 0.3 * r + 0.59 * g + 0.11 * b < 90;
    halos.set(color, isDark ? "rgb(255 255 255 / 0.75)" : "rgb(0 0 0 / 0.6)");
  }
  return halos.get(color);
}

/** Stroke the path of the pen, with its halo. */
export function strokePath({ pen, unit }, color, { width = OVERLAY_WIDTH, dash = [] } = {}) {
  pen.lineJoin = pen.lineCap = "round";
  pen.setLineDash(dash.map((length) => length * unit));
  for (const [wide, ink] of [[width + 1.5, haloOf(pen, color)], [width, color]]) {
    pen.lineWidth = wide * unit;
    pen.strokeStyle = ink;
    pen.stroke();
  }
  pen.setLineDash([]);
}

/** Draw a line through points of the canvas. */
export function drawLine(scene, points, color, { isClosed = false, ...options } = {}) {
  scene.pen.beginPath();
  for (const [x, y] of points) scene.pen.lineTo(x, y);
  if (isClosed) scene.pen.closePath();
  strokePath(scene, color, options);
}

/** Draw the rectangle between two corners on the canvas. */
export function drawBox(scene, [left, top], [right, bottom], color, options = {}) {
  const corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
  drawLine(scene, corners, color, { isClosed: true, ...options });
}

/** Draw an arrow between two points of the canvas; `head` is how long its barbs are. */
export function drawArrow(scene, from, to, color, { width = 2, head = 10 * scene.unit } = {}) {
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  const barb = (turn) =>
    [to[0] - head * Math.cos(angle + turn), to[1] - head * Math.sin(angle + turn)];
  drawLine(scene, [from, to, barb(0.5), to, barb(-0.5)], color, { width });
}

/** Draw a cross with a gap, in which the point itself is seen, and a ring around it. */
export function drawCross(scene, [x, y], color, { long, width, isRinged = false }) {
  const { pen, unit } = scene;
  const [gap, end] = [3 * unit, long * unit];
  pen.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    pen.moveTo(x + gap * dx, y + gap * dy);
    pen.lineTo(x + end * dx, y + end * dy);
  }
  if (isRinged) {
    pen.moveTo(x + end, y);
    pen.arc(x, y, end, 0, 2 * Math.PI);
  }
  strokePath(scene, color, { width });
}

/** Draw a dot at a point of the canvas, with its halo. */
export function drawDot({ pen, unit }, [x, y], color, radius = 2.5) {
  for (const [size, ink] of [[radius + 1, haloOf(pen, color)], [radius, color]]) {
    pen.beginPath();
    pen.arc(x, y, size * unit, 0, 2 * Math.PI);
    pen.fillStyle = ink;
    pen.fill();
  }
}

/** Write a text beside a pixel, on a dark ground; not over those that are `taken`. */
export function drawLabel({ pen, pixel, unit }, label) {
  const { at, words, beside, ink, isStrong = false, taken } = label;
  const [x, y] = pixel(at);
  pen.font = `${isStrong ? 700 : 500} ${(isStrong ? 13 : 11) * unit}px system-ui, sans-serif`;
  const wide = pen.measureText(words).width + 6 * unit;
  const tall = (isStrong ? 17 : 14) * unit;
  const left = x - wide / 2 + beside[0] * (wide / 2 + 5 * unit);
  const top = y - tall / 2 + beside[1] * (tall / 2 + 5 * unit);
  if (taken?.some(([l, t, w, h]) =>
    left < l + w && l < left + wide && top < t + h && t < top + tall)) return;
  taken?.push([left, top, wide, tall]);
  pen.fillStyle = "#000a";
  pen.fillRect(left, top, wide, tall);
  pen.fillStyle = ink;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(words, left + wide / 2, top + tall / 2 + unit / 2);
}
