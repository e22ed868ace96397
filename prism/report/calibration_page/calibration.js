// The page of prism_calibrate: its data are those of calibration.json.
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function element(tag, text, parent) {
  const node = document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.appendChild(node);
  return node;
}

function tile(value, text) {
  const node = element('div', undefined, document.getElementById('tiles'));
  node.className = 'tile';
  element('b', value, node);
  element('span', text, node);
}

function fillTable(id, head, rows) {
  const table = document.getElementById(id);
  const header = element('tr', undefined, element('thead', undefined, table));
  head.forEach((text, i) => { element('th', text, header).className = i ? 'number' : ''; });
  const body = element('tbody', undefined, table);
  for (const row of rows) {
    const line = element('tr', undefined, body);
    row.forEach((text, i) => { element('td', text, line).className = i ? 'number' : ''; });
  }
  return body;
}

// Nothing where there is no value: pictures without a board.
function number(value, digits) { return value == null ? '' : value.toFixed(digits); }

// ---- figures ----

const used = data.views.filter(view => view.corners.length > 0);
document.getElementById('summary').textContent =
    `${used.length} of ${data.views.length} pictures, ${data.corners} corners; ` +
    `${data.board.pattern}, ${data.board.columns} x ${data.board.rows} squares of ` +
    `${(1e3 * data.board.square_m).toFixed(2)} mm`;
if (data.findings.length > 0) {
  const list = element('ul', undefined, document.getElementById('findings'));
  for (const finding of data.findings) element('li', finding, list);
}
for (const figure of data.figures.slice(0, 3)) {
  tile(`${number(figure.value, 4)} ${figure.unit}`,
       figure.name + (figure.held ? ', held' : ` ± ${number(figure.sigma, 4)}`));
}
tile(`${number(data.px_rms, 3)} px`, 'RMS of corners, raw');
tile(number(data.inverse_depth_rms, 5), 'RMS of 1/v');
tile(number(data.left_out_rms_in_sigmas, 2), 'error of pictures left out, RMS over stated');
fillTable('figures', ['', 'value', '±', 'unit', ...data.figures.map(f => f.name)],
          data.figures.map((figure, i) => [
            figure.name, figure.value.toPrecision(7), figure.held ? 'held' : figure.sigma.toPrecision(2),
            figure.unit, ...data.correlations[i].map(c => c === 0 ? '' : c.toFixed(2))]));
const leftOut = new Map(data.left_out.map(view => [view.name, view]));
const rows = fillTable(
    'pictures', ['picture', 'corners', 'm', 'tilt, °', 'RMS, px', 'RMS, 1/v', 'left out, %', 'stated, %'],
    data.views.map(view => {
      const without = leftOut.get(view.name);
      return [view.name, view.corners.length, number(view.distance_m, 3), number(view.tilt_deg, 0),
              number(view.px_rms, 3), number(view.inverse_depth_rms, 5),
              without ? number(100 * without.relative_error, 2) : '',
              without ? number(100 * without.sigma, 2) : ''];
    }));

// ---- plots ----

const byDistance = [...data.left_out].sort((a, b) => a.distance_m - b.distance_m);
const plotColors = {axisLineColor: style('--line'), gridLineColor: style('--line')};
if (byDistance.length > 0) {
  new Dygraph(document.getElementById('distance_plot'),
              byDistance.map(v => [v.distance_m, [100 * v.relative_error, 100 * v.sigma]]),
              {labels: ['m', 'error, %'], errorBars: true, sigma: 1, drawPoints: true, pointSize: 4,
               strokeWidth: 0, colors: [style('--estimate')], includeZero: true, ...plotColors});
}
new Dygraph(document.getElementById('sigma_plot'),
            data.distance_sigma.map(d => [d.distance_m, 100 * d.relative_sigma]),
            {labels: ['m', '%'], colors: [style('--estimate')], includeZero: true, drawPoints: true,
             ...plotColors});

