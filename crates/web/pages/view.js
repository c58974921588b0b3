// Shows the viewer, with the demo's face open. For programs `window.rhytid` has `state`: "running", then "open", "unsupported" where there
// is neither WebGPU nor WebGL 2, or "broken" with a `message`; `viewer`, whose functions are those of crates/web/src/viewer.rs; and
// WebGPU's `device`. `?empty` opens nothing. `?webgl` takes WebGL 2 even if there is WebGPU. Where there is no viewer, a film plays.
import { nameOf, unpacked, whenLost, whyNot } from "./webgpu.js";

const result = (window.rhytid = { state: "running" });
const element = (id) => document.getElementById(id);

function end(state, message) {
    Object.assign(result, { state, message });
    element("status").textContent = message ?? "";
    element("status").hidden = !message;
    if ((state === "unsupported" || state === "broken") && !result.viewer) playFilm();
}

// Shows a film of the demo's face in place of the viewer. A browser that cannot play it shows its first picture.
function playFilm() {
    const film = element("film");
    if (!film.hidden) return;
    Object.assign(film, { hidden: false, poster: "film.png", src: "film.mp4" });
    element("canvas").hidden = element("open").hidden = true;
    film.play().catch(() => {});
}

addEventListener("error", (event) => end("broken", `The viewer stopped: ${event.message}`));
addEventListener("unhandledrejection", (event) => end("broken", `The viewer stopped: ${event.reason?.message ?? event.reason}`));

async function run() {
    const asked = new URLSearchParams(location.search);
    const isEmpty = asked.has("empty");
    const reason = asked.has("webgl") ? "WebGL 2 was asked for." : await whyNot();
    if (reason && !document.createElement("canvas").getContext("webgl2")) {
        return end("unsupported", `${reason} It has no WebGL 2 either, with which the face could be drawn. This is a film of the face.`);
    }
    end("running", "Loading …");
    const lost = (message) => end("broken", `The GPU was lost${message ? ` (${message})` : ""}. Reload the page to go on.`);
    let adapter;
    if (reason) {
        element("canvas").addEventListener("webglcontextlost", () => lost());
    } else {
        whenLost(
            ({ message }) => lost(message),
            (device, of) => ([result.device, adapter] = [device, of]),
        );
    }
    // Without WebGPU another program draws by WebGL 2, and the processor evaluates.
    const { default: init, view } = await import(reason ? "./rhytid_webgl.js" : "./rhytid_web.js");
    const demo = isEmpty ? [] : ["demo.safetensors", "demo.csv"];
    const [files] = await Promise.all([Promise.all(demo.map((name) => unpacked(`${name}.gz`))), init()]);
    const viewer = (result.viewer = await view(element("canvas")));
    if (adapter) viewer.nameDevice(nameOf(adapter.info));
    viewer.open(demo, files);
    element("files").addEventListener("change", async ({ target }) => {
        const chosen = [...target.files];
        // The same file may be chosen again.
        target.value = "";
        const bytes = async (file) => {
            const reason = (error) => new Error(`${file.name}: the browser cannot read it (${error.message})`);
            return new Uint8Array(await file.arrayBuffer().catch((error) => Promise.reject(reason(error))));
        };
        try {
            const read = await Promise.all(chosen.map(bytes));
            end("open");
            viewer.open(chosen.map(({ name }) => name), read);
        } catch (error) {
            end("open", error.message);
        }
        element("canvas").focus();
    });
    // As soon as there is a picture.
    while (!isEmpty && !(JSON.parse(viewer.status || "{}").pictures > 0)) await new Promise((resolve) => setTimeout(resolve, 20));
    end("open");
    element("canvas").focus();
}

run().catch((error) => end("broken", `The viewer stopped: ${error.message ?? error}`));
