// The content of a step, as a tree; each level is requested when it is opened.
import { asPicture } from "../base/buffers.js";
import { make, text } from "../base/dom.js";
import { listenToKeys } from "../base/gestures.js";
import { makeCopyButton } from "./source.js";

const ASK_GAP = 300; // ms between two looks while the steps go on
const ROOT = { python: "step", kind: "object" };

const keyOf = (path) => JSON.stringify(path);

export function makeInspector(context) {
  const step = make("span.robsim-card-title");
  const python = make("span.robsim-code.robsim-inspector-path.robsim-clipped");
  const copy = makeCopyButton(() => python.textContent);
  const head = make("div.robsim-inspector-head.robsim-row", step, python, copy);
  const send = (path) => context.send({ type: "inspect", k: context.looking, path });
  const tree = makeTree(send, (item) => (python.textContent = item.python));
  const element = make("div.robsim-inspector.robsim-column", head, tree.element);

  let asked = 0;
  let waiting = 0;
  const ask = () => {
    if (waiting || element.offsetParent === null) return;
    waiting = setTimeout(() => {
      [waiting, asked] = [0, performance.now()];
      tree.opened().forEach(send);
    }, Math.max(0, asked + ASK_GAP - performance.now()));
  };
  context.on("tree", ({ k, path, nodes, picture }, buffers) => {
    step.textContent = k == null || k < 0 ? text("inspector.start") : text("inspector.step", { k });
    tree.fill(path, nodes);
    tree.showArray(path, picture, buffers?.[0]);
  });
  context.on("frame state looking", ask);
  context.on("local", (name) => name == "tab" && requestAnimationFrame(ask)); // when it is shown
  return { element };
}

/**
 * A tree of requested nodes: `ask(path)` when a node is opened, `chosen(item)` when a node gets the
 * focus.
 */
function makeTree(ask, chosen) {
  const about = { role: "tree", ariaLabel: text("inspector") };
  const element = make("ul.robsim-tree.robsim-code.robsim-surface", about);
  const opened = new Map([[keyOf([]), []]]); // key -> path of open nodes
  const lists = new Map([[keyOf([]), element]]); // key -> the list that shows it

  const focus = (item, takes = true) => {
    element.querySelector("[tabindex='0']")?.setAttribute("tabindex", "-1");
    item.tabIndex = 0;
    chosen(item);
    if (takes) item.focus();
  };
  const toggle = (item, opens = item.ariaExpanded == "false") => {
    if (item.ariaExpanded == null) return;
    item.ariaExpanded = String(opens);
    if (!opens) return void opened.delete(keyOf(item.path));
    opened.set(keyOf(item.path), item.path);
    ask(item.path);
  };
  const add = (path, python) => {
    const item = makeTreeItem(path, python);
    lists.set(keyOf(path), item.list);
    item.line.onclick = () => {
      focus(item);
      toggle(item);
    };
    return item;
  };
  const drop = (item) => { // open child nodes are opened again if the item returns
    for (const inner of [item, ...item.querySelectorAll("[role=treeitem]")])
      lists.delete(keyOf(inner.path));
  };
  const fill = (path, nodes) => {
    const list = lists.get(keyOf(path));
    if (!list || !opened.has(keyOf(path))) return;
    const above = list.closest("[role=treeitem]") ?? ROOT;
    const before = new Map([...list.children].map((item) => [item.path.at(-1), item]));
    const items = nodes.map((node) => {
      const inner = [...path, node.name];
      const item = before.get(node.name)
        ?? add(inner, above.python + pythonPart(node.name, above.kind));
      before.delete(node.name);
      showNode(item, node);
      if (item.ariaExpanded == "false" && opened.has(keyOf(inner))) toggle(item);
      return item;
    });
    for (const gone of before.values()) drop(gone);
    const isSame = items.length == list.children.length
      && items.every((item, i) => item == list.children[i]);
    if (!isSame) list.replaceChildren(...items);
    const first = element.firstElementChild;
    if (first && !element.querySelector("[tabindex='0']")) focus(first, false);
  };
  const showArray = (path, ...array) => {
    const item = lists.get(keyOf(path))?.closest("[role=treeitem]");
    if (item) fillArray(item, ...array);
  };
  listenToKeys(element, (event) => {
    const item = event.target.closest?.("[role=treeitem]");
    if (!item || !TREE_KEYS[event.key]) return false;
    const all = [...element.querySelectorAll("[role=treeitem]")];
    const shown = all.filter((one) => one.offsetParent);
    const next = TREE_KEYS[event.key](item, shown, toggle);
    if (next) focus(next);
  });
  return { element, fill, showArray, opened: () => [...opened.values()] };
}

// The keys of a tree: (item, all displayed items, toggle) gives the next item.
const TREE_KEYS = {
  ArrowDown: (item, all) => all[all.indexOf(item) + 1],
  ArrowUp: (item, all) => all[all.indexOf(item) - 1],
  Home: (_, all) => all[0],
  End: (_, all) => all.at(-1),
  ArrowRight: (item, _, toggle) => {
    if (item.ariaExpanded == "false") return toggle(item);
    return item.list.firstElementChild;
  },
  ArrowLeft: (item, _, toggle) => {
    if (item.ariaExpanded == "true") return toggle(item);
    return item.parentElement.closest("[role=treeitem]");
  },
  Enter: (item, _, toggle) => toggle(item),
  " ": (item, _, toggle) => toggle(item),
};

function makeTreeItem(path, python) {
  const cells = [make("span.robsim-node-name"), make("span.robsim-node-value.robsim-clipped"),
    make("span.robsim-quiet")];
  const line = make("div.robsim-node", ...cells);
  const list = make("ul", { role: "group" });
  const array = make("div.robsim-array", { hidden: true });
  const item = make("li", { role: "treeitem", tabIndex: -1, ariaLevel: String(path.length) }, line,
    array, list);
  return Object.assign(item, { path, python, line, array, list });
}

/** Show an array that is large enough as a picture, above its rows. */
async function fillArray({ array, python }, picture, buffer) {
  array.hidden = !picture;
  if (!picture) return;
  const image = await asPicture(buffer, "image/png");
  const old = array.querySelector("canvas");
  const canvas = old ?? make("canvas", { role: "img", ariaLabel: python });
  [canvas.width, canvas.height] = [image.width, image.height];
  canvas.getContext("2d").drawImage(image, 0, 0);
  image.close();
  const [width, height] = picture.size;
  const { low, high } = picture;
  const about = text(low == null ? "inspector.image" : "inspector.grey",
    { width, height, low: Number(low?.toPrecision(6)), high: Number(high?.toPrecision(6)) });
  if (!old) array.replaceChildren(canvas, make("span.robsim-quiet"));
  array.lastChild.textContent = about;
}

function showNode(item, { name, text: value, full = value, kind, more }) {
  const [label, shown, type] = item.line.children;
  item.kind = kind;
  const isOther = label.textContent != "" && shown.textContent != value;
  item.line.classList.toggle("robsim-changed", isOther);
  [label.textContent, shown.textContent, type.textContent] = [name, value, kind];
  shown.title = full;
  if (!more) item.ariaExpanded = null;
  else item.ariaExpanded ??= "false";
}

/** Return how Python reaches a node in one of a kind: as an attribute, by an index or a key. */
function pythonPart(name, kind) {
  if (kind == "dict") return /^\d+$/.test(name) ? `[${name}]` : `[${JSON.stringify(name)}]`;
  return name.startsWith("[") ? name : `.${name}`;
}
