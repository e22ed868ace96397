// The image of a keyframe with its points coloured by depth.
'use strict';

// Near is yellow, far is violet (a sketch of matplotlib's plasma, reversed).
function depthColor(fraction) {
  const stops = [[240, 249, 33], [248, 149, 64], [204, 71, 120], [126, 3, 168], [60, 20, 160]];
  const x = Math.min(Math.max(fraction, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(x), stops.length - 2);
  const mix = k => Math.round(stops[i][k] + (x - i) * (stops[i + 1][k] - stops[i][k]));
  return `rgb(${mix(0)}, ${mix(1)}, ${mix(2)})`;
}

function decodeBase64(text) { return Uint8Array.from(atob(text), c => c.charCodeAt(0)); }
function decodeFloats(text) { return new Float32Array(decodeBase64(text).buffer); }

// Draws the keyframe and says in `legend` what the colours mean.
function showKeyframe(keyframe, index, count, canvas, legend) {
  const points = decodeFloats(keyframe.points || '');
  const inverse = [];
  for (let i = 2; i < points.length; i += 3) inverse.push(1 / points[i]);
  inverse.sort((a, b) => a - b);
  const quantile = q => inverse.length ? inverse[Math.floor(q * (inverse.length - 1))] : 1;
  const far = quantile(0.05), near = quantile(0.95);

  const image = new Image();
  image.onload = () => {
    canvas.width = keyframe.width;
    canvas.height = keyframe.height;
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const radius = Math.max(2, keyframe.width / 220);
    for (let i = 0; i < points.length; i += 3) {
      context.fillStyle = depthColor((near - 1 / points[i + 2]) / Math.max(near - far, 1e-9));
      context.beginPath();
      context.arc(points[i], points[i + 1], radius, 0, 2 * Math.PI);
      context.fill();
    }
    canvas.dataset.keyframe = index;
  };
  if (keyframe.jpeg) {
    image.src = 'data:image/jpeg;base64,' + keyframe.jpeg;
  } else {
    canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
    canvas.dataset.keyframe = index;
  }

  const colors = [0, 0.25, 0.5, 0.75, 1].map(depthColor).join(', ');
  legend.innerHTML = `<span>${index + 1} of ${count}, ${keyframe.t.toFixed(2)} s, ` +
      (keyframe.jpeg ? `${inverse.length} points</span>` :
                       'no image of it here: it came before this page, or the run is long</span>');
  if (inverse.length) {
    legend.innerHTML += `<span class="scale">${(1 / near).toFixed(2)} m` +
        `<span class="bar" style="background: linear-gradient(to right, ${colors})"></span>` +
        `${(1 / far).toFixed(2)} m</span>`;
  }
}
