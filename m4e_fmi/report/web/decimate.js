// The place of the first number of `sorted` that is not below `value`.
function placeOf(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Places of the samples to be drawn from the time `from` to `to` on `columns` pixels: in each column the first, the
// smallest, the largest and the last, so that no extreme is lost; one more beyond each end. Where a number is not
// finite the line breaks: such a sample of each column is kept.
function drawn(time, values, from, to, columns) {
  const first = Math.max(0, placeOf(time, from) - 1), last = Math.min(time.length - 1, placeOf(time, to));
  const found = [];
  if (last - first < 4 * columns) {
    for (let k = first; k <= last; k++) found.push(k);
    return found;
  }
  const columnOf = k => Math.floor((time[k] - from) / (to - from) * columns);
  for (let k = first; k <= last;) {
    const column = columnOf(k), kept = new Set([k]);
    let low = k, high = k, odd = -1, end = k;
    for (; end <= last && columnOf(end) === column; end++) {
      if (!Number.isFinite(values[end])) odd = end;
      if (!(values[end] >= values[low])) low = Number.isFinite(values[end]) ? end : low;
      if (!(values[end] <= values[high])) high = Number.isFinite(values[end]) ? end : high;
    }
    for (const place of [low, high, end - 1]) kept.add(place);
    if (odd >= 0) kept.add(odd);
    found.push(...[...kept].sort((a, b) => a - b));
    k = end;
  }
  return found;
}

// The value at a time: between samples linear, or that of the last one if it `steps`.
function valueAt(time, values, t, steps) {
  const next = Math.min(Math.max(placeOf(time, t), 1), time.length - 1), last = Math.max(next - 1, 0);
  if (time[next] <= t) return values[next];
  if (steps || t <= time[last]) return values[last];
  return values[last] + (values[next] - values[last]) * (t - time[last]) / (time[next] - time[last]);
}
