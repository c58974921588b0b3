// Runs Khronos' glTF validator over files: `node validate.mjs NODE_FOLDER FILE…`.
// Prints one line per file: {"file", "errors", "warnings", "infos"}, the last three as lists of issue codes.
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";

const [folder, ...files] = process.argv.slice(2);
const validator = createRequire(join(folder, "package.json"))("gltf-validator");
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri)))),
  });
  if (report.issues.truncated) throw new Error(`${file}: issues were left out`);
  const codes = (...severities) =>
    report.issues.messages
      .filter((issue) => severities.includes(issue.severity))
      .map((issue) => `${issue.code} ${issue.pointer ?? ""}: ${issue.message}`);
  console.log(JSON.stringify({ file, errors: codes(0), warnings: codes(1), infos: codes(2, 3) }));
}
