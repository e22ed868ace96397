// Plots over time, all with one x axis in seconds since the first frame.
'use strict';

function makePlots(container) {
  const plots = {};
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

  // rows: [time, value, ...] with null where there is none; labels: one a value.
  return function setPlot(name, title, labels, rows) {
    if (rows.length === 0) return;
    if (plots[name]) {
      plots[name].labels = labels;
      plots[name].graph.updateOptions({file: rows, ...lines(labels)});
      return;
    }
    const panel = document.createElement('section');
    panel.className = 'panel';
    panel.innerHTML = `<h2></h2><div class="plot"></div><div class="plot_legend"></div>`;
    panel.querySelector('h2').textContent = title;
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
    });
    plots[name] = {graph, labels};
    // The panel gets narrower when others come beside it, and with the window.
    new ResizeObserver(() => graph.resize()).observe(panel);
  };
}
