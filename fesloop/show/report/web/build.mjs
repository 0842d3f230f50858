// Bundles each entry into ../assets: one script without modules, so that a page can hold it in itself.
import { readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const ASSETS = new URL("../assets/", import.meta.url).pathname;
const ENTRIES = ["src/report.js", "src/view.js"];

const made = await build({
  entryPoints: ENTRIES,
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome123", "firefox120", "safari17.5"],
  outdir: ASSETS,
  charset: "utf8",
  legalComments: "none",
  metafile: true,
});

/** Packages of which something came into the bundles, in the order of their names. */
function bundled(outputs) {
  const inputs = outputs.flatMap((output) => Object.entries(output.inputs));
  const names = inputs.filter(([, { bytesInOutput }]) => bytesInOutput > 0).map(([path]) =>
    path.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1]);
  return [...new Set(names.filter(Boolean))].sort();
}

/** A package's licence, with its name and version over it. */
function licence(name) {
  const folder = new URL(`node_modules/${name}/`, import.meta.url);
  const { version, license } = JSON.parse(readFileSync(new URL("package.json", folder), "utf8"));
  const text = readFileSync(new URL("LICENSE", folder), "utf8").trim();
  return `${name} ${version} (${license})\n\n${text}\n`;
}

const names = bundled(Object.values(made.metafile.outputs));
writeFileSync(`${ASSETS}licences.txt`, names.map(licence).join("\n\n"));
for (const [path, { bytes }] of Object.entries(made.metafile.outputs)) {
  console.log(`${path}: ${bytes} bytes, of ${names.join(", ")}`);
}
