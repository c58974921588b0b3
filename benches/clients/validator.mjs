// Khronos' validator of glTF: what it complains about.
import { readFileSync } from "node:fs";
import path from "node:path";
import { required, run, version } from "./client.mjs";

const validator = required("gltf-validator");

async function read(file) {
    const resource = async (uri) => new Uint8Array(readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))));
    const options = { uri: path.basename(file), externalResourceFunction: resource, maxIssues: 100 };
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), options);
    if (issues.numErrors + issues.numWarnings) {
        const worst = issues.messages.find((message) => message.severity < 2);
        throw new Error(`${issues.numErrors} errors and ${issues.numWarnings} warnings: ${worst.code} at ${worst.pointer}`);
    }
    return {};
}

await run(version("gltf-validator"), read);
