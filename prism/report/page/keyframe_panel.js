// The image of a keyframe with its points coloured by depth or residual, and beneath it the depth
// it measured.
'use strict';

// Low is yellow, high is violet (a sketch of matplotlib's plasma, reversed).
const COLOR_STOPS =
    [[240, 249, 33], [248, 149, 64], [204, 71, 120], [126, 3, 168], [60, 20, 160]];

// Its colour at a fraction, 0 to 255 each.
function colorAt(fraction) {
  const x = Math.min(Math.max(fraction, 0), 1) * (COLOR_STOPS.length - 1);
  const i = Math.min(Math.floor(x), COLOR_STOPS.length - 2);
  return [0, 1, 2].map(
      k => Math.round(COLOR_STOPS[i][k] + (x - i) * (COLOR_STOPS[i + 1][k] - COLOR_STOPS[i][k])));
}

function cssColor(fraction) { return `rgb(${colorAt(fraction).join(', ')})`; }

// A legend of the colours between two texts.
function colorScale(low, high) {
  const scale = document.createElement('span');
  scale.className = 'scale';
  const bar = document.createElement('span');
  bar.className = 'bar';
  bar.style.background =
      `linear-gradient(to right, ${[0, 0.25, 0.5, 0.75, 1].map(cssColor).join(', ')})`;
  scale.append(low, bar, high);
  return scale;
}

function decodeBase64(text) { return Uint8Array.from(atob(text), c => c.charCodeAt(0)); }
function decodeFloats(text) { return new Float32Array(decodeBase64(text).buffer); }

function quantileOf(sorted, q) { return sorted[Math.floor(q * (sorted.length - 1))]; }

// What the points can be coloured by: each point's fraction of the colours, NaN where it has none,
// and what stands at both ends.
const POINT_COLORS = {
  depth(points) {
    const inverse = points.map(p => 1 / p.depth).sort((a, b) => a - b);
    const far = quantileOf(inverse, 0.05), near = quantileOf(inverse, 0.95);
    return {fraction: p => (near - 1 / p.depth) / Math.max(near - far, 1e-9),
            low: `${(1 / near).toFixed(2)} m`, high: `${(1 / far).toFixed(2)} m`};
  },
  residual(points) {
    const sorted = points.map(p => p.residual).filter(Number.isFinite).sort((a, b) => a - b);
    const high = sorted.length ? quantileOf(sorted, 0.95) : 1;
    return {fraction: p => p.residual / high, low: '0', high: `${high.toFixed(1)} intensities`};
  },
};

// Draws a map of the keyframe in colour; `figure` holds a canvas and a caption.
function showMap(map, name, unit, figure) {
  figure.hidden = !map;
  if (!map) return;
  const canvas = figure.querySelector('canvas');
  canvas.dataset.png = map.png;
  const image = new Image();
  image.onload = () => {
    if (canvas.dataset.png !== map.png) return;  // another keyframe by now
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
    for (let i = 0; i < pixels.data.length; i += 4) {
      const level = pixels.data[i];
      if (level === 0) {
        pixels.data[i + 3] = 0;
      } else {
        pixels.data.set(colorAt((level - 1) / (map.levels - 1)), i);
      }
    }
    context.putImageData(pixels, 0, 0);
  };
  image.src = 'data:image/png;base64,' + map.png;
  const digits = value => value.toPrecision(3);
  figure.querySelector('figcaption').replaceChildren(
      name, colorScale(digits(map.low), `${digits(map.high)}${unit}`));
}

// Draws the keyframe and says in `legend` what the colours mean. `color`: of the points, a name of
// POINT_COLORS, or none.
function showKeyframe(keyframe, index, count, color, canvas, legend) {
  const values = decodeFloats(keyframe.points || '');
  const points = [];
  for (let i = 0; i < values.length; i += 4) {
    points.push({x: values[i], y: values[i + 1], depth: values[i + 2], residual: values[i + 3]});
  }
  const coloring = points.length && POINT_COLORS[color] ? POINT_COLORS[color](points) : null;

  const image = new Image();
  image.onload = () => {
    canvas.width = keyframe.width;
    canvas.height = keyframe.height;
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const radius = Math.max(2, keyframe.width / 220);
    for (const point of coloring ? points : []) {
      const fraction = coloring.fraction(point);
      if (!Number.isFinite(fraction)) continue;
      context.fillStyle = cssColor(fraction);
      context.beginPath();
      context.arc(point.x, point.y, radius, 0, 2 * Math.PI);
      context.fill();
    }
    canvas.dataset.keyframe = index;
    canvas.dataset.color = color;
  };
  if (keyframe.jpeg) {
    image.src = 'data:image/jpeg;base64,' + keyframe.jpeg;
  } else {
    canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
    canvas.dataset.keyframe = index;
  }

  legend.textContent = `${index + 1} of ${count}, ${keyframe.t.toFixed(2)} s, ` +
      (keyframe.jpeg ? `${points.length} points` :
                       'no image of it here: it came before this page, or the run is long');
  if (coloring) legend.append(colorScale(coloring.low, coloring.high));
  showMap(keyframe.inverse_virtual_depth, '1/v', '', document.getElementById('depth_map'));
  showMap(keyframe.sigma, 'σ of 1/v', '', document.getElementById('sigma_map'));
}
