// Points [x, y] under plane maps (3 x 3, row by row), poses, and lines made simpler.

/** Return the inverse of a plane map, up to a factor. */
export function inverseMap([a, b, c, d, e, f, g, h, i]) {
  return [
    e * i - f * h, c * h - b * i, b * f - c * e,
    f * g - d * i, a * i - c * g, c * d - a * f,
    d * h - e * g, b * g - a * h, a * e - b * d,
  ];
}

/** Return a map with a factor that makes the third number positive on the side of a point. */
export function facing(map, [x, y]) {
  return map[6] * x + map[7] * y + map[8] < 0 ? map.map((value) => -value) : map;
}

/** Return where a map takes a point; NaN behind the camera, which canvases leave out. */
export function project(map, [x, y]) {
  const w = map[6] * x + map[7] * y + map[8];
  if (!(w > 0)) return [NaN, NaN];
  return [(map[0] * x + map[1] * y + map[2]) / w, (map[3] * x + map[4] * y + map[5]) / w];
}

/** Return where [forward, right] of a robot is. */
export function fromRobot([x, y, heading], [forward, right]) {
  const c = Math.cos(heading);
  const s = Math.sin(heading);
  return [x + c * forward - s * right, y + s * forward + c * right];
}

/** Return [forward, right] of a point, seen from a robot. */
export function toRobot([x, y, heading], [px, py]) {
  const c = Math.cos(heading);
  const s = Math.sin(heading);
  return [c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)];
}

export const distance = ([ax, ay], [bx, by]) => Math.hypot(bx - ax, by - ay);

/** Whether a point lies in a polygon: an odd number of edges is above it. */
export function isInside(polygon, [x, y]) {
  let inside = false;
  polygon.forEach(([ax, ay], i) => {
    const [bx, by] = polygon.at(i - 1);
    if (ay > y != by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}

/**
 * Return points of the ellipse so many standard deviations around the origin; `P` 3 x 3, row by
 * row.
 */
export function ellipse(P, sigmas, count = 48) {
  const [xx, xy, yy] = [P[0], P[1], P[4]];
  const tilt = Math.atan2(2 * xy, xx - yy) / 2;
  const middle = (xx + yy) / 2;
  const radius = Math.hypot((xx - yy) / 2, xy);
  const long = sigmas * Math.sqrt(Math.max(middle + radius, 0));
  const short = sigmas * Math.sqrt(Math.max(middle - radius, 0));
  return Array.from({ length: count }, (_, i) => {
    const turn = (2 * Math.PI * i) / count;
    return fromRobot([0, 0, tilt], [long * Math.cos(turn), short * Math.sin(turn)]);
  });
}

function distanceToEdge(point, a, b) {
  const length = distance(a, b);
  if (!length) return distance(point, a);
  const along =
    ((point[0] - a[0]) * (b[0] - a[0]) + (point[1] - a[1]) * (b[1] - a[1])) / length ** 2;
  const t = Math.min(Math.max(along, 0), 1);
  return distance(point, [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
}

/** Return the point between two others of a line that is farthest from the straight way. */
function farthestBetween(points, first, last) {
  const farthest = { first, last, at: first, off: 0 };
  for (let i = first + 1; i < last; i++) {
    const off = distanceToEdge(points[i], points[first], points[last]);
    if (off > farthest.off) [farthest.off, farthest.at] = [off, i];
  }
  return farthest;
}

/**
 * Return a line with fewer points, by Douglas and Peucker: the farthest ones come back first, until
 * all are within the tolerance, or there are so many.
 */
export function simplified(points, tolerance, most) {
  const kept = [0, points.length - 1];
  const pieces = [farthestBetween(points, 0, points.length - 1)];
  while (kept.length < most) {
    pieces.sort((one, other) => one.off - other.off);
    const { first, last, at, off } = pieces.pop();
    if (off <= tolerance) break;
    kept.push(at);
    pieces.push(farthestBetween(points, first, at), farthestBetween(points, at, last));
  }
  return kept.sort((one, other) => one - other).map((i) => points[i]);
}
