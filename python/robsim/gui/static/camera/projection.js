// @ts-check
// From the canvas to the work area and back, by the plane map of the frame that is shown.
import { distance, facing, inverseMap, project } from "../base/geometry.js";

const middleOf = ({ size }) => [size[0] / 2, size[1] / 2];

export function makeProjection(context, lens) {
  const toArea = (at) =>
    project(facing(context.frame.map, middleOf(context.frame)), lens.toPixel(at));
  return {
    toArea,
    /** Where a point of the canvas is on the work area; null beside the picture. */
    areaOf: (at) => (at && context.frame && lens.holds(at) ? toArea(at) : null),
    /** The size of a pixel of the screen on the work area, about. */
    pixelSize: () => distance(toArea([0, 0]), toArea([devicePixelRatio, 0])) || 1,
    /** What takes points of the work area to the canvas. */
    toCanvas: () => {
      const { map } = context.frame;
      const middle = middleOf(context.frame);
      const back = facing(inverseMap(map), project(facing(map, middle), middle));
      return (point) => lens.toCanvas(project(back, point));
    },
  };
}
