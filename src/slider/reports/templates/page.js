"use strict";
const root = document.documentElement;
const charts = [...document.querySelectorAll(".chart")];
const parse = (id) => JSON.parse(document.getElementById(id).textContent);
const PAPER_WIDTH = 690;  // [pixel], A4 and Letter within usual margins
const config = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["lasso2d", "select2d"] };

// Charts take the colours of text and grid from the page's style.
function colours(layout) {
  const style = getComputedStyle(root);
  const ink = style.getPropertyValue("--ink").trim();
  const line = style.getPropertyValue("--line").trim();
  const panel = style.getPropertyValue("--panel").trim();
  const update = {
    "font.color": ink,
    "font.family": getComputedStyle(document.body).fontFamily,
    "hoverlabel.bgcolor": panel,
    "hoverlabel.font.color": ink,
  };
  for (const name of Object.keys(layout).filter((key) => /^[xy]axis\d*$/.test(key))) {
    Object.assign(update, {
      [`${name}.gridcolor`]: line, [`${name}.linecolor`]: line, [`${name}.zerolinecolor`]: line,
      [`${name}.showline`]: true, [`${name}.automargin`]: true,
    });
  }
  (layout.updatemenus || []).forEach((_, index) => Object.assign(update, {
    [`updatemenus[${index}].bgcolor`]: panel, [`updatemenus[${index}].bordercolor`]: line,
    [`updatemenus[${index}].font.color`]: ink,
  }));
  return update;
}

function paint() {
  return Promise.all(charts.map((chart) => Plotly.relayout(chart, colours(chart.layout))));
}

function setTheme(theme) {
  root.dataset.theme = theme;
  return paint();
}

// Paper is narrower than a screen, and charts do not follow by themselves.
function resize(width) {
  charts.forEach((chart) => Plotly.relayout(chart, { width, autosize: width === undefined }));
}

// Hovering a point of one chart draws its details in another.
function link(chart) {
  const target = document.getElementById(chart.dataset.linked);
  const shown = document.getElementById(`${chart.id}-shown`);
  const details = parse(`${chart.id}-details`);
  const show = (event) => {
    const index = event.points[0].customdata;
    const curves = details.curves[index];
    Plotly.restyle(target, { x: curves.map((curve) => curve[0]), y: curves.map((curve) => curve[1]) });
    shown.textContent = details.titles[index];
  };
  chart.on("plotly_hover", show);
  chart.on("plotly_click", show);
}

function sortBy(heading) {
  const table = heading.closest("table");
  const column = [...heading.parentNode.children].indexOf(heading);
  const up = heading.getAttribute("aria-sort") !== "ascending";
  heading.parentNode.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
  heading.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = (row) => row.children[column].dataset.key;
  const order = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === "" || y === "") return (x === "") - (y === "");  // cells without a value come last
    const [m, n] = [number(x), number(y)];
    const sign = Number.isNaN(m) || Number.isNaN(n) ? x.localeCompare(y) : m - n || 0;
    return up ? sign : -sign;
  };
  const body = table.tBodies[0];
  body.append(...[...body.rows].sort(order));
}

const number = (text) => (text === "inf" ? Infinity : Number(text));

async function start() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  root.dataset.theme = dark.matches ? "dark" : "light";
  for (const chart of charts) {
    const spec = parse(`${chart.id}-spec`);
    await Plotly.newPlot(chart, spec.data, spec.layout, config);
    if (chart.dataset.linked) link(chart);
  }
  await paint();
  dark.addEventListener("change", (event) => setTheme(event.matches ? "dark" : "light"));
  document.getElementById("theme").addEventListener("click", () => {
    setTheme(root.dataset.theme === "dark" ? "light" : "dark");
  });
  let before;
  addEventListener("beforeprint", () => { before = root.dataset.theme; setTheme("light"); resize(PAPER_WIDTH); });
  addEventListener("afterprint", () => { setTheme(before); resize(undefined); });
  document.querySelectorAll("table.sortable th").forEach((heading) => {
    heading.addEventListener("click", () => sortBy(heading));
    heading.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      sortBy(heading);
    });
  });
  const playAll = document.getElementById("play-all");
  if (playAll) playAll.addEventListener("click", () => {
    document.querySelectorAll("video").forEach((video) => { video.currentTime = 0; video.play(); });
  });
  root.dataset.ready = "true";
}
start();
