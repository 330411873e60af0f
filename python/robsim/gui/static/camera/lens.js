// @ts-check
// Where the camera's pixels lie on the canvas: letterboxed, zoomed, moved.

const MOST_ZOOM = 20; // times

/** All positions on the canvas are in device pixels; camera pixels are counted at their centres. */
export function makeLens() {
  const lens = { zoom: 1, scale: 1, left: 0, top: 0 };
  let box = [1, 1]; // of the canvas
  let size = [1, 1]; // of the picture
  let middle = [0.5, 0.5]; // what of the picture is in the middle, as parts of it

  const hold = (i, zoomed) => {
    // half of what there is room for
    const shown = Math.min(box[i] / zoomed, size[i]) / size[i] / 2;
    return Math.min(Math.max(middle[i], shown), 1 - shown);
  };
  const place = () => {
    lens.scale = lens.zoom * Math.min(box[0] / size[0], box[1] / size[1]);
    middle = [hold(0, lens.scale), hold(1, lens.scale)];
    lens.left = Math.round(box[0] / 2 - middle[0] * size[0] * lens.scale);
    lens.top = Math.round(box[1] / 2 - middle[1] * size[1] * lens.scale);
  };

  lens.fit = (newBox, newSize) => {
    [box, size] = [newBox, newSize];
    place();
  };
  lens.toCanvas = ([u, v]) =>
    [lens.left + (u + 0.5) * lens.scale, lens.top + (v + 0.5) * lens.scale];
  lens.toPixel = ([x, y]) =>
    [(x - lens.left) / lens.scale - 0.5, (y - lens.top) / lens.scale - 0.5];
  lens.holds = ([x, y]) => {
    const [u, v] = lens.toPixel([x, y]);
    return u >= -0.5 && v >= -0.5 && u < size[0] - 0.5 && v < size[1] - 0.5;
  };

  /** Move the picture by so many pixels of the canvas. */
  lens.move = ([dx, dy]) => {
    middle = [middle[0] - dx / (lens.scale * size[0]), middle[1] - dy / (lens.scale * size[1])];
    place();
  };
  /** Zoom so that what is at a point of the canvas stays there. */
  lens.zoomAt = (at, factor) => {
    const [u, v] = lens.toPixel(at);
    lens.zoom = Math.min(Math.max(lens.zoom * factor, 1), MOST_ZOOM);
    place();
    const [x, y] = lens.toCanvas([u, v]);
    lens.move([at[0] - x, at[1] - y]);
  };
  lens.reset = () => {
    lens.zoom = 1;
    place();
  };
  return lens;
}
