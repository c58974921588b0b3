// Runs the suite and shows what it found. For programs the same is in `window.rhytid`: `state` is "running", then "passed", "failed",
// "unsupported" where there is no WebGPU, or "broken" with a `message`; behind the first two `report`, as in report.json, and of a face
// `off`, `handlePositions` and `positions`. `?binding=BYTES` splits arrays as for a device that takes no more in one binding.
import init, { conform } from "./rhytid_web.js";
import { nameOf, unpacked, whenLost, whyNot } from "./webgpu.js";

const result = (window.rhytid = { state: "running" });
const element = (id) => document.getElementById(id);

function end(state, message) {
    // What broke first is what is told.
    if (result.state !== "running") return;
    Object.assign(result, { state, message });
    element("progress").hidden = true;
    element("status").textContent = message;
    element("status").className = state === "passed" || state === "failed" ? "" : "failed";
}

// Where a program in WebAssembly panics, nobody who waits for it hears of it.
addEventListener("error", (event) => end("broken", `The suite stopped: ${event.message}`));
addEventListener("unhandledrejection", (event) => end("broken", `The suite stopped: ${event.reason?.message ?? event.reason}`));

function offer(name, type, text) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = link.textContent = name;
    element("downloads").append(link, " ");
}

async function run() {
    const reason = await whyNot();
    if (reason) return end("unsupported", reason);
    const asked = new URLSearchParams(location.search).get("binding");
    const binding = asked === null ? undefined : Number(asked);
    if (binding !== undefined && !(Number.isInteger(binding) && binding > 0)) {
        return end("broken", `The address has binding=${asked}, expected a number of bytes, such as 65536.`);
    }
    element("status").textContent = "Loading …";
    // The suite itself destroys the devices of cases that are over.
    whenLost(({ reason, message }) => reason === "destroyed" || end("broken", `The GPU was lost: ${message}`));
    const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
    const [rig] = await Promise.all([unpacked("demo.safetensors.gz"), init()]);
    const progress = element("progress");
    progress.hidden = false;
    const found = await conform(nameOf(adapter.info) || "a GPU without a name", navigator.userAgent, binding, rig, (done, total) => {
        Object.assign(progress, { value: done, max: total });
        element("status").textContent = `Case ${done + 1} of ${total}`;
    });
    const { json, markdown, junit, positions, handlePositions, faceOff } = found;
    Object.assign(result, { report: JSON.parse(json), positions, handlePositions, off: faceOff });
    element("findings").innerHTML = found.html;
    offer("report.md", "text/markdown", markdown);
    offer("report.json", "application/json", json);
    offer("junit.xml", "application/xml", junit);
    element("downloads").hidden = false;
    end(found.passed ? "passed" : "failed", "");
}

run().catch((error) => end("broken", `The suite stopped: ${error.message ?? error}`));
