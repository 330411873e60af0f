// @ts-check
// The lens: pictures of a board, where in the picture it was, how well it fits.
import { makeTextButton } from "../../base/buttons.js";
import { make } from "../../base/dom.js";
import { makeField } from "../../base/fields.js";
import { text } from "../../base/texts.js";
import { VERDICT_LOOKS, setItems, setWords } from "./result.js";

const BOARD_KINDS = ["chessboard", "charuco"];
const BOARD_INK = "#5ee08a";

/** The newest message about the board is kept as `context.board`. */
export function makeLensBoard(context) {
  const act = (name, type) => makeTextButton(name, "", () => context.send({ type }));
  const [take, all] = [act("take_board", "take"), act("take_all_boards", "take_all")];
  take.classList.add("robsim-primary");
  const use = act("use_lens", "use_lens");
  const drop = makeTextButton("drop_boards", "", () =>
    context.send({ type: "drop", picture: null }));
  const watch = makeField({ name: "watch", kind: "switch" },
    (on) => context.send({ type: "watch", on }), () => {});
  context.onEnd(watch.end);
  const chip = make("span", { className: "robsim-chip", role: "status" });
  const figures = make("span", { className: "robsim-number" });
  const problems = make("ul", { className: "robsim-problems", role: "status" });
  const pictures = makePictureTable(context);
  const hint = make("p", { className: "robsim-quiet robsim-tool-hint",
    textContent: text("board_hint") });
  context.on("setup", ({ is_live: isLive, count }) => {
    watch.element.hidden = !isLive;
    all.hidden = !(count > 1);
  });
  context.on("board", (board) => {
    context.board = board;
    watch.show(board.watches);
    take.disabled = all.disabled = board.busy;
    use.disabled = board.rms == null || board.busy;
    use.title = board.busy ? text("board_busy")
      : (use.disabled && board.problems[0]) || text("use_lens.title");
    drop.hidden = !board.pictures.length;
    chip.hidden = !board.verdict;
    chip.className = `robsim-chip ${VERDICT_LOOKS[board.verdict] ?? ""}`;
    setWords(chip, board.verdict ? text(`floor_verdict.${board.verdict}`) : "");
    setWords(figures, wordsOf(board));
    setItems(problems, [...board.problems, ...emptyOf(board)]);
    context.emit("local", "board"); // the picture is painted anew
  });
  const row = (...parts) => make("div", { className: "robsim-tool-row" }, ...parts);
  return make("div", { className: "robsim-tool-fields" }, makeBoardFields(context), hint,
    row(take, all, watch.element), row(chip, figures, use, drop), problems, pictures);
}

function wordsOf({ pictures, rms, busy }) {
  const count = pictures.length;
  if (busy) return `${text("board_count", { count })}, ${text("board_busy")}`;
  return rms == null ? text("board_count", { count })
    : text("board_lens", { count, rms: rms.toFixed(2) });
}

const emptyOf = ({ empty }) =>
  (empty.length ? [text("board_empty", { parts: empty.join(", ") })] : []);

/** What the board is. */
function makeBoardFields(context) {
  const kind = make("select", { className: "robsim-select", name: "board_kind",
    ariaLabel: text("board_kind") }, ...BOARD_KINDS.map((value) =>
    make("option", { value, textContent: text(`board_kind.${value}`) })));
  const typed = new Set(); // those that are being typed in
  const fields = ["columns", "rows", "square"].map((name) => {
    const label = text(`board_${name}`);
    const input = make("input", { type: "number", className: "robsim-text-field robsim-shorter",
      name: `board_${name}`, min: "1", step: name == "square" ? "any" : "1", ariaLabel: label,
      title: label });
    input.onkeydown = (event) => event.stopPropagation();
    input.oninput = () => typed.add(input);
    return input;
  });
  const tell = () => {
    typed.clear();
    const [columns, rows, square] = fields.map(({ valueAsNumber }) => valueAsNumber);
    if (![columns, rows].every(Number.isInteger) || !Number.isFinite(square)) return;
    context.send({ type: "board", pattern: kind.value, columns, rows, square });
  };
  for (const one of [kind, ...fields]) one.onchange = tell;
  const unit = make("span", { className: "robsim-quiet" });
  const words = (textContent) => make("span", { className: "robsim-quiet", textContent });
  context.on("board", (board) => {
    kind.value = board.pattern;
    unit.textContent = text(`board_unit.${board.pattern}`);
    [board.columns, board.rows, board.square].forEach((value, i) => {
      if (!typed.has(fields[i])) fields[i].value = String(value);
    });
  });
  const [columns, rows, square] = fields;
  return make("div", { className: "robsim-tool-row" }, kind, columns, words("\u00d7"), rows, unit,
    words(text("board_each")), square, words(text("unit_mm")));
}

function makePictureTable(context) {
  const body = make("tbody");
  const head = ["picture", "corners", "px", ""].map((name) =>
    make("th", { scope: "col", textContent: name && text(`floor_column.${name}`) }));
  const table = make("table", { className: "robsim-points" },
    make("thead", {}, make("tr", {}, ...head)), body);
  const cell = (...children) => make("td", {}, ...children);
  const rowOf = ({ name, corners, rms, used }, i) => {
    const label = text("board_drop", { name });
    const drop = make("button", { type: "button", className: "robsim-point-cut",
      textContent: "\u00d7", ariaLabel: label, title: label,
      onclick: () => context.send({ type: "drop", picture: i }) });
    const className = used ? "" : "robsim-fit-wrong";
    return make("tr", { className }, cell(name), cell(String(corners)),
      cell(rms == null ? "" : rms.toFixed(2)), cell(drop));
  };
  context.on("board", ({ pictures }) => {
    body.replaceChildren(...pictures.map(rowOf));
    table.hidden = !pictures.length;
  });
  return make("div", { className: "robsim-points-box" }, table);
}

/** Draw where the boards were: what has no dots is not covered yet. */
export function drawBoards({ pen, pixel, unit, context }) {
  pen.fillStyle = BOARD_INK;
  pen.strokeStyle = "#000a";
  pen.lineWidth = unit;
  for (const at of context.board?.pixels ?? []) {
    const [x, y] = pixel(at);
    pen.beginPath();
    pen.arc(x, y, 2.6 * unit, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
  }
}
