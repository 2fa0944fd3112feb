// Bundles the viewer into one page template and prints it as a C++ source: node build.js page.cpp
import { build } from 'esbuild';
import { readFile, writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(path, import.meta.url));

async function bundle(entry, options) {
  const result = await build({ entryPoints: [here(entry)], bundle: true, minify: true, write: false, charset: 'utf8',
                               legalComments: 'none', target: ['es2020', 'chrome100', 'firefox100', 'safari15'], ...options });
  return result.outputFiles[0].text.trim();
}

function fill(template, parts) {
  return template.replace(/@(\w+)@/g, (marker, name) => parts[name] ?? marker);
}

function escape_html(text) {
  return text.replace(/[&<>]/g, (character) => `&#${character.charCodeAt(0)};`);
}

const page = fill(await readFile(here('page.html'), 'utf8'), {
  style: await bundle('src/page.css'),
  script: await bundle('src/main.js', { format: 'iife' }),
  licence: escape_html(await readFile(here('node_modules/three/LICENSE'), 'utf8')),
});

// The three pieces around the title and the data of one report; a raw string needs no escapes.
const pieces = page.split(/@title@|@data@/);
if (pieces.length !== 3 || pieces.some((piece) => piece.includes(')page"'))) throw new Error('page.html: bad template');
const names = ['kPageBeforeTitle', 'kPageBeforeData', 'kPageEnd'];
const definitions = pieces.map((piece, i) => `const std::string_view ${names[i]} = R"page(${piece})page";\n`);
await writeFile(process.argv[2], `#include "report/page_template.hpp"

namespace swiftlet::tools {

${definitions.join('')}
}  // namespace swiftlet::tools
`);