// ---- corners on the sensor ----

const SVG = 'http://www.w3.org/2000/svg';
const STRETCH = 200;  // of residuals
const marks = [];     // per view, its lines

function drawCoverage() {
  const svg = document.createElementNS(SVG, 'svg');
  const [width, height] = data.raw_size;
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  svg.setAttribute('role', 'img');
  svg.setAttribute('aria-label', 'Corners on the sensor');
  const add = (tag, attributes) => {
    const node = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    svg.appendChild(node);
    return node;
  };
  add('rect', {x: 0, y: 0, width, height, class: 'seen', 'stroke-width': width / 400});
  for (const view of data.views) {
    marks.push(view.corners.map(c => {
      const line = add('line', {x1: c.px[0], y1: c.px[1], x2: c.px[0] + STRETCH * c.residual[0],
                                y2: c.px[1] + STRETCH * c.residual[1],
                                'stroke-width': width / 300, 'stroke-linecap': 'round'});
      return line;
    }));
  }
  const panel = document.getElementById('coverage');
  panel.insertBefore(svg, panel.querySelector('.legend'));
}
drawCoverage();

// ---- boards ----

function makeBoards(container) {
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  } catch (error) {
    element('p', 'This browser shows no 3D.', container);
    return {choose() {}};
  }
  container.appendChild(renderer.domElement);
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.setClearColor(style('--ground'));
  const scene = new THREE.Scene();
  const farthest = Math.max(...used.map(view => view.distance_m));
  const camera = new THREE.PerspectiveCamera(50, 1, 0.01, 100 * farthest);
  camera.up.set(0, -1, 0);
  camera.position.set(0.6 * farthest, -0.4 * farthest, -0.3 * farthest);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.target.set(0, 0, 0.4 * farthest);
  const outline = (corners, color, transform) => {
    const points = [...corners, corners[0]].map(p => transform(new THREE.Vector3(...p)));
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
                                new THREE.LineBasicMaterial({color: style(color)}));
    scene.add(line);
    return line;
  };
  const w = data.board.columns * data.board.square_m;
  const h = data.board.rows * data.board.square_m;
  const boards = data.views.map(view => {
    if (!view.rotation) return null;
    const q = new THREE.Quaternion(...view.rotation);
    const t = new THREE.Vector3(...view.position);
    return outline([[0, 0, 0], [w, 0, 0], [w, h, 0], [0, h, 0]], '--estimate',
                   p => p.applyQuaternion(q).add(t));
  });
  // The camera's view, out to the nearest board.
  const s = 0.5 * Math.min(...used.map(view => view.distance_m));
  const [tx, ty] = data.half_view_tangents;
  const rim = [[-tx, -ty], [tx, -ty], [tx, ty], [-tx, ty]].map(([x, y]) => [x * s, y * s, s]);
  outline(rim, '--keyframe', p => p);
  for (const corner of rim) outline([[0, 0, 0], corner], '--keyframe', p => p);
  const render = () => renderer.render(scene, camera);
  const resize = () => {
    renderer.setSize(container.clientWidth, container.clientHeight);
    camera.aspect = container.clientWidth / container.clientHeight;
    camera.updateProjectionMatrix();
    render();
  };
  controls.addEventListener('change', render);
  window.addEventListener('resize', resize);
  controls.update();
  resize();
  return {
    choose(index) {
      boards.forEach((board, i) => {
        if (board) board.material.color.set(style(i === index ? '--keyframe' : '--estimate'));
      });
      render();
    }
  };
}
const boards = makeBoards(document.getElementById('view3d'));

// A click on a picture's row shows where it is.
[...rows.children].forEach((row, index) => {
  row.addEventListener('click', () => {
    [...rows.children].forEach((other, i) => other.classList.toggle('chosen', i === index));
    marks.forEach((lines, i) => {
      for (const line of lines) line.classList.toggle('bad', i === index);
    });
    boards.choose(index);
  });
});
