// The bench as a page of the local server: questions are requests, and the state stands in the address.
import { mount } from "./bench.js";

const page = crypto.randomUUID();

const ask = async (kind, question, told) => {
  const response = await fetch(kind, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ page, ...question }),
  });
  if (!response.ok) throw new Error(`${response.status} ${response.statusText}`);
  if (!response.headers.get("Content-Type").includes("ndjson")) return response.json();
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "",
    answer = null;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return answer;
    const lines = (rest + value).split("\n");
    rest = lines.pop();
    for (const line of lines.map((text) => JSON.parse(text))) {
      if (line.progress !== undefined) told(line.progress);
      if (line.answer !== undefined) answer = line.answer;
    }
  }
};

const recalled = () => {
  try {
    const state = JSON.parse(decodeURIComponent(location.hash.slice(1)));
    return state !== null && typeof state === "object" && !Array.isArray(state) ? state : {};
  } catch {
    return {};
  }
};

const remember = (state) => {
  const text = Object.keys(state).length ? `#${encodeURIComponent(JSON.stringify(state))}` : "";
  history.replaceState(null, "", location.pathname + text);
};

const bench = mount(document.getElementById("bench"), JSON.parse(document.getElementById("start").textContent), {
  ask,
  remember,
  recalled,
  saves: true,
  report: (name) => `report/${encodeURIComponent(name)}/report.html`,
});
addEventListener("hashchange", () => bench.set(recalled()));
