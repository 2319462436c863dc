"use strict";
// What every study's page is made of: plots, tables, pictures to wipe. Knows no study.

/** An element with attributes and children; text children are text. */
function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.flat());
  return node;
}

/** A number for reading: three digits that count; nothing for null. */
function shortNumber(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2).replace(/\.?0+e/, "e").replace("e+", "e");
  if (size >= 100) return String(Math.round(value));
  return String(Number(value.toPrecision(3)));
}

const percent = (value) => (value === null || value === undefined ? null : 100 * value);
const unique = (values) => [...new Set(values)];

/** Rows by the text that `key` makes of each, in order of first use. */
function groupBy(rows, key) {
  const groups = new Map();
  for (const row of rows) {
    const name = key(row);
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push(row);
  }
  return groups;
}

function themeColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function themeLayout() {
  const axis = { gridcolor: themeColor("--line"), linecolor: themeColor("--line"), zerolinecolor: themeColor("--line") };
  return {
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: themeColor("--ink"), family: getComputedStyle(document.body).fontFamily, size: 12 },
    xaxis: axis,
    yaxis: axis,
  };
}

const plots = [];

/** One trace of Plotly from {name, x, y, error, kind: bar|line|points, color, dash, symbol, text}. */
function makeTrace(series) {
  const isBar = series.kind === "bar";
  const trace = {
    name: series.name,
    x: series.x,
    y: series.y,
    text: series.text,
    type: isBar ? "bar" : "scatter",
    textposition: isBar ? "none" : undefined,
    hovertemplate: `${series.text ? "%{text}<br>" : ""}%{x}: %{y:.4g}<extra>${series.name}</extra>`,
    marker: { color: series.color, size: 8, symbol: series.symbol, opacity: series.opacity, pattern: { shape: series.pattern ?? "" } },
    showlegend: series.legend ?? true,
  };
  if (!isBar) {
    trace.mode = series.kind === "points" ? "markers" : "lines+markers";
    trace.line = { color: series.color, dash: series.dash, shape: series.shape, width: 2 };
  }
  if (series.error) trace.error_y = { type: "data", array: series.error, thickness: 1.2, width: 3 };
  return trace;
}

/** Touch screens scroll the page with the finger that would zoom: there zooming is switched on first. */
const isTouch = matchMedia("(pointer: coarse)").matches;

/** Labels of a log axis: decades, or 1, 2 and 5 of each where there are few. */
function logTicks(values) {
  const positive = values.filter((value) => value > 0);
  const low = Math.min(...positive);
  const high = Math.max(...positive);
  if (!(high <= 1000 * low)) return { dtick: 1 };
  const tickvals = [];
  for (let decade = Math.floor(Math.log10(low)) - 1; decade <= Math.log10(high) + 1; ++decade) {
    for (const step of [1, 2, 5]) tickvals.push(Number(`${step}e${decade}`));
  }
  return { tickmode: "array", tickvals, ticktext: tickvals.map(shortNumber) };
}

function makeAxis(base, text, isLog, values, ticks) {
  const isWide = values.some((value) => value > 0 && (value < 1e-4 || value >= 1e6));
  const axis = { ...base, title: { text }, automargin: true, exponentformat: isWide ? "power" : "none" };
  if (typeof values[0] === "string") axis.dtick = 1;  // every name, on phones too
  if (!isLog) return { ...axis, rangemode: "tozero" };
  if (ticks) return { ...axis, type: "log", tickvals: ticks, ticktext: ticks.map(shortNumber) };
  return { ...axis, type: "log", ...logTicks(values) };
}

/** A plot to zoom into by dragging; a double click shows all again. `ticks`: x values to label on a log axis;
 *  `limits`: of a log y axis. */
