// @ts-check
// Keys and drags on an element.

/** Where the arrow keys lead, to the right and down. */
export const ARROWS =
  { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Return how far an arrow key leads, with Shift ten times as far; undefined for other keys. */
export const arrowStep = ({ key, shiftKey }) =>
  ARROWS[key]?.map((side) => side * (shiftKey ? 10 : 1));

/**
 * Handle keys on an element: `act(event)` returns false for an unknown key. Escape also reaches the
 * panel, which then stops the robot.
 */
export function listenToKeys(element, act) {
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || act(event) === false) return;
    event.preventDefault();
    if (event.key != "Escape") event.stopPropagation();
  });
}

/** Handle drags: `begin(event)` returns the dragged thing, {move(event), drop()}, or null. */
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
