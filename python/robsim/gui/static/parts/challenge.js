// A task as a challenge: the clock, the score by stars and numbers, the best of this machine; the
// tab of its scores.
import { makeTextButton } from "../base/buttons.js";
import { make, say, sayOrHide, text } from "../base/dom.js";

const COLUMNS = ["score", "own", "reference", "ratio", "full", "zero"];

export function makeChallenge(context) {
  const name = make("b.robsim-clipped");
  const stars = make("span.robsim-challenge-stars", { role: "img" });
  const points = make("output.robsim-number");
  const clock = make("span.robsim-number.robsim-quiet");
  const bar = make("progress", { ariaLabel: text("challenge"), value: 0 });
  const best = make("span.robsim-quiet");
  const warning = make("p.robsim-chip.robsim-warning", { hidden: true });
  const conditions = make("p.robsim-quiet");
  const table = make("div.robsim-card.robsim-surface.robsim-cut");
  const more = makeTextButton("challenge.details", "robsim-plain", () =>
    context.choose("tab", "scores"));
  const sheet = make("div.robsim-scores", table, conditions,
    make("p.robsim-quiet", text("challenge.three")));
  const element = make("section.robsim-card.robsim-surface.robsim-challenge",
    { ariaLabel: text("challenge"), hidden: true },
    make("div.robsim-row", name, stars, points), make("div.robsim-row", bar, clock, best), warning,
    more);

  const tick = () => {
    const { challenge, dt } = context.setup ?? {};
    if (!challenge) return;
    const done = Math.min(context.frame?.k ?? 0, challenge.steps);
    bar.max = challenge.steps;
    bar.value = done;
    const [t, end] = [done, challenge.steps].map((k) => (k * dt).toFixed(1));
    say(clock, text("challenge.clock", { t, end }));
  };
  context.on("setup", ({ challenge }) => {
    element.hidden = !challenge;
    if (!challenge) return;
    const { title, steps, slots } = challenge;
    name.textContent = name.title = title;
    conditions.textContent = text("challenge.conditions", { steps, slots: slots.join(", ") });
    tick();
  });
  context.on("frame", tick);
  const show = (score) => {
    stars.ariaLabel = text("challenge.stars", score);
    stars.textContent = "★".repeat(score.stars) + "☆".repeat(3 - score.stars);
    points.textContent = score.points == null ? text("challenge.none")
      : text("challenge.points", { points: percent(score.points) });
    const kind = score.by_hand.length ? "challenge.best.hand" : "challenge.best";
    best.textContent = score.best == null ? text("challenge.no_best")
      : text(kind, { points: percent(score.best) });
    const changed = score.changed.length
      ? text("challenge.changed", { names: score.changed.join(", ") }) : "";
    sayOrHide(warning, score.rule ?? changed);
    table.replaceChildren(makeScores(score.rows));
  };
  show({ stars: 0, points: null, best: null, by_hand: [], changed: [], rule: null, rows: [] });
  context.on("score", show);
  return { element, sheet: { element: sheet } };
}

const percent = (share) => (100 * share).toFixed(0);

function makeScores(rows) {
  const heads = COLUMNS.map((name) => make("th", { scope: "col" }, text(`challenge.${name}`)));
  const cells = rows.map(([title, unit, ...values]) => make("tr",
    make("th", { scope: "row", textContent: unit ? `${title} (${unit})` : title }),
    ...values.map((value) => make("td.robsim-number", shown(value)))));
  return make("table.robsim-table", make("thead", make("tr", ...heads)), make("tbody", ...cells));
}

const shown = (value) =>
  (typeof value == "number" ? String(Number(value.toPrecision(3))) : (value ?? text("challenge.none")));