function plot({ title, x, y, series, logX = false, logY = false, ticks, limits, note, height = 400 }) {
  const place = element("div", { class: "plot" });
  const theme = themeLayout();
  const layout = {
    ...theme,
    height,
    margin: { l: 60, r: 12, t: 10, b: 60 },
    barmode: "group",
    dragmode: isTouch ? false : "zoom",
    legend: { orientation: "h", y: 1.02, yanchor: "bottom" },
    xaxis: makeAxis(theme.xaxis, x, logX, series.flatMap((one) => one.x), ticks),
    yaxis: makeAxis(theme.yaxis, y, logY, limits ?? series.flatMap((one) => one.y)),
  };
  if (limits && logY) layout.yaxis.range = limits.map(Math.log10);
  if (!logX) delete layout.xaxis.rangemode;
  const button = (label, change) => element("button", { type: "button", onclick: () => Plotly.relayout(place, change()) }, label);
  const tools = [
    button("log", () => {
      const isLog = place.layout.yaxis.type === "log";
      const ticks = isLog ? { tickmode: "auto", dtick: null } : logTicks(series.flatMap((one) => one.y));
      const change = { "yaxis.type": isLog ? "linear" : "log", "yaxis.autorange": true };
      for (const [name, value] of Object.entries(ticks)) change[`yaxis.${name}`] = value;
      return change;
    }),
    button("all", () => (limits && logY && place.layout.yaxis.type === "log"
      ? { "xaxis.autorange": true, "yaxis.range": limits.map(Math.log10) }
      : { "xaxis.autorange": true, "yaxis.autorange": true })),
  ];
  if (isTouch) tools.unshift(button("zoom", () => ({ dragmode: place.layout.dragmode ? false : "zoom" })));
  const node = element("div", { class: "card" },
    element("div", { class: "tools" }, element("h3", {}, title), element("span", { class: "buttons" }, tools)), place);
  if (note) node.append(element("p", { class: "note" }, note));
  plots.push({ place, draw: () => Plotly.newPlot(place, series.map(makeTrace), layout, { responsive: true, displayModeBar: false }) });
  return node;
}

/** A table that sorts by the column clicked. Columns: {label, value(row), text(value)}. */
function table({ columns, rows, filter = rows.length > 30 }) {
  const body = element("tbody");
  let order = { column: -1, sign: 1 };
  let wanted = "";
  const cell = (column, row) => {
    const value = column.value(row);
    const isText = typeof value === "string" || typeof value === "boolean";
    return element("td", { class: isText ? "text" : "" }, isText ? String(value) : (column.text ?? shortNumber)(value));
  };
  const compare = (a, b) => {
    const [u, v] = [a, b].map(columns[order.column].value);
    if (u === v) return 0;
    if (u === null || u === undefined) return 1;
    if (v === null || v === undefined) return -1;
    return order.sign * (typeof u === "number" ? u - v : String(u).localeCompare(String(v)));
  };
  const fill = () => {
    const sorted = order.column < 0 ? rows : [...rows].sort(compare);
    const lines = sorted.map((row) => element("tr", {}, columns.map((column) => cell(column, row))));
    body.replaceChildren(...lines.filter((line) => line.textContent.toLowerCase().includes(wanted)));
  };
  const heads = columns.map((column, i) => {
    const sort = () => {
      order = { column: i, sign: order.column === i ? -order.sign : 1 };
      heads.forEach((head, j) => head.setAttribute("aria-sort", j !== i ? "none" : order.sign > 0 ? "ascending" : "descending"));
      fill();
    };
    const first = rows.length ? column.value(rows[0]) : "";
    return element("th", { class: typeof first === "string" ? "text" : "", tabindex: 0, "aria-sort": "none", onclick: sort,
      onkeydown: (event) => { if (event.key === "Enter") sort(); } }, column.label);
  });
  fill();
  const search = element("input", { type: "search", placeholder: "only rows with…", "aria-label": "only rows with",
    oninput: (event) => { wanted = event.target.value.toLowerCase(); fill(); } });
  return element("div", {}, filter ? element("p", {}, search) : [],
    element("div", { class: "scroll" }, element("table", {}, element("thead", {}, element("tr", {}, heads)), body)));
}

/** Values by two names as a coloured grid; cell(a, b) gives {text, value in [-1, 1], title} or null. */
function matrix({ names, cell }) {
  const color = (value) => {
    const size = Math.min(1, Math.abs(value));
    const to = value < 0 ? [0, 114, 178] : [213, 94, 0];
    return `rgb(${to.map((c) => Math.round(247 + (c - 247) * size)).join(",")})`;
  };
  const line = (a) => element("tr", {}, element("td", { class: "text" }, a), names.map((b) => {
    const entry = a === b ? null : cell(a, b);
    if (!entry) return element("td", {});
    const deep = Math.abs(entry.value) > 0.7 ? " deep" : "";
    return element("td", { class: "cell" + deep, style: `background:${color(entry.value)}`, title: entry.title }, entry.text);
  }));
  return element("div", { class: "scroll" }, element("table", { class: "matrix" },
    element("tr", {}, element("th", { class: "text" }, ""), names.map((name) => element("th", {}, name))), names.map(line)));
}

