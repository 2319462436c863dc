"use strict";
// Put into a copy of a study's page by check_page.py: does what a reader does and says what came of it.

const errors = [];
window.addEventListener("error", (event) => errors.push(event.message ?? `cannot load ${event.target.tagName}`), true);
window.addEventListener("unhandledrejection", (event) => errors.push(String(event.reason)));
const consoleError = console.error;
console.error = (...words) => { errors.push(words.join(" ")); consoleError(...words); };

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

function mouse(target, type, x, y) {
  target.dispatchEvent(new MouseEvent(type, { bubbles: true, cancelable: true, view: window, clientX: x, clientY: y, button: 0, buttons: type === "mouseup" ? 0 : 1 }));
}

/** Drags a box over the middle of a plot; the ranges of both axes before, after, and after "all". */
async function zoom(place) {
  place.scrollIntoView();
  await pause(50);
  const layer = place.querySelector(".nsewdrag");
  const box = layer.getBoundingClientRect();
  const at = (share) => [box.left + share * box.width, box.top + share * box.height];
  const ranges = () => ({ x: [...place.layout.xaxis.range], y: [...place.layout.yaxis.range] });
  const before = ranges();
  mouse(layer, "mousedown", ...at(0.3));
  const cover = document.querySelector(".dragcover") ?? document;
  mouse(cover, "mousemove", ...at(0.45));
  mouse(cover, "mousemove", ...at(0.6));
  mouse(cover, "mouseup", ...at(0.6));
  await pause(600);
  const after = ranges();
  [...place.parentElement.querySelectorAll("button")].find((button) => button.textContent === "all").click();
  await pause(600);
  return { before, after, all: ranges() };
}

/** The texts of a column after one click on its head and after two. */
function sort(table, column) {
  const head = table.querySelectorAll("th")[column];
  const cells = () => [...table.querySelectorAll("tbody tr")].map((line) => line.children[column].textContent);
  head.click();
  const up = { sort: head.getAttribute("aria-sort"), cells: cells() };
  head.click();
  return { up, down: { sort: head.getAttribute("aria-sort"), cells: cells() } };
}

/** Where the upper picture is cut and the bar stands, with the pointer down at 1/4 and dragged to 3/4. */
function wipe(place) {
  const box = place.getBoundingClientRect();
  const point = (type, share) => place.dispatchEvent(new PointerEvent(type, { bubbles: true, clientX: box.left + share * box.width, clientY: box.top + 5, buttons: 1, pointerId: 1 }));
  const state = () => ({ clip: place.querySelector(".over").style.clipPath, bar: place.querySelector(".bar").style.left });
  point("pointerdown", 0.25);
  const first = state();
  point("pointermove", 0.75);
  return { first, second: state(), loaded: [...place.querySelectorAll("img")].every((image) => image.complete && image.naturalWidth > 0) };
}

window.addEventListener("load", async () => {
  const result = {};
  try {
    await pause(500);
    const plot = document.querySelector(".plot");
    const table = [...document.querySelectorAll("table")].pop();
    const picture = document.querySelector(".wipe");
    result.plots = document.querySelectorAll(".plot .main-svg").length;
    result.zoom = plot && await zoom(plot);
    result.columns = [...table.querySelectorAll("th")].map((head) => head.textContent);
    result.sorts = result.columns.map((_, column) => sort(table, column));
    result.wipe = picture && wipe(picture);
    result.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    result.requests = performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !name.startsWith("data:"));
  } catch (error) {
    errors.push(String(error.stack));
  }
  result.errors = errors;
  document.body.append(Object.assign(document.createElement("pre"), { id: "page-test", textContent: JSON.stringify(result) }));
});
