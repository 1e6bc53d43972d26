/** A texture from its JSON document: `tactogram_studio.touch.document`. */

import { tableOf } from "./touch_textures.js";

export const FORMAT = "tactogram-texture";
export const VERSION = 1;
const KINDS = { float64: Float64Array, float32: Float32Array, int16: Int16Array };

/**
 * Return the table and the picture in a document.
 * @param {string} text JSON.
 * @returns {{table: import("./touch_textures.js").Table, picture: Record<string, any> | null}}
 */
export function readDocument(text) {
  const { format, version, arrays, picture, ...facts } = parsed(text);
  if (format !== FORMAT || version !== VERSION) {
    const got = format === FORMAT ? `version ${version}` : (format ?? "another JSON");
    throw new Error(`expected a ${FORMAT}, version ${VERSION}, got ${got}; write one with: tactogram touch`);
  }
  try {
    return { table: tableIn(facts, arrays), picture: picture ?? null };
  } catch {
    throw new Error("its arrays are damaged; write it again with: tactogram touch");
  }
}

function tableIn(facts, arrays) {
  const places = {};
  let end = 0;
  for (const [name, { type, values }] of Object.entries(arrays)) {
    places[name] = { type, offset: end, length: values.length };
    end += 8 * Math.ceil((values.length * KINDS[type].BYTES_PER_ELEMENT) / 8);
  }
  const table = tableOf({ ...facts, arrays: places }, new ArrayBuffer(end));
  for (const [name, { values }] of Object.entries(arrays)) table.arrays[name].set(values);
  return table;
}

function parsed(text) {
  try {
    return JSON.parse(text) ?? {};
  } catch {
    throw new Error(`expected a ${FORMAT}, got no JSON; write one with: tactogram touch`);
  }
}

/** Return the bytes of base64. @param {string} text */
export function decoded(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
