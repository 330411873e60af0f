// @ts-check
// The host without a notebook: a model over a WebSocket, which is opened anew when it breaks.
import view from "./view.js";

const PAUSES = [0.3, 1, 2, 4, 8]; // s before each try

const decoder = new TextDecoder();

function unpack(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(decoder.decode(new Uint8Array(data, 4, length)));
  let at = 4 + length;
  const buffers = head.buffers.map((size) => {
    const buffer = new Uint8Array(data, at, size);
    at += size + ((4 - (size % 4)) % 4);
    return buffer;
  });
  return [head, buffers];
}

/** What the view needs of its host; what it says is kept until the line is open. */
function modelOf(socket) {
  const listeners = new Set();
  const waiting = [];
  const say = (text) => socket.readyState == WebSocket.OPEN && socket.send(text);
  socket.addEventListener("open", () => waiting.forEach(say));
  socket.onmessage = ({ data }) => {
    const [head, buffers] = unpack(data);
    for (const listener of listeners) listener(head, buffers);
  };
  return {
    get: (name) => ({ kind: document.body.dataset.kind })[name],
    send(message) {
      const text = JSON.stringify(message);
      if (socket.readyState == WebSocket.CONNECTING) waiting.push(text);
      else say(text);
    },
    on: (_, listener) => listeners.add(listener),
    off: (_, listener) => listeners.delete(listener),
  };
}

function open() {
  const socket = new WebSocket(new URL("socket", location.href.replace("http", "ws")));
  socket.binaryType = "arraybuffer";
  return socket;
}

/** Show a view: the first one, or one in place of that whose line was lost. */
function show(socket) {
  const el = document.createElement("main");
  document.body.replaceChildren(el);
  const end = view.render({ model: modelOf(socket), el });
  socket.onclose = () => {
    end(); // what it shows remains
    if (el.dataset.state != "closed") retry(el, PAUSES);
  };
}

function retry(el, [pause, ...later]) {
  const isOver = pause == null;
  el.dataset.state = isOver ? "gone" : "lost";
  el.inert = !isOver;
  if (isOver) return;
  setTimeout(() => {
    const socket = open();
    socket.onopen = () => show(socket);
    socket.onclose = () => retry(el, later);
  }, 1000 * pause);
}

show(open());
// A page out of the browser's cache has a line that is closed.
addEventListener("pageshow", ({ persisted }) => persisted && location.reload());
