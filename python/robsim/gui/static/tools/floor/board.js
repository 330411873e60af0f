// The lens: pictures of a board, where in the picture it was, how well it fits.
import { make, say, text } from "../../base/dom.js";
import { makeField } from "../../base/fields.js";
import { drawDot } from "../../camera/strokes.js";
import { makeAct, makeCell, makeCut, makeFields, makeHint, makeList, makeNumberField, makeRow,
  makeTable, makeVerdict, makeWords } from "../pieces.js";

const BOARD_KINDS = ["chessboard", "charuco"];
const BOARD_INK = "#5ee08a";

/** The newest message about the board is kept as `context.board`. */
export function makeLensBoard(context) {
  const act = (name, message, kind) => makeAct(context, name, kind, () => message);
  const take = act("take_board", { type: "take" }, "robsim-primary");
  const all = act("take_all_boards", { type: "take_all" });
  const use = act("use_lens", { type: "use_lens" });
  const drop = act("drop_boards", { type: "drop", picture: null });
  const watch = makeField({ name: "watch", kind: "switch" }, (on) =>
    context.send({ type: "watch", on }));
  const [verdict, problems] = [makeVerdict(), makeList()];
  const figures = make("span.robsim-number");
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
    verdict.show(board.verdict, board.verdict ? text(`floor_verdict.${board.verdict}`) : "");
    say(figures, wordsOf(board));
    problems.show([...board.problems, ...emptyOf(board)]);
    context.emit("local", "board"); // the picture is painted again
  });
  return makeFields(makeBoardFields(context), makeHint("board_hint"),
    makeRow(take, all, watch.element), makeRow(verdict.element, figures, use, drop),
    problems.element, makePictureTable(context));
}

function wordsOf({ pictures, rms, busy }) {
  const count = pictures.length;
  if (busy) return `${text("board_count", { count })}, ${text("board_busy")}`;
  return rms == null ? text("board_count", { count })
    : text("board_lens", { count, rms: rms.toFixed(2) });
}

const emptyOf = ({ empty }) =>
  (empty.length ? [text("board_empty", { parts: empty.join(", ") })] : []);

/** The fields of the board. */
function makeBoardFields(context) {
  const typed = new Set(); // fields under typing
  const tell = () => {
    typed.clear();
    const [columns, rows, square] = fields.map(({ valueAsNumber }) => valueAsNumber);
    if (![columns, rows].every(Number.isInteger) || !Number.isFinite(square)) return;
    context.send({ type: "board", pattern: kind.value, columns, rows, square });
  };
  const kind = make("select.robsim-select", { name: "board_kind", onchange: tell,
    ariaLabel: text("board_kind") }, ...BOARD_KINDS.map((value) =>
    make("option", { value, textContent: text(`board_kind.${value}`) })));
  const makeOne = (name) => makeNumberField(name, () => {}, {
    className: "robsim-text-field robsim-shorter", min: "1", title: text(name),
    step: name == "board_square" ? "any" : "1",
    onchange: tell, oninput: ({ target }) => typed.add(target) });
  const fields = ["board_columns", "board_rows", "board_square"].map(makeOne);
  const unit = make("span.robsim-quiet");
  context.on("board", (board) => {
    kind.value = board.pattern;
    unit.textContent = text(`board_unit.${board.pattern}`);
    [board.columns, board.rows, board.square].forEach((value, i) => {
      if (!typed.has(fields[i])) fields[i].value = String(value);
    });
  });
  const [columns, rows, square] = fields;
  return makeRow(kind, columns, makeWords("area_times"), rows, unit, makeWords("board_each"),
    square, makeWords("unit_mm"));
}

function makePictureTable(context) {
  const { table, body } = makeTable(["picture", "corners", "px", ""]);
  const rowOf = ({ name, corners, rms, used }, i) => {
    const drop = makeCut(text("board_drop", { name }), () =>
      context.send({ type: "drop", picture: i }));
    const cells = [name, String(corners), rms == null ? "" : rms.toFixed(2), drop];
    return make("tr", { className: used ? "" : "robsim-fit-wrong" },
      ...cells.map((cell) => makeCell(cell)));
  };
  context.on("board", ({ pictures }) => {
    body.replaceChildren(...pictures.map(rowOf));
    table.hidden = !pictures.length;
  });
  return make("div.robsim-points-box", table);
}

/** Draw the positions of boards: areas without dots are not covered yet. */
export function drawBoards(scene) {
  for (const at of scene.context.board?.pixels ?? [])
    drawDot(scene, scene.pixel(at), BOARD_INK, 2.6);
}
