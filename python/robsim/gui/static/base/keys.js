// @ts-check
// Keys on an element, and what is dragged on it.

/** Where the arrow keys lead, to the right and down. */
export const ARROWS =
  { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Return how far an arrow key leads, with Shift ten times as far; undefined for other keys. */
export const arrowStep = ({ key, shiftKey }) =>
  ARROWS[key]?.map((side) => side * (shiftKey ? 10 : 1));

/**
 * Let keys do something on an element: `act(event)` returns false for those of others. Escape goes
 * on to the panel, where it stops the robot.
 */
export function listenToKeys(element, act) {
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || act(event) === false) return;
    event.preventDefault();
    if (event.key != "Escape") event.stopPropagation();
  });
}

/** Let things be dragged: `begin(event)` returns {move(event), drop()} for what is there. */
export function listenToDrags(element, begin) {
  let held = null;
  element.addEventListener("pointerdown", (event) => {
    held = event.button ? null : begin(event);
    if (held) element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", (event) => held?.move(event));
  for (const type of ["pointerup", "pointercancel"])
    element.addEventListener(type, () => {
      held?.drop?.();
      held = null;
    });
}
