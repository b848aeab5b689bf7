// Makes one HTML file of the viewer's page, without volumes: cvol export --html adds them. With --site it makes the page
// that opens files, OUT.html, and convert.js next to it.
//
// usage: node bundle.mjs PAGE_FOLDER WEB_FOLDER BUILD_FOLDER VERSION OUT.html [--site]
//
// The page's modules become one script: each is a function that gets the modules it imports. Of their syntax this
// script knows what the modules use: import {...} from, import * as, import "...", import(`./${...}.js`), and
// export before const, let, class and function.

import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { gzipSync } from "node:zlib";

const [pageFolder, webFolder, buildFolder, version, out, form] = process.argv.slice(2);
const site = form === "--site";
const read = (folder, name) => readFileSync(path.join(folder, name), "utf8");
// The name of a module is its path from viewer/page.
const nameOf = (file) => path.relative(pageFolder, file).replaceAll(path.sep, "/");
const webNameOf = (name) => nameOf(path.join(webFolder, "page", name));
// Modules in the place of those that are imported.
const INSTEAD = new Map([
  ["state/transport.js", webNameOf("transport.js")],
  [webNameOf("source.js"), webNameOf(site ? "site.js" : "embedded.js")],
]);

// ---- modules ------------------------------------------------------------------------------------

const modules = new Map(); // name: code of its function
const order = []; // imported before importing

function add(name) {
  if (modules.has(name)) return;
  modules.set(name, "");
  const exported = [];
  const imported = [];
  const take = (from) => {
    const wanted = nameOf(path.join(pageFolder, path.dirname(name), from));
    const found = INSTEAD.get(wanted) ?? wanted;
    imported.push(found);
    return `modules["${found}"]`;
  };
  const code = read(pageFolder, name)
    .replace(/^import \{([^}]*)\} from "(\.[^"]+)";$/gm, (_, names, from) => {
      return `const {${names.replace(/ as /g, ": ")}} = ${take(from)};`;
    })
    .replace(/^import \* as (\w+) from "(\.[^"]+)";$/gm, (_, as, from) => `const ${as} = ${take(from)};`)
    .replace(/^import "(\.[^"]+)";$/gm, (_, from) => void take(from) ?? "")
    .replace(/\bimport\(`\.\/\$\{(\w+)\}\.js`\)/g, (_, variable) => `Promise.resolve(modules[\`\${${variable}}.js\`])`)
    .replace(/^export (?=(?:async )?(?:const|let|class|function\*?) (\w+))/gm, (_, symbol) => {
      exported.push(symbol);
      return "";
    });
  if (/^(import|export)\b/m.test(code)) throw new Error(`${name}: bundle.mjs does not know an import or export of it`);
  imported.forEach(add);
  modules.set(name, `modules["${name}"] = (() => {\n${smaller(code)}\nreturn { ${exported.join(", ")} };\n})();`);
  order.push(name);
}

// Without comment lines and indentation. (No text of the page goes over several lines.)
function smaller(code) {
  return code
    .replace(/^\s*\/\*\*?[\s\S]*?\*\/$/gm, "")
    .split("\n")
    .map((line) => line.trim())
    .filter((line) => line && !line.startsWith("//"))
    .join("\n");
}

// app.js loads these by name.
for (const name of ["transfer", "slices", "measure", "compare", "exports"]) add(`${name}/${name}.js`);
add("app.js");
const app = `const modules = {};\n${order.map((name) => modules.get(name)).join("\n")}\n`;

// ---- the page -----------------------------------------------------------------------------------

let html = read(pageFolder, "index.html");
const replace = (what, by) => {
  if (!what.test(html)) throw new Error(`index.html: has no ${what}`);
  html = html.replace(what, () => by);
};
// The page's script is compressed too. This one starts it: the policy allows its text.
const start = smaller(read(path.join(webFolder, "page"), "start.js"));
const hashOf = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

const styles = [...html.matchAll(/<link rel="stylesheet" href="([^"]+)">\n/g)].map(([line, name]) => {
  html = html.replace(line, "");
  return smaller(read(pageFolder, name));
});
const style = `${[...styles, read(path.join(webFolder, "page"), site ? "site.css" : "caption.css")].join("\n")}\n`;
const policy = [
  "default-src 'none'",
  `script-src ${hashOf(start)} ${hashOf(app)} 'wasm-unsafe-eval'${site ? " 'self'" : ""}`,
  ...(site ? ["connect-src *"] : []), // ?url=
  `style-src ${hashOf(style)}`,
  "worker-src blob:",
  "img-src blob: data:",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");
const icon = Buffer.from(read(pageFolder, "icon.svg")).toString("base64");
const zipped = (bytes) => gzipSync(bytes, { level: 9 }).toString("base64");
const workerOf = (program, name) =>
  `${read(buildFolder, `${program}.js`)}\n${smaller(read(path.join(webFolder, "page"), name))}\n`;
const wasmOf = (program) => readFileSync(path.join(buildFolder, `${program}.wasm`));
const [worker, wasm] = [workerOf("cvol_web", "worker.js"), wasmOf("cvol_web")];
const data = (id, text) => `<script type="text/plain" id="${id}">${text}</script>\n`;

replace(
  /<meta charset="utf-8">\n/,
  `<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="${policy}">\n` +
    `<meta name="generator" content="cvol ${version}">\n`,
);
if (!site) replace(/<title>[^<]*<\/title>/, "<title><!--cvol:title--></title>");
replace(
  /<link rel="icon"[^>]*>/,
  `<link rel="icon" href="data:image/svg+xml;base64,${icon}">\n<style>${style}</style>`,
);
replace(/<script type="module"[^>]*><\/script>\n/, "");
if (!site) replace(/(?=    <div id="notice")/, '    <p id="caption"><!--cvol:caption--></p>\n');
replace(
  /<\/body>/,
  `${data("cvol-worker", zipped(worker))}${data("cvol-wasm", zipped(wasm))}${site ? "" : "<!--cvol:volumes-->"}` +
    `${data("cvol-app", zipped(app))}<script type="module">${start}</script>\n</body>`,
);
writeFileSync(out, html);
if (site) {
  const parts = [workerOf("cvol_convert", "converter.js"), wasmOf("cvol_convert")].map(zipped);
  writeFileSync(path.join(path.dirname(out), "convert.js"), `globalThis.cvolConverter = ${JSON.stringify(parts)};\n`);
}

const kB = (bytes) => `${(bytes / 1000).toFixed(0)} kB`;
const zip = (bytes) => gzipSync(bytes, { level: 9 }).length;
console.log(
  `${out}: ${kB(html.length)}; compressed by gzip, WebAssembly ${kB(zip(wasm))}, its JavaScript ${kB(zip(worker))}, ` +
    `page ${kB(zip(app + style))}`,
);
