// Plots over time, all with one x axis in seconds since the first frame.
'use strict';

// `onTime` gets the time (s) that was clicked on.
function makePlots(container, onTime) {
  const plots = {};
  let cursor = null;
  const gridColor = () =>
      getComputedStyle(document.documentElement).getPropertyValue('--line').trim();
  const palette = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9'];
  const paletteDark = ['#56b4e9', '#f0a04b', '#2fc79a', '#e3a6c6', '#f0c75e', '#8fd0f5'];
  // Once through the colours, lines are dashed.
  const lines = labels => ({
    labels: ['time (s)', ...labels],
    colors: labels.map((_, i) => colors()[i % palette.length]),
    series: Object.fromEntries(
        labels.map((label, i) => [label, {strokePattern: i < palette.length ? null : [6, 3]}])),
  });
  const isDark = window.matchMedia('(prefers-color-scheme: dark)');
  const colors = () => isDark.matches ? paletteDark : palette;
  isDark.addEventListener('change', () => {
    for (const {graph, labels} of Object.values(plots)) {
      graph.updateOptions({gridLineColor: gridColor(), axisLineColor: gridColor(),
                           ...lines(labels)});
    }
  });

  // As many decimals as tell one tick from the next.
  function tickLabel(value, granularity, options, graph) {
    const [low, high] = graph.yAxisRange();
    const decimals = Math.ceil(-Math.log10(Math.max((high - low) / 5, 1e-9)));
    return value.toFixed(Math.min(Math.max(decimals, 0), 6));
  }

  // The line at the time that is looked at.
  function placeCursor({graph, line}) {
    const [first, last] = graph.xAxisRange();
    const area = graph.getArea();
    line.hidden = cursor === null || cursor < first || cursor > last;
    if (line.hidden) return;
    line.style.left = graph.toDomXCoord(cursor) + 'px';
    line.style.top = area.y + 'px';
    line.style.height = area.h + 'px';
  }

  // rows: [time, value, ...] with null where there is none; labels: one a value.
  function setPlot(name, title, labels, rows) {
    if (!rows.some(row => row.slice(1).some(value => value !== null))) return;
    if (plots[name]) {
      Object.assign(plots[name], {labels, rows});
      plots[name].graph.updateOptions({file: rows, ...lines(labels)});
      return;
    }
    const panel = document.createElement('section');
    panel.className = 'panel';
    panel.innerHTML = `<h2></h2><div class="plot_frame"><div class="plot"></div>` +
        `<div class="cursor" hidden></div></div><div class="plot_legend"></div>` +
        `<p class="controls"><button type="button">SVG</button></p>`;
    panel.querySelector('h2').textContent = title;
    const button = panel.querySelector('button');
    button.setAttribute('aria-label', `Download ${title} as SVG`);
    button.onclick = () => download(name + '.svg', [svg(name)], 'image/svg+xml');
    container.appendChild(panel);
    const graph = new Dygraph(panel.querySelector('.plot'), rows, {
      ...lines(labels),
      xlabel: 'time (s)',
      xLabelHeight: 16,
      axisLabelFontSize: 12,
      strokeWidth: 1.5,
      gridLineColor: gridColor(),
      axisLineColor: gridColor(),
      labelsDiv: panel.querySelector('.plot_legend'),
      legend: labels.length > 1 ? 'always' : 'onmouseover',
      includeZero: name !== 'scale',
      digitsAfterDecimal: 4,
      axes: {y: {axisLabelFormatter: tickLabel}},
      clickCallback: (event, time) => onTime(time),
      drawCallback: () => { if (plots[name]) placeCursor(plots[name]); },
    });
    plots[name] = {graph, labels, rows, title, line: panel.querySelector('.cursor')};
    placeCursor(plots[name]);
    // The panel gets narrower when others come beside it, and with the window.
    new ResizeObserver(() => graph.resize()).observe(panel);
  }

  function setCursor(time) {
    cursor = time;
    for (const plot of Object.values(plots)) placeCursor(plot);
  }

  function svg(name) { return svgOf({...plots[name], colors: palette}); }

  return {setPlot, setCursor, svg};
}
