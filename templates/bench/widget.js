// The bench in a cell of a notebook: questions are messages to the kernel. It stands behind bench.js in one module.
export default {
  render({ model, el }) {
    const waiting = new Map();
    let count = 0;
    const heard = (message) => {
      const asked = waiting.get(message.number);
      if (asked === undefined) return;
      if (message.progress !== undefined) {
        asked.told(message.progress);
        return;
      }
      waiting.delete(message.number);
      asked.answered(message.answer ?? null);
    };
    model.on("msg:custom", heard);
    const ask = (kind, question, told) =>
      new Promise((answered) => {
        count += 1;
        waiting.set(count, { told, answered });
        model.send({ number: count, kind, question });
      });
    const remember = (state) => {
      model.set("state", state);
      model.save_changes();
    };
    const bench = mount(el, model.get("start"), { ask, remember, recalled: () => model.get("state"), saves: false });
    const changed = () => bench.set(model.get("state"));
    model.on("change:state", changed);
    return () => {
      model.off("msg:custom", heard);
      model.off("change:state", changed);
      bench.end();
    };
  },
};
