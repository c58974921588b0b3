// What each client in Node.js shares, as client.py for those in Python: `node NAME.mjs JOB`, where the job also has `modules`,
// the folder of the packages.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { pathToFileURL } from "node:url";

export const job = JSON.parse(readFileSync(process.argv[2], "utf8"));
const packages = createRequire(path.join(job.modules, "package.json"));

// A module of a package, from the folder of the packages.
export const load = (name) => import(pathToFileURL(path.join(job.modules, "node_modules", name)));
export const required = (name) => packages(name);
export const version = (name) =>
    JSON.parse(readFileSync(path.join(job.modules, "node_modules", name, "package.json"), "utf8")).version;

// The width and height of a PNG, and null for anything else.
export function sizeOfPng(bytes) {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    return bytes.byteLength > 24 && view.getUint32(0) === 0x89504e47 ? [view.getUint32(16), view.getUint32(20)] : null;
}

// Reads every file with `read(path)`, which returns `positions` and `normals` (an array of numbers for each frame) and `materials`.
export async function run(version, read) {
    for (const [number, file] of job.files.entries()) {
        let line;
        try {
            const { positions, normals, ...found } = await read(file);
            line = { up: "Y", ...found };
            if (positions !== undefined) {
                if (!positions.length || !positions[0].length) throw new Error("no vertices");
                const write = (name, frames) => {
                    writeFileSync(path.join(job.out, name), Buffer.from(Float64Array.from(frames.flat()).buffer));
                };
                write(`${number}.f64`, positions);
                if (normals) write(`${number}.normals.f64`, normals);
                line = { ...line, frames: positions.length, vertices: positions[0].length / 3, normals: Boolean(normals) };
            }
        } catch (error) {
            line = { error: String(error?.message ?? error).trim().split("\n")[0].slice(0, 200) };
        }
        console.log(JSON.stringify({ file: number, version, ...line }));
    }
    process.exit(0);
}
