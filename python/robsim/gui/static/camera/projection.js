// @ts-check
// From the pixels of a camera to the work area and back, by a plane map and the lens.
import { facing, inverseMap, project } from "../base/geometry.js";
import { distorting, idealPixel } from "./intrinsics.js";

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
