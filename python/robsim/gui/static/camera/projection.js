// @ts-check
// From the pixels of a camera to the work area and back, by a plane map and the lens.
import { distance, facing, inverseMap, project } from "../base/geometry.js";
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

/** The same between the canvas and the work area, by the frame that is shown. */
export function makeProjection(context, lens) {
  const toArea = (at) => pixelToArea(context.frame)(lens.toPixel(at));
  return {
    toArea,
    /** Where a point of the canvas is on the work area; null where the picture shows none of it. */
    areaOf: (at) => {
      const place = at && context.frame && lens.holds(at) ? toArea(at) : [NaN];
      return Number.isNaN(place[0]) ? null : place;
    },
    /** The size of a pixel of the screen on the work area, about. */
    pixelSize: () => distance(toArea([0, 0]), toArea([devicePixelRatio, 0])) || 1,
    /** What takes points of the work area to the canvas. */
    toCanvas: () => {
      const toPixel = areaToPixel(context.frame);
      return (point) => lens.toCanvas(toPixel(point));
    },
  };
}
