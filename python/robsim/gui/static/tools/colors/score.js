// How a colour would do in other light and noise, and what would do better.
import { make, text } from "../../base/dom.js";
import { makeAct, makePart, makeRow } from "../pieces.js";

const PARTS = 100; // %

export function makeScore(context) {
  const ask = makeAct(context, "score");
  ask.addEventListener("click", () => (said.textContent = text("score_wait")));
  const said = make("span.robsim-quiet", { role: "status" });
  const take = makeAct(context, "take_proposed", "", () =>
    ({ type: "ranges", ranges: proposed, goes_on: false }));
  take.hidden = true;
  const table = make("table.robsim-table.robsim-score", { hidden: true });
  let proposed = null;
  let [of, asked] = ["", ""]; // the class that it is of, and its ranges

  context.on("score", (score) => {
    of = score.name;
    asked = rangesOf(context.state, of);
    proposed = score.margin ? score.ranges : null;
    take.hidden = !proposed;
    said.textContent = text(proposed ? "score_proposed" : "score_best", {
      rate: percent(score.rate), better: percent(score.widened_rate), margin: score.margin,
    });
    if (score.remarks?.length) said.textContent = score.remarks.join(" ");
    table.hidden = false;
    table.replaceChildren(...score.levels.map(levelRow));
  });
  context.on("note", ({ level }) => level == "error" && (said.textContent = ""));
  context.on("state", (state) => {
    ask.disabled = !state.region || !state.classes.some(({ name }) => name == state.chosen);
    // The score belongs to other ranges, or to another class.
    if (state.chosen == of && rangesOf(state, of) == asked) return;
    [take.hidden, table.hidden, of] = [true, true, ""];
    if (asked) said.textContent = "";
    asked = "";
  });
  return makePart(makeRow(ask, said, take), table);
}

const percent = (rate) => Math.round(PARTS * rate);

const rangesOf = ({ classes }, wanted) =>
  JSON.stringify(classes.find(({ name }) => name == wanted)?.ranges ?? "");

function levelRow({ name, levels, rates }) {
  const cells = levels.map((level, i) =>
    make("td", { title: text("score_level", { level, rate: percent(rates[i]) }) },
      make("span.robsim-quiet", `${level} `),
      `${percent(rates[i])}\u202f%`));
  return make("tr", make("th", { scope: "row", textContent: name }), ...cells);
}
