// The start page: a card for each thing to begin with, with a film of it.
import { asPicture } from "../base/buffers.js";
import { makeLooks } from "../base/buttons.js";
import { makeContext } from "../base/context.js";
import { fitCanvas, make, text } from "../base/dom.js";
import { icon } from "../base/icons.js";
import { makeNotes } from "../parts/notes.js";

const PACE = 80; // ms for each picture of a film
const NAMES = ["drive", "noise", "identify", "estimate", "task", "laboratory"];

export function renderStart({ el, send }) {
  const context = makeContext(el, send);
  const cards = new Map(NAMES.map((name) => [name, makeCard(context, name)]));
  const kept = make("button.robsim-button.robsim-primary", { type: "button", name: "resume",
    hidden: true, onclick: () => context.send({ type: "resume" }) });
  const head = make("header.robsim-start-head", icon("robot"), make("h1", text("start.head")),
    kept, makeLooks(context));
  const list = make("ul.robsim-start-cards", ...[...cards.values()].map(({ element }) => element));
  const foot = make("p.robsim-quiet", text("start.foot"));
  el.append(make("div.robsim-start", head, make("p", text("start.what")), list, foot),
    makeNotes(context).element);
  document.title = text("start.title");

  context.on("setup", ({ kept: steps }) => {
    kept.hidden = !steps;
    kept.textContent = text("start.resume", { steps });
  });
  context.on("film", (film, buffers) => cards.get(film.card)?.show(film, buffers));
  context.on("refused", () => cards.forEach((card) => card.rest()));
  play(context, cards);
  // Once the cards are painted: Python is busy with the films then.
  const begin = () => requestAnimationFrame(() => setTimeout(() =>
    send({ type: "hello", width: 1 })));
  return { ...context, begin };
}

function makeCard(context, name) {
  const canvas = make("canvas", { role: "img", ariaLabel: text(`start.${name}.picture`) });
  const busy = make("span.robsim-chip.robsim-active", { hidden: true }, text("start.opening"));
  const open = () => {
    busy.hidden = false;
    context.send({ type: "open", card: name });
  };
  const title = make("span.robsim-start-title", text(`start.${name}`));
  const look = make("span.robsim-start-look", text(`start.${name}.look`));
  const button = make("button.robsim-surface.robsim-start-card",
    { type: "button", name: `open_${name}`, onclick: open }, canvas, title, busy, look);
  let film = null;
  const show = async (told, buffers) => {
    const pictures = await Promise.all(buffers.map((jpeg) => asPicture(jpeg, "image/jpeg")));
    film = { ...told, pictures };
    paint(0);
  };
  /** Paint picture `i` of the film, or the last one. */
  const paint = (i) => film && drawFilm(context, canvas, film, i % film.pictures.length);
  const end = () => paint(film?.pictures.length - 1);
  return { element: make("li", button), show, paint, end, rest: () => (busy.hidden = true) };
}

/** Move the films on, unless the user wants no motion: then each shows its end. */
function play(context, cards) {
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const step = () => cards.forEach((card) =>
    (calm.matches ? card.end() : card.paint(Math.floor(performance.now() / PACE))));
  const timer = setInterval(() => requestAnimationFrame(step), PACE);
  context.onEnd(() => clearInterval(timer));
}

function drawFilm(context, canvas, film, i) {
  fitCanvas(canvas);
  const pen = canvas.getContext("2d");
  const { width, height } = canvas;
  const [scale, count] = [width / film.area[0], i * film.every + 1];
  pen.setTransform(1, 0, 0, 1, 0, (height - width) / 2); // its top and bottom are cut
  pen.drawImage(film.pictures[i], 0, 0, width, width);
  pen.lineWidth = Math.max(2, width / 140);
  pen.lineJoin = "round";
  drawTrail(pen, film.measured.slice(0, count), scale, context.ink("measured"));
  drawTrail(pen, film.estimated.slice(0, count), scale, context.ink("estimated"));
  pen.resetTransform();
  if (film.errors.length) drawErrors(pen, film.errors, count, { width, height }, context);
}

/** Draw places in px of the work area, with a gap at each missing one. */
function drawTrail(pen, places, scale, color) {
  pen.strokeStyle = color;
  pen.beginPath();
  let isGap = true;
  for (const place of places) {
    if (place) pen[isGap ? "moveTo" : "lineTo"](place[0] * scale, place[1] * scale);
    isGap = !place;
  }
  pen.stroke();
}

/** Draw how the mean error of the parameters shrinks, in a strip at the lower edge. */
function drawErrors(pen, errors, count, { width, height }, context) {
  const top = 0.62 * height;
  pen.fillStyle = context.ink("veil");
  pen.fillRect(0, top, width, height - top);
  pen.strokeStyle = context.ink("estimated");
  pen.beginPath();
  errors.slice(0, count).forEach((error, k) =>
    pen.lineTo((k / errors.length) * width, height - 4 - error * (height - top - 10)));
  pen.stroke();
}
