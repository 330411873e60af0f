// Files for Python, in parts.

const PART = 1 << 19; // bytes, the most that Python takes

/**
 * Send a file in parts, each when the previous one was answered.
 * `tell(about)` receives the progress: `name`, `state` ("more", "read", "taken" or "refused"),
 * the received `share`, and `why` the file was refused. It receives null at the end. A file
 * that the browser cannot read is "unreadable".
 */
export function makeSender(context, tell) {
  let now = null; // the file that is sent, its key, its name
  const end = (about) => {
    now = null;
    tell(about);
  };
  const sendPart = async (sent, at) => {
    const { file, key, name } = sent;
    let part;
    try {
      part = await file.slice(at, at + PART).arrayBuffer();
    } catch { // a folder, or one that has gone
      if (sent == now) end({ name, state: "unreadable" });
      return;
    }
    if (sent == now) context.send({ type: "upload", key, name, size: file.size, at }, [part]);
  };
  const giveUp = () => {
    if (now) context.send({ type: "give_up", key: now.key });
    end(null);
  };
  context.on("uploaded", ({ key, state, at, text: why }) => {
    if (key != now?.key) return;
    const about = { name: now.name, state, share: at / now.file.size, why };
    if (state == "taken" || state == "refused") return end(about);
    tell(about);
    if (state == "more") sendPart(now, at);
  });
  return {
    giveUp,
    send(file) {
      giveUp();
      const key = crypto.getRandomValues(new Uint32Array(2)).join("");
      now = { file, key, name: file.name.slice(0, 100) };
      tell({ name: now.name, state: "more", share: 0 });
      sendPart(now, 0);
    },
  };
}
