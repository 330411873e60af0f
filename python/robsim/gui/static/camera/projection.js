// @ts-check
// From the canvas to the work area and back, by the plane map of the frame that is shown.
import { distance, facing, inverseMap, project } from "../base/geometry.js";
import { distorting, idealPixel } from "./intrinsics.js";

const middleOf = ({ size, intrinsics }) => idealPixel(intrinsics, [size[0] / 2, size[1] / 2]);

export function makeProjection(context, lens) {
  const toArea = (at) => {
    const { frame } = context;
    const pixel = idealPixel(frame.intrinsics, lens.toPixel(at));
    return project(facing(frame.map, middleOf(frame)), pixel);
  };
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
      const { map, intrinsics } = context.frame;
      const middle = middleOf(context.frame);
      const back = facing(inverseMap(map), project(facing(map, middle), middle));
      const distorted = distorting(intrinsics);
      return (point) => lens.toCanvas(distorted(project(back, point)));
    },
  };
}
