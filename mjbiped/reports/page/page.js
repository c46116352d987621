"use strict";
(function () {
  const failure = (error) => {
    const place = document.getElementById("failure");
    place.hidden = false;
    place.textContent = "The figures cannot be drawn: " + error + ". The page needs a browser of 2023 or later.";
  };

  async function unpacked(id) {
    const letters = atob(document.getElementById(id).textContent);
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  function makeSortable(table) {
    const body = table.tBodies[0];
    const headings = [...table.tHead.rows[0].cells];
    headings.forEach((heading, column) => heading.addEventListener("click", () => {
      const down = heading.getAttribute("aria-sort") === "ascending";
      headings.forEach((each) => each.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", down ? "descending" : "ascending");
      const value = (row) => row.cells[column].textContent.replace("\u2212", "-");
      const order = (a, b) => {
        const [x, y] = [value(a), value(b)];
        const numbers = [Number(x), Number(y)];
        return x !== "" && y !== "" && !numbers.some(Number.isNaN) ? numbers[0] - numbers[1] : x.localeCompare(y);
      };
      const rows = [...body.rows].sort((a, b) => (down ? -order(a, b) : order(a, b)));
      body.append(...rows);
    }));
  }

  // The moment that all figures of a walk point at.
  function link(data) {
    const time = document.getElementById("plot-time");
    const ground = document.getElementById("plot-ground");
    const phases = document.getElementById("plot-phases");
    const slider = document.getElementById("slider");
    const words = document.getElementById("now");
    const video = document.getElementById("video");
    const first = data.time[0];
    const last = data.time[data.time.length - 1];
    const moving = phases.data.flatMap((trace, index) => (trace.meta === "now" ? [index] : []));
    const legs = Object.keys(data.legs);
    const drawnLegs = legs.map((name) => ground.data.findIndex((t) => t.name === name));
    let wanted = null;
    let drawn = Promise.resolve();
    slider.min = first;
    slider.max = last;

    // The nearest sample, as in the labels at the figures' curves.
    const sampleAt = (moment) => {
      let [low, high] = [0, data.time.length - 1];
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (data.time[middle] <= moment) low = middle; else high = middle;
      }
      return data.time[high] - moment < moment - data.time[low] ? high : low;
    };

    const places = (k, axis) => legs.map((name) => data.legs[name].map((point) => point[axis][k]));

    async function draw() {
      const moment = wanted;
      const k = sampleAt(moment);
      const line = { type: "line", xref: "x", yref: "paper", x0: moment, x1: moment, y0: 0, y1: 1,
        line: { color: "#222222", width: 1.5 } };
      await Plotly.relayout(time, { shapes: [line] });
      await Plotly.restyle(ground, { x: places(k, 0), y: places(k, 1) }, drawnLegs);
      const [left, right] = ground.layout.xaxis.range.map(Number);
      const x = data.legs[legs[0]][0][0][k];
      if (x < left + 0.15 * (right - left) || x > right - 0.15 * (right - left)) {
        await Plotly.relayout(ground, { "xaxis.range": [x - 0.3 * (right - left), x + 0.7 * (right - left)] });
      }
      await Plotly.restyle(phases, { x: data.q.map((q) => [q[k]]), y: data.dq.map((dq) => [dq[k]]) }, moving);
      const told = data.told.filter(([, values]) => values[k] !== null).map(([name, values, unit]) =>
        name + " " + values[k].toFixed(2) + (unit === "\u00b0" ? "" : "\u00a0") + unit);
      words.textContent = ["t = " + data.time[k].toFixed(3) + " s", "step " + data.step[k], ...told].join(", ");
      slider.value = moment;
      document.body.dataset.moment = moment.toFixed(3);
      if (wanted !== moment) await draw();
    }

    function go(moment) {
      const idle = wanted === null;
      wanted = Math.min(last, Math.max(first, moment));
      if (idle) drawn = drawn.then(draw).catch(failure).finally(() => { wanted = null; });
    }

    time.on("plotly_hover", (event) => { if (!video || video.paused) go(Number(event.points[0].x)); });
    time.on("plotly_click", (event) => { if (video) video.currentTime = Number(event.points[0].x) - first; });
    slider.addEventListener("input", () => {
      if (video) { video.pause(); video.currentTime = Number(slider.value) - first; }
      go(Number(slider.value));
    });
    if (video) {
      const follow = () => { go(first + video.currentTime); if (!video.paused) requestAnimationFrame(follow); };
      video.addEventListener("play", follow);
      video.addEventListener("seeked", follow);
    }
    go(first);
  }

  async function begin() {
    document.querySelectorAll("table.sortable").forEach(makeSortable);
    const program = document.createElement("script");
    program.textContent = await unpacked("plotly-packed");
    document.head.append(program);
    const { plots, data } = JSON.parse(await unpacked("data-packed"));
    const config = {
      responsive: true,
      displaylogo: false,
      modeBarButtons: [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "autoScale2d", "resetScale2d"]],
    };
    for (const [name, plot] of Object.entries(plots)) {
      await Plotly.newPlot("plot-" + name, plot.data, plot.layout, { ...config, scrollZoom: name === "ground" });
    }
    if (data.time) link(data);
    document.body.dataset.ready = "yes";
  }

  begin().catch(failure);
})();