/** Pictures of the same part of a scene: any two under a wipe, and all of them small. */
function pictures({ title, items }) {
  const below = element("img", { alt: "", draggable: "false" });
  const above = element("img", { alt: "", draggable: "false", class: "over" });
  const bar = element("div", { class: "bar" });
  const left = element("span", { class: "label left" });
  const right = element("span", { class: "label right" });
  const wipe = element("div", { class: "wipe", tabindex: 0, role: "slider", "aria-label": `wipe, ${title}`, "aria-valuemin": 0, "aria-valuemax": 100 },
    below, above, bar, left, right);
  const move = (share) => {
    const at = Math.min(1, Math.max(0, share));
    above.style.clipPath = `inset(0 ${100 * (1 - at)}% 0 0)`;
    bar.style.left = `${100 * at}%`;
    wipe.setAttribute("aria-valuenow", Math.round(100 * at));
  };
  const follow = (event) => {
    const box = wipe.getBoundingClientRect();
    move((event.clientX - box.left) / box.width);
  };
  wipe.addEventListener("pointerdown", (event) => {
    if (event.isTrusted) wipe.setPointerCapture(event.pointerId);
    follow(event);
  });
  wipe.addEventListener("pointermove", (event) => { if (event.buttons || event.pointerType === "mouse") follow(event); });
  wipe.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -0.05, ArrowRight: 0.05 }[event.key];
    if (step) { move(Number(wipe.getAttribute("aria-valuenow")) / 100 + step); event.preventDefault(); }
  });
  const choose = (image, label, start) => {
    const show = (i) => { image.src = files[items[i].file]; image.alt = items[i].name; label.textContent = items[i].name; };
    const select = element("select", { "aria-label": "picture", onchange: (event) => show(Number(event.target.value)) },
      items.map((item, i) => element("option", { value: i }, item.name)));
    select.value = start;
    show(start);
    return select;
  };
  const selects = [choose(above, left, 0), choose(below, right, Math.min(1, items.length - 1))];
  move(0.5);
  const thumbs = items.map((item, i) => element("figure", {},
    element("img", { src: files[item.file], alt: item.name, loading: "lazy", onclick: () => {
      selects[1].value = i;
      selects[1].dispatchEvent(new Event("change"));
    } }), element("figcaption", {}, item.name, item.about ? element("div", {}, item.about) : [])));
  return element("div", { class: "card" }, element("div", { class: "tools" }, element("h3", {}, title),
    element("span", { class: "buttons" }, selects)), wipe, element("div", { class: "thumbs" }, thumbs));
}

const heading = (text) => element("h2", {}, text);
const paragraph = (text, kind) => element("p", { class: kind }, text);
const side = (...nodes) => element("div", { class: "row" }, ...nodes);

const study = JSON.parse(document.getElementById("study").textContent);
const files = JSON.parse(document.getElementById("files").textContent);

function facts() {
  const known = { version: study.version, commit: study.commit, CPU: study.cpu, threads: study.threads, seed: study.seed };
  return element("div", { class: "facts" }, Object.entries(known).map(([name, value]) => element("span", {}, `${name} ${value}`)));
}

/** Puts {title, lead, parts} on the page and draws the plots, again whenever the theme changes. */
function show({ title, lead, parts }) {
  document.title = `Relume: ${title}`;
  document.getElementById("page").append(element("h1", {}, title), paragraph(lead), facts(), ...parts.flat());
  plots.forEach(({ draw }) => draw());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    const theme = themeLayout();
    for (const { place } of plots) {
      Plotly.relayout(place, { "font.color": theme.font.color, "xaxis.gridcolor": theme.xaxis.gridcolor, "yaxis.gridcolor": theme.yaxis.gridcolor });
    }
  });
}
