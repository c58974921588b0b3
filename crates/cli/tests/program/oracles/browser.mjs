// Opens a page in a headless Chromium, with files that it is to show, and writes what it finds.
//
//     node browser.mjs JOB
//
// JOB is a JSON file: `page`, a file beside this one; `files` to show; `out`, a folder; where the page needs it `modules`, the
// folder of three.js's package; and what else the page reads, which says it at its beginning. What the page posts under a name
// becomes a file in `out`; what it posts as `done` is printed.
//
// This program is the web server and starts the browser; the work is done by the page. A page that reports to its
// server needs no driver for the browser, which would be made for one version of it and another of Node.js.
import { spawn } from "node:child_process";
import { createReadStream, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import path from "node:path";

const TIME_LIMIT_S = 300;

const job = JSON.parse(readFileSync(process.argv[2], "utf8"));
const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const types = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript" };

// What the page asks for: itself and what lies beside it, three.js, the job, a file by its number and what lies beside that.
function source(url) {
    const [, kind, ...rest] = decodeURIComponent(url).split("/");
    if (kind === "") return path.join(here, job.page);
    if (kind === "beside") return path.join(here, path.dirname(job.page), ...rest);
    if (kind === "three") return path.join(job.modules, ...rest);
    if (kind === "file") return path.join(path.dirname(job.files[rest[0]]), rest[1]);
    return null;
}

const server = createServer((request, response) => {
    if (request.method === "POST") {
        const parts = [];
        request.on("data", (part) => parts.push(part));
        request.on("end", () => {
            response.end();
            receive(request.url.slice(1), Buffer.concat(parts));
        });
    } else if (request.url === "/job") {
        response.end(JSON.stringify({ ...job, files: job.files.map((file) => path.basename(file)) }));
    } else {
        const file = source(request.url);
        const missing = () => response.writeHead(404).end();
        if (file === null) return missing();
        response.setHeader("Content-Type", types[path.extname(file)] ?? "application/octet-stream");
        createReadStream(file).on("error", missing).pipe(response);
    }
});

function receive(name, body) {
    if (name === "failed") return end(1, body.toString());
    if (name === "done") return end(0, body.toString());
    writeFileSync(path.join(job.out, path.basename(name)), body);
}

let browser;
let ending = false;
const profile = mkdtempSync(path.join(tmpdir(), "rhytid-chromium-"));

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

server.listen(0, "127.0.0.1", () => {
    const flags = [
        "--headless=new",
        // WebGL on the CPU.
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
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
        `--user-data-dir=${profile}`,
        `http://127.0.0.1:${server.address().port}/`,
    ];
    // A process group of its own, so that all its processes can be ended; and no proxy between it and this server.
    const stdio = ["ignore", "ignore", "pipe"];
    browser = spawn("chromium", [...flags, "--no-proxy-server"], { detached: true, stdio });
    let said = "";
    browser.on("error", (error) => end(1, `chromium does not start (${error.message}); run \`cargo xtask setup\``));
    browser.stderr.on("data", (text) => (said = (said + text).slice(-4000)));
    browser.on("close", () => end(1, `chromium ended before the page was done:\n${said}`));
    setTimeout(() => end(1, `the page was not done after ${TIME_LIMIT_S} s:\n${said}`), TIME_LIMIT_S * 1000);
});
