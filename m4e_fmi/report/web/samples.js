// Samples of the page: each variable is a block of text, decoded when it is first needed.

// Bytes of the block `id`: base64 of gzip.
async function unpacked(id) {
  const text = atob(document.getElementById(id).textContent), bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  const stream = new DecompressionStream("gzip"), writer = stream.writable.getWriter();
  writer.write(bytes);
  writer.close();
  return new Uint8Array(await new Response(stream.readable).arrayBuffer());
}

// Bytes of numbers of `size` bytes, of which the first bytes of all come first, then the second ones.
function together(bytes, size) {
  const count = bytes.length / size, found = new Uint8Array(bytes.length);
  for (let b = 0; b < size; b++) for (let k = 0; k < count; k++) found[size * k + b] = bytes[b * count + k];
  return found.buffer;
}

// The numbers of a variable as the page has it: { block, kind }, or one that is { constant }.
async function numbersOf(variable, count) {
  if ("constant" in variable) return new Float64Array(count).fill(variable.constant);
  const bytes = await unpacked(variable.block);
  const kinds = { f8: [Float64Array, 8], f4: [Float32Array, 4], u1: [Uint8Array, 1] };
  const [Kind, size] = kinds[variable.kind];
  return new Kind(together(bytes, size));
}

// All variables by name, and `numbers(name)`, a promise that is kept at once for what was decoded before.
function storeOf(data) {
  const kept = new Map(), variables = new Map(data.variables.map(one => [one.name, one]));
  return {
    variables,
    count: data.count,
    time: null,
    async ready() { this.time = await numbersOf(data.time, data.count); },
    numbers(name) {
      if (!kept.has(name)) kept.set(name, numbersOf(variables.get(name), data.count));
      return kept.get(name);
    },
  };
}

// Runs the plotting library, which is one more block.
async function library() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await unpacked("library"));
  document.head.append(script);
}

// Opens the folded section that the address names: nothing is found in a folded one.
function unfold() {
  const place = document.getElementById(location.hash.slice(1));
  if (place?.tagName !== "DETAILS") return;
  place.open = true;
  place.scrollIntoView();
}
window.addEventListener("hashchange", unfold);
unfold();

// Runs `action`, and tells the reader what went wrong.
async function started(action) {
  try {
    await action();
  } catch (error) {
    const place = document.querySelector(".problem[role=alert]");
    place.hidden = false;
    place.textContent = typeof DecompressionStream === "undefined"
      ? "This browser is too old for the plots: it has no DecompressionStream (any browser since 2023 has it)."
      : "The plots cannot be shown: " + error;
    throw error;
  }
}
