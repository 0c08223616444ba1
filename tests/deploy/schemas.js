// SPDX-License-Identifier: MIT
// Holds Kubernetes objects against the schemas of npm's kubernetes-models: kinds, types, required
// fields, and, because the validators look at every field they know, fields that there are not.
//
//   node schemas.js MODULES <objects.json      MODULES: folder of node_modules; a JSON array
//
// Prints what is wrong, a line each; exit status 1 if anything is.
const path = require('path');

const modules = path.resolve(process.argv[2]);

function modelOf(object) {
  const [group, version] = object.apiVersion.includes('/') ?
      object.apiVersion.split('/') : ['', object.apiVersion];
  const library = group.endsWith('coreos.com') ? '@kubernetes-models/prometheus-operator' :
                                                 'kubernetes-models';
  return require(path.join(modules, library, group, version, object.kind))[object.kind];
}

// The value, with every field that is looked at noted.
function watched(value, where, seen, all) {
  if (value === null || typeof value !== 'object') return value;
  const copy = Array.isArray(value) ? [] : {};
  for (const [key, inner] of Object.entries(value)) {
    const place = `${where}/${key}`;
    all.add(place);
    copy[key] = watched(inner, place, seen, all);
  }
  return new Proxy(copy, {
    get(target, key) {
      seen.add(`${where}/${String(key)}`);
      return target[key];
    },
  });
}

function problems(object) {
  const name = `${object.kind} ${object.metadata.name}`;
  let Model;
  try {
    Model = modelOf(object);
  } catch (error) {
    return [`${name}: there is no such kind in ${object.apiVersion}`];
  }
  const seen = new Set(), all = new Set();
  const found = [];
  try {
    // Not of a new Model, which would copy, and so look at, everything.
    Model.prototype.validate.call(watched(object, '', seen, all));
  } catch (error) {
    found.push(`${name}: ${error.message}`);
  }
  for (const place of all) {
    // Of what is not known, only the outermost.
    const parent = place.slice(0, place.lastIndexOf('/'));
    const top = place.lastIndexOf('/') === 0;
    if (!seen.has(place) && (top || seen.has(parent))) found.push(`${name}: unknown field ${place}`);
  }
  return found;
}

const found = JSON.parse(require('fs').readFileSync(0, 'utf8')).flatMap(problems);
for (const line of found) console.log(line);
process.exit(found.length ? 1 : 0);
