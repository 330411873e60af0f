// @ts-check
// Lines and dots over the camera's picture, set off against any floor.

const OVERLAY_WIDTH = 1.5; // px on the screen
const halos = new Map();

/**
 * Return what sets a colour off against any floor: black or white, whichever is farther from it.
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

/** Draw a line through points of the canvas, with its halo. */
export function drawLine({ pen, unit }, points, color, options = {}) {
  const { width = OVERLAY_WIDTH, isClosed = false, dash = [] } = options;
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  if (isClosed) pen.closePath();
  pen.lineJoin = pen.lineCap = "round";
  pen.setLineDash(dash.map((length) => length * unit));
  pen.strokeStyle = haloOf(pen, color);
  pen.lineWidth = (width + 1.5) * unit;
  pen.stroke();
  pen.strokeStyle = color;
  pen.lineWidth = width * unit;
  pen.stroke();
  pen.setLineDash([]);
}

/** Draw a dot at a point of the canvas, with its halo. */
export function drawDot({ pen, unit }, [x, y], color, radius = 2.5) {
  pen.beginPath();
  pen.arc(x, y, (radius + 1) * unit, 0, 2 * Math.PI);
  pen.fillStyle = haloOf(pen, color);
  pen.fill();
  pen.beginPath();
  pen.arc(x, y, radius * unit, 0, 2 * Math.PI);
  pen.fillStyle = color;
  pen.fill();
}
