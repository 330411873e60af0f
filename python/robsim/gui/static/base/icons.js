// The icons: paths on a grid of 16.
import { make } from "./dom.js";

const ICONS = {
  start: "M4 2.3v11.4c0 .6.6 1 1.1.7l8.6-5.7c.4-.3.4-1 0-1.3L5.1 1.7C4.6 1.3 4 1.7 4 2.3z",
  pause: "M3.5 2h2.5c.3 0 .5.2.5.5v11c0 .3-.2.5-.5.5H3.5c-.3 0-.5-.2-.5-.5v-11c0-.3.2-.5.5-.5zm6.5 0h2.5c.3 0 .5.2.5.5v11c0 .3-.2.5-.5.5H10c-.3 0-.5-.2-.5-.5v-11c0-.3.2-.5.5-.5z",
  step: "M3 2.6v10.8c0 .5.6.8 1 .5l6.5-5.4c.3-.3.3-.7 0-1L4 2.1c-.4-.3-1 0-1 .5zM12 2h1.5v12H12z",
  step_stage: "M2 7.2h1.6v1.6H2zm3 0h1.6v1.6H5zm3-4v9.6c0 .4.5.7.8.4l5.4-4.8c.2-.2.2-.6 0-.8L8.8 2.8c-.3-.3-.8 0-.8.4z",
  reset: "M8 2.5V.6c0-.3-.4-.5-.6-.3L3.9 3.1c-.2.2-.2.5 0 .7l3.5 2.8c.2.2.6 0 .6-.3V4.2a4.4 4.4 0 1 1-4.3 5.3H2A6.1 6.1 0 1 0 8 2.5z",
  finish: "M2.5 1.5H4v.8c1.4-.7 3-.7 4.6 0 1.4.6 2.7.6 4 .1.4-.2.9.1.9.6v6.3c0 .3-.2.5-.4.6-1.6.7-3.3.7-5 0-1.4-.6-2.7-.6-4.1-.1v4.7H2.5z",
  stop: "M5 1.2h6L14.8 5v6L11 14.8H5L1.2 11V5z",
  newest: "M2.5 2.6v10.8c0 .5.6.8 1 .5L8 10v3.4c0 .5.6.8 1 .5l5.5-5.4c.3-.3.3-.7 0-1L9 2.1c-.4-.3-1 0-1 .5V6L3.5 2.1c-.4-.3-1 0-1 .5z",
  slowly: "M1.5 4h3.2v8H1.5zm4.7-2h3.6v12H6.2zm5.1 2h3.2v8h-3.2z",
  share: "M8 .8l4 4-1.1 1.1-2.1-2.1V10H7.2V3.8L5.1 5.9 4 4.8zM2.5 7.5h2V9H4v4.5h8V9h-.5V7.5h2V15h-11z",
  home: "M2 2h5v5H2zm7 0h5v5H9zM2 9h5v5H2zm7 0h5v5H9z",
  close: "M3.3 4.4l1.1-1.1L8 6.9l3.6-3.6 1.1 1.1L9.1 8l3.6 3.6-1.1 1.1L8 9.1l-3.6 3.6-1.1-1.1L6.9 8z",
  auto: "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 1.6v10.8A5.4 5.4 0 0 1 8 2.6z",
  light: "M8 4.8a3.2 3.2 0 1 0 0 6.4 3.2 3.2 0 0 0 0-6.4zM7.3.5h1.4v2.6H7.3zm0 12.4h1.4v2.6H7.3zM.5 7.3h2.6v1.4H.5zm12.4 0h2.6v1.4h-2.6zM2.2 3.2l1-1 1.8 1.8-1 1zm8.8 8.8l1-1 1.8 1.8-1 1zM12 4l1.8-1.8 1 1L13 5zM2.2 12.8L4 11l1 1-1.8 1.8z",
  dark: "M6.3 1.6a6.6 6.6 0 1 0 8.1 8.1A5.4 5.4 0 0 1 6.3 1.6z",
  palette: "M8 1C3.9 1 1 4 1 8s3.1 7 7 7c1.1 0 1.7-.8 1.7-1.6 0-.9-.7-1.2-.7-2 0-.7.5-1.2 1.3-1.2H12c1.8 0 3-1.3 3-3.1C15 3.6 11.9 1 8 1zM4.3 8.9a1.2 1.2 0 1 1 0-2.4 1.2 1.2 0 0 1 0 2.4zM6 5.5a1.2 1.2 0 1 1 0-2.4 1.2 1.2 0 0 1 0 2.4zm4 0a1.2 1.2 0 1 1 0-2.4 1.2 1.2 0 0 1 0 2.4zm2 3a1.2 1.2 0 1 1 0-2.4 1.2 1.2 0 0 1 0 2.4z",
  keys: "M2 3.5h12c.8 0 1.5.7 1.5 1.5v6c0 .8-.7 1.5-1.5 1.5H2c-.8 0-1.5-.7-1.5-1.5V5c0-.8.7-1.5 1.5-1.5zM3 5.5V7h1.5V5.5zm2.8 0V7h1.5V5.5zm2.9 0V7h1.5V5.5zm2.8 0V7H13V5.5zM4.5 9v1.5h7V9z",
  warning: "M8 1.5c.3 0 .6.2.8.5l6.4 11.3c.3.6-.1 1.2-.8 1.2H1.6c-.7 0-1.1-.6-.8-1.2L7.2 2c.2-.3.5-.5.8-.5zM7.2 5.5l.2 4.5h1.2l.2-4.5zm.8 5.7a.95.95 0 1 0 0 1.9.95.95 0 0 0 0-1.9z",
  edit: "M11.2 1.7l3.1 3.1-8.6 8.6-3.9.8.8-3.9z",
  to_callbacks: "M2 2.5h3v3H2zm5 .7h7v1.6H7zM2 6.5h3v3H2zm5 .7h7v1.6H7zm-5 3.3h3v3H2zm5 .7h7v1.6H7z",
  robot: "M5 2h6a3 3 0 0 1 3 3v6a3 3 0 0 1-3 3H5a3 3 0 0 1-3-3V5a3 3 0 0 1 3-3zm5.4 2.6a1.4 1.4 0 1 0 0 2.8 1.4 1.4 0 0 0 0-2.8zm0 4a1.4 1.4 0 1 0 0 2.8 1.4 1.4 0 0 0 0-2.8zM3.8 7.4v1.2h4V7.4z",
};
for (const [name, same] of Object.entries({ first: "start", go_on: "start", reset_option: "reset", end: "stop", sharing: "share" })) ICONS[name] = ICONS[same];

/** Return an icon, which says nothing to screen readers. */
export function icon(name) {
  const space = "http://www.w3.org/2000/svg";
  const element = document.createElementNS(space, "svg");
  element.setAttribute("viewBox", "0 0 16 16");
  element.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", ICONS[name]);
  path.setAttribute("fill-rule", "evenodd");
  element.append(path);
  return element;
}

/** `kind` "line", "stairs", "dots", "cross", or "box" for one that is filled. */
export function makeSwatch(kind, color) {
  const swatch = make(`i.robsim-swatch.robsim-swatch-${kind}`);
  swatch.style.setProperty("--robsim-swatch", color);
  return swatch;
}
