// Visits pages in a headless Chromium with WebGPU on the processor (SwiftShader), and says what it finds there.
//
//     node chromium.mjs JOB
//
// JOB is a JSON file: `downloads`, a folder for what pages hand over, and `visits`, each with a `url`; a script to run `before` any of the page's, which may be empty; the expression `until`
// which to wait; `steps`, each an input event or another command of the protocol's (`method`, `params`), an expression to wait for (`until`), or expressions to `evaluate` then and
// there; and expressions to `evaluate` then, by name: what they give, or what a promise of theirs does, is JSON. `picture` is a
// file for one of the page, as wide as `width` says, and as high as `height` says, or 800. Printed is for each visit what the expressions gave (`found`), how many `seconds`
// passed before, and what until then was asked for (`requests`) and went wrong in the page (`errors`).
//
// The page is spoken to by Chromium's own protocol, through a pipe: nothing is installed for it, and the page knows of no test.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

const VISIT_LIMIT_S = 120;

const job = JSON.parse(readFileSync(process.argv[2], "utf8"));
const profile = mkdtempSync(path.join(tmpdir(), "rhytid-chromium-"));
const flags = [
    "--headless=new",
    // A driver on the processor is no adapter unless it is asked for by name, and what it may do is called unsafe.
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    // What a canvas shows is put on the page by Vulkan as well: by another API, the first picture takes the whole driver away.
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
    "--remote-debugging-pipe",
    // Its sandbox refuses to run as root, and what is loaded is our own.
    "--no-sandbox",
    "--disable-dev-shm-usage",
    // Nothing but the page.
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-quic",
    "--disable-sync",
    "--no-proxy-server",
    `--user-data-dir=${profile}`,
];

// A process group of its own, so that all its processes can be ended.
const stdio = ["ignore", "ignore", "pipe", "pipe", "pipe"];
const browser = spawn("chromium", [...flags, "about:blank"], { detached: true, stdio });
const [, , stderr, toBrowser, fromBrowser] = browser.stdio;

let ending = false;
// Prints and ends, once; the profile can only go when the browser has gone.
function end(code, message) {
    if (ending) return;
    ending = true;
    const leave = () => {
        rmSync(profile, { recursive: true, force: true, maxRetries: 10 });
        (code === 0 ? process.stdout : process.stderr).write(message + "\n", () => process.exit(code));
    };
    if (browser.pid === undefined || browser.exitCode !== null) return leave();
    browser.once("close", leave);
    process.kill(-browser.pid, "SIGKILL");
}

let said = "";
stderr.on("data", (text) => (said = (said + text).slice(-4000)));
browser.on("error", (error) => end(1, `chromium does not start (${error.message}); run \`cargo xtask setup\``));
browser.on("close", () => end(1, `chromium ended before it was told to:\n${said}`));
toBrowser.on("error", () => {});

// Commands are answered by their number; all else is an event of a session.
const waiting = new Map();
const listeners = new Map();
let numbers = 0;
let text = "";
fromBrowser.setEncoding("utf8");
fromBrowser.on("data", (part) => {
    const messages = (text + part).split("\0");
    text = messages.pop();
    for (const message of messages.map((message) => JSON.parse(message))) {
        if (message.id === undefined) listeners.get(message.sessionId)?.(message);
        else {
            const { resolve, reject } = waiting.get(message.id);
            waiting.delete(message.id);
            message.error ? reject(new Error(message.error.message)) : resolve(message.result);
        }
    }
});

function command(method, params = {}, sessionId = undefined) {
    const id = ++numbers;
    toBrowser.write(JSON.stringify({ id, method, params, sessionId }) + "\0");
    return new Promise((resolve, reject) => waiting.set(id, { resolve, reject }));
}

async function visit({ url, before, until, steps, evaluate, picture, width, height, touch }) {
    const { targetId } = await command("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await command("Target.attachToTarget", { targetId, flatten: true });
    const ask = (method, params) => command(method, params, sessionId);
    const requests = [];
    const errors = [];
    listeners.set(sessionId, ({ method, params }) => {
        if (method === "Network.responseReceived" && params.response.status >= 400) {
            end(1, `${params.response.url}: ${params.response.status} ${params.response.statusText}`);
        }
        if (method === "Network.requestWillBeSent") requests.push(params.request.url);
        if (method === "Runtime.exceptionThrown") errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        if (method === "Runtime.consoleAPICalled" && ["error", "warning"].includes(params.type)) {
            errors.push(params.args.map((word) => word.value ?? word.description).join(" "));
        }
        if (method === "Log.entryAdded" && params.entry.level === "error") errors.push(params.entry.text);
    });
    for (const domain of ["Network", "Runtime", "Log", "Page"]) await ask(`${domain}.enable`);
    if (width) await ask("Emulation.setDeviceMetricsOverride", { width, height: height ?? 800, deviceScaleFactor: 1, mobile: Boolean(touch) });
    if (touch) await ask("Emulation.setTouchEmulationEnabled", { enabled: true });
    const value = async (expression) => {
        const parameters = { expression, awaitPromise: true, returnByValue: true };
        const { result, exceptionDetails } = await ask("Runtime.evaluate", parameters);
        if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
        return result.value;
    };
    await ask("Page.addScriptToEvaluateOnNewDocument", { source: before });
    const start = Date.now();
    const { errorText } = await ask("Page.navigate", { url });
    if (errorText) throw new Error(`${url}: ${errorText}`);
    const wait = async (until) => {
        const begin = Date.now();
        // While the page is being replaced there is nothing to ask.
        while (!(await value(until).catch(() => false))) {
            if (Date.now() - begin > VISIT_LIMIT_S * 1000) {
                const page = await value("document.body?.innerText").catch((error) => error.message);
                throw new Error(`${url}: not ${until} after ${VISIT_LIMIT_S} s; the page says: ${page}; errors: ${errors.join("; ")}`);
            }
            await new Promise((resolve) => setTimeout(resolve, 50));
        }
    };
    await wait(until);
    const seconds = (Date.now() - start) / 1000;
    // What is evaluated may well be refused by the page; that is for who asks.
    const sofar = { requests: [...requests], errors: [...errors] };
    const found = {};
    const evaluated = async (expressions) => {
        for (const [name, expression] of Object.entries(expressions)) found[name] = await value(expression);
    };
    for (const step of steps ?? []) {
        if (step.until) await wait(step.until);
        if (step.evaluate) await evaluated(step.evaluate);
        if (!step.method) continue;
        // What is not known before is an expression: a place, or a node of the page's.
        const params = { ...step.params };
        for (const [name, expression] of Object.entries(step.computed ?? {})) params[name] = await value(expression);
        if (step.node) {
            const { root } = await ask("DOM.getDocument");
            params.nodeId = (await ask("DOM.querySelector", { nodeId: root.nodeId, selector: step.node })).nodeId;
        }
        await ask(step.method, params);
    }
    await evaluated(evaluate);
    if (picture) {
        const { data } = await ask("Page.captureScreenshot", { captureBeyondViewport: true });
        writeFileSync(picture, Buffer.from(data, "base64"));
    }
    await command("Target.closeTarget", { targetId });
    return { found, seconds, ...sofar };
}

try {
    await command("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: job.downloads });
    const visits = [];
    for (const one of job.visits) visits.push(await visit(one));
    end(0, JSON.stringify(visits));
} catch (error) {
    end(1, error.message);
}
