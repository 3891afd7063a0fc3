// Fourier transform in place of `re` + i `im`, whose length is a power of two (Cooley and Tukey 1965).
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2;
    for (let k = 0; k < half; k++) {
      const c = Math.cos(-2 * Math.PI * k / size), s = Math.sin(-2 * Math.PI * k / size);
      for (let a = k; a < n; a += size) {
        const b = a + half, x = re[b] * c - im[b] * s, y = re[b] * s + im[b] * c;
        re[b] = re[a] - x;
        im[b] = im[a] - y;
        re[a] += x;
        im[a] += y;
      }
    }
  }
}

// One-sided power spectral density [unit²/Hz] of values every `step` seconds (Welch 1967): segments of `length`, a power
// of two, half over one another, without their means, in Hann windows; the mean of their periodograms.
function welch(values, step, length) {
  const window = Float64Array.from({ length }, (_, k) => 0.5 - 0.5 * Math.cos(2 * Math.PI * k / length));
  const energy = window.reduce((sum, w) => sum + w * w, 0), density = new Float64Array(length / 2 + 1);
  let segments = 0;
  for (let first = 0; first + length <= values.length; first += length / 2, segments++) {
    const re = Float64Array.from({ length }, (_, k) => values[first + k]), im = new Float64Array(length);
    const mean = re.reduce((sum, x) => sum + x, 0) / length;
    for (let k = 0; k < length; k++) re[k] = (re[k] - mean) * window[k];
    transform(re, im);
    for (let k = 0; k <= length / 2; k++) density[k] += (k % (length / 2) ? 2 : 1) * (re[k] ** 2 + im[k] ** 2) * step / energy;
  }
  const frequency = density.map((_, k) => k / (length * step));
  return { frequency, density: density.map(sum => sum / segments), segments };
}

// Segments for `count` samples: the largest power of two of which seven fit half over one another, at most 65,536.
function segmentOf(count) {
  return Math.min(65536, 2 ** Math.floor(Math.log2(count / 4)));
}

// Values every mean step between two times: the samples themselves if they are even, else linear between them.
function evenly(time, values, from, to) {
  const first = placeOf(time, from), last = placeOf(time, to + 1e-9 * (to - from)) - 1, count = last - first + 1;
  const step = (time[last] - time[first]) / (count - 1);
  let even = true;
  for (let k = first; k <= last && even; k++) even = Math.abs(time[k] - time[first] - (k - first) * step) < 1e-3 * step;
  const found = Float64Array.from({ length: count }, (_, k) => even
    ? values[first + k] : valueAt(time, values, time[first] + k * step, false));
  return { values: found, step, even, from: time[first], to: time[last] };
}
