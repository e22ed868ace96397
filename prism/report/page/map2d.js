// The view from above on a plain canvas, where the browser has no WebGL: what makeView3d returns,
// drawn with x to the right and z up.
'use strict';

function makeMap2d(element, onKeyframe) {
  const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const canvas = document.createElement('canvas');
  element.appendChild(canvas);
  const context = canvas.getContext('2d');
  const values = {trajectory: [], groundtruth: [], cloud: [], keyframes: []};
  const cloudLayer = document.createElement('canvas');  // it takes long to draw
  let cloudDrawn = '';                                  // for this view
  const visible = {trajectory: true, groundtruth: true, cloud: true, keyframes: true};
  let colors = [], fractions = null, selected = -1, cursor = null;
  let box = {x: 0, z: 0, size: 1}, zoom = 1;

  const scale = () => zoom * 0.9 * Math.min(element.clientWidth, element.clientHeight) / box.size;
  const toScreen = (x, z) => [element.clientWidth / 2 + (x - box.x) * scale(),
                              element.clientHeight / 2 - (z - box.z) * scale()];

  function path(xyz, color) {
    context.strokeStyle = style(color);
    context.lineWidth = 2;
    context.beginPath();
    for (let i = 0; i < xyz.length; i += 3) context.lineTo(...toScreen(xyz[i], xyz[i + 2]));
    context.stroke();
  }

  function drawCloud() {
    const view = JSON.stringify([canvas.width, canvas.height, box, zoom, style('--ground')]);
    if (view !== cloudDrawn) {
      cloudDrawn = view;
      cloudLayer.width = canvas.width;
      cloudLayer.height = canvas.height;
      const layer = cloudLayer.getContext('2d');
      layer.setTransform(context.getTransform());
      for (let i = 0; i < values.cloud.length; i += 3) {
        layer.fillStyle = `rgb(${colors[i]}, ${colors[i + 1]}, ${colors[i + 2]})`;
        layer.fillRect(...toScreen(values.cloud[i], values.cloud[i + 2]), 1.5, 1.5);
      }
    }
    context.drawImage(cloudLayer, 0, 0, element.clientWidth, element.clientHeight);
  }

  function coloredPath(xyz) {
    for (let i = 0; i < xyz.length; i += 3) {
      if (fractions[i / 3] === null) continue;
      context.fillStyle = cssColor(fractions[i / 3]);
      const [x, y] = toScreen(xyz[i], xyz[i + 2]);
      context.fillRect(x - 2, y - 2, 4, 4);
    }
  }

  function dot(position, color, radius) {
    context.fillStyle = style(color);
    context.beginPath();
    context.arc(...toScreen(position[0], position[2]), radius, 0, 2 * Math.PI);
    context.fill();
  }

  function render() {
    const ratio = Math.min(window.devicePixelRatio, 2);
    if (element.clientWidth === 0 || element.clientHeight === 0) return;
    canvas.width = ratio * element.clientWidth;
    canvas.height = ratio * element.clientHeight;
    canvas.style.width = element.clientWidth + 'px';
    canvas.style.height = element.clientHeight + 'px';
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = style('--ground');
    context.fillRect(0, 0, element.clientWidth, element.clientHeight);
    if (visible.cloud) drawCloud();
    if (visible.groundtruth) path(values.groundtruth, '--truth');
    path(values.trajectory, '--estimate');
    if (visible.keyframes) for (const k of values.keyframes) dot(k.position, '--keyframe', 3);
    if (fractions) coloredPath(values.trajectory);
    if (values.keyframes[selected]) dot(values.keyframes[selected].position, '--ink', 5);
    if (cursor) dot(cursor, '--bad', 5);
  }

  const view = {
    setTrajectory(xyz, pieces, ofColors) { [values.trajectory, fractions] = [xyz, ofColors]; },
    setGroundtruth(xyz) { values.groundtruth = xyz; },
    setCloud(xyz, rgb) {
      [values.cloud, colors] = [xyz, rgb];
      cloudDrawn = '';
    },
    setView() {},
    setKeyframes(keyframes) { values.keyframes = keyframes; },
    select(index) {
      selected = index;
      render();
    },
    setCursor(position) {
      cursor = position;
      render();
    },
    setVisible(name, isVisible) {
      visible[name] = isVisible;
      render();
    },
    setExtent() {},
    reset() {
      const all = boundsOf([...values.trajectory], values.cloud);
      box = {x: (all.low[0] + all.high[0]) / 2, z: (all.low[2] + all.high[2]) / 2,
             size: Math.max(all.high[0] - all.low[0], all.high[2] - all.low[2], 0.1)};
      zoom = 1;
      render();
    },
    screenPosition(index) {
      const [x, y] = toScreen(values.keyframes[index].position[0],
                              values.keyframes[index].position[2]);
      return {x, y, inFront: true};
    },
    render,
  };

  canvas.addEventListener('click', event => {
    const at = canvas.getBoundingClientRect();
    let best = -1, bestDistance = 24;
    for (let i = 0; i < values.keyframes.length; ++i) {
      const p = view.screenPosition(i);
      const distance = Math.hypot(event.clientX - at.left - p.x, event.clientY - at.top - p.y);
      if (distance < bestDistance) [best, bestDistance] = [i, distance];
    }
    if (best >= 0) onKeyframe(best);
  });
  element.addEventListener('keydown', event => {
    const step = 0.1 * box.size / zoom;
    const actions = {
      ArrowLeft: () => { box.x -= step; }, ArrowRight: () => { box.x += step; },
      ArrowUp: () => { box.z += step; }, ArrowDown: () => { box.z -= step; },
      '+': () => { zoom /= 0.9; }, '-': () => { zoom *= 0.9; },
      n: () => onKeyframe(selected + 1), p: () => onKeyframe(selected - 1),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
    render();
  });
  new ResizeObserver(render).observe(element);
  return view;
}

// Where a path and nearly all points of a cloud lie: stray points do not count. x, y, z, x, ...
function boundsOf(path, cloud) {
  const low = [0, 0, 0], high = [0, 0, 0];
  for (let k = 0; k < 3; ++k) {
    const sorted = Float32Array.from({length: Math.floor(cloud.length / 3)},
                                     (_, i) => cloud[3 * i + k]).sort();
    const at = q => sorted[Math.round(q * (sorted.length - 1))];
    const ends = sorted.length ? [at(0.01), at(0.99)] : [];
    for (let i = k; i < path.length; i += 3) ends.push(path[i]);
    low[k] = ends.length ? ends.reduce((a, b) => Math.min(a, b)) : -1;
    high[k] = ends.length ? ends.reduce((a, b) => Math.max(a, b)) : 1;
  }
  return {low, high};
}
