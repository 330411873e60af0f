// From the pixels of a camera to the work area and back, by a plane map and the lens.
import { facing, inverseMap, project } from "../base/geometry.js";

const FARTHEST = 1e4; // r^2
const NOT_SHOWN = [NaN, NaN];

/** Return the map on the side of the middle of a picture, and that middle. */
function faced({ map, intrinsics, size }) {
  const middle = idealPixel(intrinsics, [size[0] / 2, size[1] / 2]);
  return [facing(map, middle), middle];
}

/** Return what takes a pixel to a point of the work area; of a frame, or its like. */
export function pixelToArea(frame) {
  const [map] = faced(frame);
  return (pixel) => project(map, idealPixel(frame.intrinsics, pixel));
}

/** Return what takes a point of the work area to a pixel. */
export function areaToPixel(frame) {
  const [map, middle] = faced(frame);
  const back = facing(inverseMap(frame.map), project(map, middle));
  const distorted = distorting(frame.intrinsics);
  return (point) => distorted(project(back, point));
}

/** Where a pixel of the frame that is shown is on the work area; null where it shows none of it. */
export function areaOf({ frame }, pixel) {
  const place = pixel && frame ? pixelToArea(frame)(pixel) : [NaN];
  return Number.isNaN(place[0]) ? null : place;
}

// The lens, as the core's Intrinsics has it: [fx, fy, cx, cy, k1, k2, p1, p2, k3] between ideal
// pixels [u, v] and pixels of frames; null = an ideal lens.

/** Return the largest r^2 up to which the displayed radius grows with r, in steps of 1 %. */
function foldOf([, , , , k1, k2, , , k3]) {
  const grows = (q) => 1 + q * (3 * k1 + q * (5 * k2 + q * 7 * k3)) > 0;
  let q = 1e-4;
  while (q < FARTHEST && grows(q)) q *= 1.01;
  return q;
}

/** Return where a lens shows x, y, in focal lengths, and the derivatives there: xx, xy, yy. */
function throughLens([, , , , k1, k2, p1, p2, k3], [x, y]) {
  const q = x * x + y * y;
  const radial = 1 + q * (k1 + q * (k2 + q * k3));
  const growth = 2 * (k1 + q * (2 * k2 + q * 3 * k3));
  return [
    x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x),
    y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y,
    radial + x * x * growth + 2 * p1 * y + 6 * p2 * x,
    x * y * growth + 2 * p1 * x + 2 * p2 * y,
    radial + y * y * growth + 6 * p1 * y + 2 * p2 * x,
  ];
}

/** Return a function from ideal pixels to frame pixels; NaN outside of the lens's image. */
function distorting(intrinsics) {
  if (!intrinsics) return (pixel) => pixel;
  const [fx, fy, cx, cy] = intrinsics;
  const limit = foldOf(intrinsics);
  return ([u, v]) => {
    const [x, y] = [(u - cx) / fx, (v - cy) / fy];
    if (!(x * x + y * y < limit)) return NOT_SHOWN;
    const [sx, sy, xx, xy, yy] = throughLens(intrinsics, [x, y]);
    return xx + yy > 0 && xx * yy > xy * xy ? [cx + sx * fx, cy + sy * fy] : NOT_SHOWN;
  };
}

/** Return the ideal pixel of one of the frames, by Newton's method; NaN as above. */
function idealPixel(intrinsics, pixel) {
  if (!intrinsics) return pixel;
  const [fx, fy, cx, cy] = intrinsics;
  const wanted = [(pixel[0] - cx) / fx, (pixel[1] - cy) / fy];
  let [x, y] = wanted;
  for (let i = 0; i < 30; i++) {
    const [sx, sy, xx, xy, yy] = throughLens(intrinsics, [x, y]);
    const [ex, ey] = [wanted[0] - sx, wanted[1] - sy];
    const determinant = xx * yy - xy * xy;
    x += (yy * ex - xy * ey) / determinant;
    y += (xx * ey - xy * ex) / determinant;
  }
  const ideal = [cx + x * fx, cy + y * fy];
  const [u, v] = distorting(intrinsics)(ideal);
  return Math.hypot(u - pixel[0], v - pixel[1]) < 0.01 ? ideal : NOT_SHOWN;
}
