// Fills the page from the data in it and, in a live view, from the server's events.
'use strict';

(function() {
  const data = JSON.parse(document.getElementById('data').textContent);
  const get = id => document.getElementById(id);
  const {setPlot, setCursor, svg} = makePlots(get('plots'), time => goToTime(time));
  const view = makeView(get('view3d'));
  let selected = 0;
  let looked = 0;      // at this frame
  let places = [];     // of each frame its place in the trajectory; null: not tracked

  // In 3D where the browser can.
  function makeView(element) {
    try {
      return makeView3d(element, choose);
    } catch (error) {
      element.replaceChildren();
      get('no_webgl').hidden = false;
      get('picture_control').hidden = true;
      return makeMap2d(element, choose);
    }
  }

  function select(index) {
    if (data.keyframes.length === 0) return;
    selected = Math.min(Math.max(index, 0), data.keyframes.length - 1);
    const keyframe = data.keyframes[selected];
    get('keyframe_slider').value = selected;
    view.select(selected, keyframe);
    showKeyframe(keyframe, selected, data.keyframes.length, get('point_color').value,
                 get('keyframe_image'), get('depth_legend'));
  }

  // All that shows a moment shows that of this frame.
  function goToFrame(index) {
    if (data.frames.length === 0) return;
    looked = Math.min(Math.max(index, 0), data.frames.length - 1);
    const frame = data.frames[looked];
    const time = frame.t - data.frames[0].t;
    get('frame_slider').value = looked;
    get('frame_text').textContent = `frame ${looked * step()} of ${count('frame')}, ` +
        `${time.toFixed(2)} s, ${frame.keyframe ? 'keyframe' : frame.status}`;
    setCursor(time);
    const place = places[looked];
    view.setCursor(place === null || place === undefined ?
                       null : data.trajectory.slice(3 * place, 3 * place + 3));
    let last = -1;
    while (last + 1 < data.keyframes.length && data.keyframes[last + 1].t <= frame.t + 1e-6) ++last;
    if (last >= 0 && last !== selected) select(last);
  }

  function goToTime(time) {
    const t = time + data.frames[0].t;
    let best = 0;
    data.frames.forEach((frame, i) => {
      if (Math.abs(frame.t - t) < Math.abs(data.frames[best].t - t)) best = i;
    });
    goToFrame(best);
  }

  // A keyframe the reader asks for, or the next with a picture: in long runs not all have one.
  function choose(index) {
    const step = index < selected ? -1 : 1;
    let shown = index;
    while (data.keyframes[shown] && !data.keyframes[shown].jpeg) shown += step;
    select(data.keyframes[shown] ? shown : index);
    const chosen = selected;
    goToTime(data.keyframes[selected].t - data.frames[0].t);
    if (selected !== chosen) select(chosen);  // of a long run the frame itself is not here
  }

  // Of a long run only every so many frames are here.
  const step = () => data.live ? 1 : data.frame_step || 1;
  // How many there are: `frame`, `tracked` or `keyframe`.
  const count = what => !data.live ? data[what + '_count'] :
      what === 'frame' ? data.frames.length : data.frames.filter(frame => frame[what]).length;

  function median(values) {
    const sorted = [...values].sort((a, b) => a - b);
    return sorted.length ? sorted[Math.ceil(sorted.length / 2) - 1] : 0;
  }
  const format = (value, digits) =>
      value === null || value === undefined ? 'none' : Number(value).toFixed(digits);

  function fillTable(table, rows, header) {
    table.replaceChildren();
    for (const [r, row] of (header ? [header, ...rows] : rows).entries()) {
      const line = table.insertRow();
      row.forEach((text, i) => {
        const cell = document.createElement(i === 0 || (header && r === 0) ? 'th' : 'td');
        if (i > 0 && header) cell.className = 'number';
        cell.textContent = text;
        line.appendChild(cell);
      });
    }
  }

  function fillHead() {
    get('title').textContent = document.title = data.title;
    get('summary').textContent = `${count('tracked')} of ${count('frame')} frames tracked, ` +
        `${count('keyframe')} keyframes` +
        (data.live ? data.disconnected ? ', no connection to the run' : ', running' : '') + (data.git_hash ? `, revision ${data.git_hash}` : '');
    const problems = get('problems');
    problems.replaceChildren();
    const list = document.createElement(data.problems.length ? 'ul' : 'p');
    if (data.problems.length === 0) {
      list.className = 'fine';
      list.textContent = data.live ? '' : 'Every frame was tracked.';
    }
    for (const problem of data.problems) {
      list.appendChild(document.createElement('li')).textContent = problem;
    }
    problems.appendChild(list);
    for (const list of ['notes', 'left_out']) {
      const lines = data[list] || [];
      get(list).hidden = lines.length === 0;
      get(list).replaceChildren(...lines.map(line => {
        const item = document.createElement('li');
        item.textContent = line;
        return item;
      }));
    }
  }

  function fillTiles() {
    const m = data.metrics;
    const tiles = [];
    if (m) {
      tiles.push([format(m.ate_rmse_m, 4) + ' m', 'ATE RMSE, SE3'],
                 [format(m.ate_rmse_sim3_m, 4) + ' m', 'ATE RMSE, Sim3'],
                 [format(m.scale, 4), 'scale against ground truth'],
                 [format(m.rpe_trans_rmse_m, 4) + ' m', 'drift over 1 s'],
                 [format(m.path_length_m, 2) + ' m', 'path']);
    }
    if (data.scale_sigma > 0) {
      tiles.push(['± ' + (100 * data.scale_sigma).toFixed(2) + ' %', 'metric scale, stated (1 σ)']);
    }
    if (data.wall_seconds > 0) {
      tiles.push([(count('frame') / data.wall_seconds).toFixed(1), 'frames a second']);
      tiles.push([(1000 * data.processor_seconds / count('frame')).toFixed(0) + ' ms',
                  'processor time a frame']);
      tiles.push([data.peak_resident_mib.toFixed(0) + ' MiB', 'peak memory']);
    }
    get('tiles').replaceChildren(...tiles.map(([value, name]) => {
      const tile = document.createElement('div');
      tile.className = 'tile';
      tile.appendChild(document.createElement('b')).textContent = value;
      tile.appendChild(document.createElement('span')).textContent = name;
      return tile;
    }));
  }

  function stagesOf(frames) {
    const times = {};
    for (const frame of frames) {
      for (const [name, ms] of Object.entries(frame.ms)) (times[name] = times[name] || []).push(ms);
    }
    return Object.fromEntries(Object.entries(times).map(([name, ms]) => [name, {
      count: ms.length, median: median(ms), largest: ms.reduce((a, b) => Math.max(a, b)),
      total: ms.reduce((a, b) => a + b, 0)}]));
  }

  function fillTables() {
    fillTable(get('stages'), Object.entries(data.stages || stagesOf(data.frames))
        .sort(([, a], [, b]) => b.total - a.total)
        .map(([name, s]) => [name, s.count, s.median.toFixed(2), s.largest.toFixed(2),
                             s.total.toFixed(0)]),
              ['stage', 'frames', 'median ms', 'largest ms', 'total ms']);
    fillTable(get('metrics'), Object.entries(data.metrics || {}).filter(
        ([, value]) => typeof value !== 'object').map(([name, value]) => [name, value]));
    fillTable(get('camera'), data.camera);
    fillTable(get('options'), Object.entries(data.options));
  }

  function fillPlots() {
    if (data.frames.length === 0) return;
    const start = data.frames[0].t;
    const rows = (...keys) => data.frames.map(
        frame => [frame.t - start, ...keys.map(key => frame[key] === undefined ? null : frame[key])]);
    const shifted = series => (series || []).map(([t, value]) => [t - start, value]);
    setPlot('error', 'Position error against ground truth (m)', ['error'], shifted(data.error));
    setPlot('scale', 'Scale against ground truth, window of 3 s', ['scale'], shifted(data.scale));
    setPlot('scale_sigma', 'Stated σ of the metric scale of a window (%)', ['σ'],
            data.frames.filter(frame => frame.scale_sigma).map(
                frame => [frame.t - start, 100 * frame.scale_sigma]));
    setPlot('rms', 'Residual RMS (intensities)', ['RMS'], rows('rms'));
    setPlot('points', 'Points used', ['points'], rows('points'));
    setPlot('a', 'Brightness a (log gain)', ['a'], rows('a'));
    setPlot('b', 'Brightness b (intensities)', ['b'], rows('b'));
    const stages = [...new Set(data.frames.flatMap(frame => Object.keys(frame.ms)))];
    setPlot('ms', 'Stage times (ms)', stages,
            data.frames.map(frame => [frame.t - start, ...stages.map(name => frame.ms[name] || 0)]));
  }

  // What the path can be coloured by: values of the tracked frames, null where there is none.
  function pathValues(name) {
    const tracked = data.frames.filter(frame => frame.tracked);
    if (name === 'time') return tracked.map(frame => frame.t - data.frames[0].t);
    if (name === 'residual') return tracked.map(frame => frame.rms === undefined ? null : frame.rms);
    const error = data.error || [];
    let next = 0;
    return tracked.map(frame => {
      while (next + 1 < error.length &&
             Math.abs(error[next + 1][0] - frame.t) <= Math.abs(error[next][0] - frame.t)) ++next;
      return next < error.length && Math.abs(error[next][0] - frame.t) < 0.2 ? error[next][1] : null;
    });
  }

  function fillPath() {
    const name = get('path_color').value;
    const values = name ? pathValues(name) : [];
    const sorted = values.filter(value => value !== null).sort((a, b) => a - b);
    const legend = get('path_legend');
    if (sorted.length === 0) {
      view.setTrajectory(data.trajectory, data.pieces, null);
      const key = document.createElement('span');
      key.className = 'key estimate';
      legend.replaceChildren(key, 'estimate');
      return;
    }
    const low = name === 'error' ? 0 : sorted[0];
    const high = name === 'time' ? sorted[sorted.length - 1] : quantileOf(sorted, 0.98);
    const range = Math.max(high - low, 1e-12);
    view.setTrajectory(data.trajectory, data.pieces,
                       values.map(value => value === null ? null : (value - low) / range));
    const texts = {time: v => `${v.toFixed(1)} s`, error: v => `${(1e3 * v).toFixed(1)} mm`,
                   residual: v => v.toFixed(1)};
    legend.replaceChildren(`estimate by ${name} `, colorScale(
        texts[name](low), texts[name](high) + (name === 'residual' ? ' intensities' : '')));
  }

  function fillCloud() {
    const shown = data[get('cloud_choice').value];
    view.setCloud(shown ? decodeFloats(shown.positions) : new Float32Array(),
                  shown ? decodeBase64(shown.colors) : new Uint8Array());
  }

  function extent(values) {
    let squared = 0;
    for (let k = 0; k < 3; ++k) {
      let low = Infinity, high = -Infinity;
      for (let i = k; i < values.length; i += 3) {
        low = Math.min(low, values[i]);
        high = Math.max(high, values[i]);
      }
      if (high > low) squared += (high - low) ** 2;
    }
    return Math.sqrt(squared);
  }

  function fill3d() {
    view.setExtent(extent(data.trajectory));
    fillPath();
    view.setView(data.view);
    view.setKeyframes(data.keyframes);
    if (data.groundtruth) {
      view.setGroundtruth(data.groundtruth);
      get('groundtruth_key').hidden = get('groundtruth_control').hidden = false;
    }
    get('path_color').querySelector('[value=error]').disabled = !data.error;
    const dense = get('cloud_choice').querySelector('[value=dense]');
    if (data.dense && dense.disabled) get('cloud_choice').value = 'dense';
    dense.disabled = !data.dense;
    get('download_dense').hidden = !data.dense;
    fillCloud();
    get('keyframe_slider').max = Math.max(data.keyframes.length - 1, 0);
    let place = 0;
    places = data.frames.map(frame => frame.tracked ? place++ : null);
    get('frame_slider').max = Math.max(data.frames.length - 1, 0);
  }

  function fillAll() {
    get('downloads').hidden = data.live || data.frames.length === 0;
    get('download_trajectory').hidden = !data.trajectory_tum;
    fillHead();
    fillTiles();
    fillTables();
    fillPlots();
    fill3d();
  }

  get('previous_keyframe').onclick = () => choose(selected - 1);
  get('next_keyframe').onclick = () => choose(selected + 1);
  get('keyframe_slider').oninput = event => choose(Number(event.target.value));
  get('frame_slider').oninput = event => goToFrame(Number(event.target.value));
  get('download_trajectory').onclick = () =>
      download('trajectory.txt', [data.trajectory_tum], 'text/plain');
  for (const [name, file] of [['cloud', 'points.ply'], ['dense', 'points_dense.ply']]) {
    get('download_' + name).onclick = () => download(
        file, plyOf(decodeFloats(data[name].positions), decodeBase64(data[name].colors)),
        'application/octet-stream');
  }
  get('reset_view').onclick = () => view.reset();
  for (const name of ['keyframes', 'picture', 'groundtruth']) {
    get('show_' + name).onchange = event => view.setVisible(name, event.target.checked);
  }
  get('point_color').onchange = () => select(selected);
  get('path_color').onchange = () => {
    fillPath();
    view.render();
  };
  get('cloud_choice').onchange = () => {
    fillCloud();
    view.render();
  };
  fillAll();
  view.reset();
  select(0);
  goToFrame(0);

  // Live: each event holds what is new; the page is redrawn twice a second at most.
  function take(update) {
    data.frames.push(...update.frames);
    data.trajectory.push(...update.trajectory);
    for (const keyframe of update.keyframes) {
      data.keyframes[keyframe.index] = Object.assign(data.keyframes[keyframe.index] || {}, keyframe);
    }
    if (update.problems) data.problems = update.problems;
    if (update.finished) {
      Object.assign(data, update.finished);
      data.live = false;
    }
  }

  if (data.live) {
    let waiting = false;
    const events = new EventSource('events');
    events.onerror = () => {
      data.disconnected = true;
      fillHead();
    };
    events.onopen = () => {
      data.disconnected = false;
      fillHead();
    };
    events.onmessage = event => {
      const update = JSON.parse(event.data);
      if (update.reload) {  // another run by now
        location.reload();
        return;
      }
      const wasAtEnd = looked >= data.frames.length - 1;
      const isAtLast = selected >= data.keyframes.length - 1;
      take(update);
      if (update.finished) events.close();
      if (isAtLast) selected = Math.max(data.keyframes.length - 1, 0);
      if (waiting) return;
      waiting = true;
      setTimeout(() => {
        waiting = false;
        const isFirst = document.body.dataset.started === undefined;
        document.body.dataset.started = 'yes';
        fillAll();
        if (isFirst) view.reset();
        select(selected);
        if (wasAtEnd) goToFrame(data.frames.length - 1);
      }, 500);
    };
  }
  window.prismReport = {view, data, svg, plyOf};
  document.body.dataset.ready = 'yes';
})();
