// What the page shows as files: trajectory, points, and the plots as SVG.
'use strict';

function download(name, parts, type) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob(parts, {type}));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A binary PLY of positions x, y, z, x, ... with a colour each, red, green, blue, red, ...
function plyOf(positions, colors) {
  const count = colors.length / 3;
  const header = 'ply\nformat binary_little_endian 1.0\ncomment PRISM-VO, metres\n' +
      `element vertex ${count}\nproperty float x\nproperty float y\nproperty float z\n` +
      'property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n';
  const body = new DataView(new ArrayBuffer(15 * count));
  for (let i = 0; i < count; ++i) {
    for (let k = 0; k < 3; ++k) {
      body.setFloat32(15 * i + 4 * k, positions[3 * i + k], true);
      body.setUint8(15 * i + 12 + k, colors[3 * i + k]);
    }
  }
  return [header, body];
}

function ticksOf(low, high) {
  const rough = (high - low) / 5 || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(m => m * power).find(s => s >= rough);
  const ticks = [];
  for (let t = Math.ceil(low / step) * step; t <= high + 1e-9 * step; t += step) ticks.push(t);
  return {ticks, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

// A plot as a figure for print. rows: [time, value, ...] with null where there is none.
function svgOf({title, labels, rows, colors}) {
  const escape = text => String(text).replace(/[&<>]/g, c => `&#${c.charCodeAt(0)};`);
  const width = 640, height = 360, left = 70, right = 20, top = 40, bottom = 50;
  const values = rows.flatMap(row => row.slice(1)).filter(v => v !== null && Number.isFinite(v));
  if (values.length === 0) return null;
  const range = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
  if (range[0] === range[1]) range[1] = range[0] + 1;
  const time = [rows[0][0], Math.max(rows[rows.length - 1][0], rows[0][0] + 1e-9)];
  const x = t => left + (t - time[0]) / (time[1] - time[0]) * (width - left - right);
  const y = v => height - bottom - (v - range[0]) / (range[1] - range[0]) * (height - top - bottom);
  const parts = [`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" ` +
                 'font-family="sans-serif" font-size="13">',
                 `<text x="${left}" y="22" font-size="15">${escape(title)}</text>`];
  const text = (px, py, anchor, label) =>
      parts.push(`<text x="${px}" y="${py}" text-anchor="${anchor}">${escape(label)}</text>`);
  const line = (x1, y1, x2, y2) => parts.push(
      `<line x1="${x1}" y1="${y1}" x2="${x2}" y2="${y2}" stroke="#d5dae1"/>`);
  const ty = ticksOf(...range), tx = ticksOf(...time);
  for (const v of ty.ticks) {
    line(left, y(v), width - right, y(v));
    text(left - 8, y(v) + 4, 'end', v.toFixed(ty.decimals));
  }
  for (const t of tx.ticks) {
    line(x(t), top, x(t), height - bottom);
    text(x(t), height - bottom + 18, 'middle', t.toFixed(tx.decimals));
  }
  text((left + width - right) / 2, height - 10, 'middle', 'time (s)');
  labels.forEach((label, i) => {
    let move = 'M', d = '';
    for (const row of rows) {
      const value = row[i + 1];
      if (value === null || value === undefined) {
        move = 'M';
        continue;
      }
      d += `${move}${x(row[0]).toFixed(2)} ${y(value).toFixed(2)}`;
      move = 'L';
    }
    parts.push(`<path d="${d}" fill="none" stroke="${colors[i % colors.length]}" ` +
               `stroke-width="1.5"${i < colors.length ? '' : ' stroke-dasharray="6 3"'}/>`);
    if (labels.length > 1) {
      parts.push(`<text x="${width - right - 4}" y="${top + 14 + 15 * i}" text-anchor="end" ` +
                 `fill="${colors[i % colors.length]}">${escape(label)}</text>`);
    }
  });
  return parts.join('\n') + '\n</svg>\n';
}
