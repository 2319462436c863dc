"use strict";
// Which plots, tables and pictures each study's page has. A study's document names its layout.

// Okabe and Ito's colours, told apart by most eyes: the report's light metrics in blues, ours in green.
const methodColors = {
  "all": "#888888", "pure": "#888888", "kmeans": "#e69f00", "strong-kmeans": "#d55e00", "kmedoids": "#cc79a7",
  "cmeans": "#a65fa0", "light-metric-1": "#56b4e9", "light-metric-2": "#7aa6d8", "light-metric-3": "#5b8fc7",
  "light-metric-4": "#0072b2", "light-metric-5": "#3d6fb0", "light-metric-6": "#99b8dd", "light-fit-fast": "#66c2a5",
  "light-fit": "#009e73",
};
const shadowColors = {
  "none": "#888888", "ray": "#e69f00", "members": "#d55e00", "coverage": "#009e73", "opacity": "#56b4e9", "volume": "#cc79a7",
};
const shadowNames = { "none": "no shadows", "ray": "one ray a record" };

const relative = (row) => percent(row.error_relative);
const relativeHalf = (row) => percent(row.error_half_95 / row.reference_mean);
const methodName = (row) => (row.budget > 0 ? `${row.method}, average ${row.budget}`
  : row.train_shadows ? `${row.method} with shadows` : row.method);
const recordsName = (row) => (row.budget > 0 ? `average ${shortNumber(row.budget)}` : String(row.records));

const sceneColumn = { label: "scene", value: (r) => r.scene };
const methodColumn = { label: "method", value: (r) => (r.train_shadows ? `${r.method} with shadows` : r.method) };
const recordsColumn = { label: "k", value: (r) => (r.budget > 0 ? r.budget : r.records), text: (v) => shortNumber(v) };
const shadowColumn = { label: "shadow", value: (r) => r.shadow };
const errorColumn = { label: "error, %", value: relative };
const halfColumn = { label: "± 95 %", value: relativeHalf };
const ratioColumn = { label: "of K-means", value: (r) => r.ratio_to_kmeans ?? null };

const errorNote = "Error: TR2007-600 eq. 7 over covered pixels, in percent of the reference's mean value; bars are 95 % confidence " +
  "intervals of the mean over the test lights. Light metrics \"with shadows\" were trained on shadowed lights, as the report's were.";

function methodRowsTable(rows, extra = []) {
  return table({ rows, columns: [sceneColumn, shadowColumn, methodColumn, recordsColumn,
    { label: "records a pixel", value: (r) => r.average_records }, ...extra, errorColumn, halfColumn,
    { label: "σ of lights, %", value: (r) => percent(r.error_stddev / r.reference_mean) }, ratioColumn] });
}

/** Every two methods: how many times the row's error is the column's; grey where it may be chance. */
function pairMatrix(pairs) {
  const short = (name) => name.replace(/, k = \d+/, "");
  const names = unique(pairs.flatMap((pair) => [short(pair.a), short(pair.b)]));
  const found = new Map(pairs.flatMap((pair) => [[`${short(pair.a)}|${short(pair.b)}`, { ...pair, r: pair.ratio }],
    [`${short(pair.b)}|${short(pair.a)}`, { ...pair, r: 1 / pair.ratio }]]));
  return matrix({ names, cell: (a, b) => {
    const pair = found.get(`${a}|${b}`);
    if (!pair) return null;
    const sure = pair.p_holm < 0.05;
    return { text: shortNumber(pair.r), value: sure ? Math.max(-1, Math.min(1, Math.log2(pair.r) / 4)) : 0,
      title: `${a} / ${b}: ${shortNumber(pair.r)}, p = ${shortNumber(pair.p_holm)} after Holm, ${pair.lights} lights` };
  } });
}

function layoutMethods() {
  const parts = [];
  for (const [scene, rows] of groupBy(study.rows, (r) => r.scene)) {
    const series = [...groupBy(rows, (r) => r.shadow)].map(([shadow, own]) => ({
      name: shadowNames[shadow] ?? shadow, kind: "points", color: shadow === "none" ? "#56b4e9" : "#e69f00",
      symbol: shadow === "none" ? "circle" : "square", x: own.map((r) => `${methodName(r)}${unique(rows.map((q) => q.records)).length > 2 && !r.budget ? `, ${r.records}` : ""}`),
      y: own.map(relative), error: own.map(relativeHalf),
    }));
    parts.push(heading(scene), plot({ title: `${scene}: error of each method`, x: "", y: "error, %", series, logY: true, height: 460,
      note: errorNote }));
    for (const [shadow, pairs] of groupBy((study.pairs ?? []).filter((p) => p.scene === scene), (p) => p.shadow)) {
      for (const [k, own] of groupBy(pairs, (p) => p.a.match(/k = (\d+)/)?.[1] ?? "")) {
        if (k === "" || own.length < 2) continue;
        parts.push(paragraph(`Error of the row as a multiple of the column's, k = ${k}, ${shadowNames[shadow] ?? shadow}. Blue: the row is ` +
          "better, orange: worse; white: Wilcoxon's signed-rank test over the paired lights, corrected after Holm, does not tell them apart at 5 %.", "note"),
          pairMatrix(own));
      }
    }
  }
  parts.push(heading("All figures"), methodRowsTable(study.rows));
  return { title: "reduction methods",
    lead: "TR2007-600, experiment 1 (figure 2): random point lights that no method was trained on; every pixel's samples (25 in " +
      "the report) reduced to k records (8) by each method, PURE taking k fresh samples; all against all samples.", parts };
}

function layoutRates() {
  const parts = [];
  for (const [scene, ofScene] of groupBy(study.rows, (r) => r.scene)) {
    const cards = [...groupBy(ofScene, (r) => r.shadow)].map(([shadow, rows]) => {
      const series = [...groupBy(rows, (r) => (r.budget > 0 ? `${r.method}, budget` : methodName(r)))].map(([name, own]) => ({
        name, kind: "line", color: methodColors[own[0].method], dash: own[0].budget > 0 ? "dot" : own[0].train_shadows ? "dash" : undefined,
        text: own.map((r) => `k = ${recordsName(r)}`), x: own.map((r) => r.average_records), y: own.map(relative), error: own.map(relativeHalf),
      }));
      return plot({ title: `${scene}, ${shadowNames[shadow] ?? shadow}`, x: "records a pixel, mean", y: "error, %", series, logX: true, logY: true, ticks: [1, 2, 3, 4, 6, 8, 12, 16, 24] });
    });
    parts.push(heading(scene), side(...cards));
  }
  parts.push(paragraph(errorNote, "note"), heading("All figures"), methodRowsTable(study.rows));
  return { title: "fewer records",
    lead: "TR2007-600, experiment 2 (figures 4 and 5): 25 samples a pixel reduced to 8, 4 and 2 records. The report lights each scene one " +
      "way; here the error is the mean over random lights. Budgets give every pixel its own k.", parts };
}

function layoutLights() {
  const parts = [];
  for (const [scene, ofScene] of groupBy(study.rows, (r) => r.scene)) {
    const cards = [...groupBy(ofScene, (r) => r.shadow)].map(([shadow, rows]) => {
      const trained = rows.filter((r) => r.training_lights > 0);
      const ends = [Math.min(...trained.map((r) => r.training_lights)), Math.max(...trained.map((r) => r.training_lights))];
      const series = [...groupBy(trained, (r) => `${r.method}, trained ${r.train_shadows ? "with" : "without"} shadows`)].map(([name, own]) => ({
        name, kind: "line", color: methodColors[own[0].method], dash: own[0].train_shadows ? "dash" : undefined,
        x: own.map((r) => r.training_lights), y: own.map(relative), error: own.map(relativeHalf),
      }));
      for (const base of rows.filter((r) => r.training_lights === 0)) {
        series.push({ name: base.method, kind: "line", color: methodColors[base.method], x: ends, y: ends.map(() => relative(base)) });
      }
      return plot({ title: `${scene}, ${shadowNames[shadow] ?? shadow}`, x: "training lights", y: "error, %", series, logX: true, ticks: unique(trained.map((r) => r.training_lights)), height: 460 });
    });
    parts.push(heading(scene), side(...cards));
  }
  const columns = [{ label: "training lights", value: (r) => r.training_lights }];
  parts.push(paragraph(errorNote, "note"), heading("All figures"), methodRowsTable(study.rows, columns));
  return { title: "more training lights",
    lead: "TR2007-600, experiment 3 (figures 6 and 7): light metrics trained on 12 to 800 random lights, without and with traced shadows, " +
      "beside K-means, which is trained on none; 8 records a pixel.", parts };
}

function layoutShadows() {
  const parts = [];
  const name = (r) => (r.method === "all" ? "all samples, ray" : `${r.method} ${r.records}, ${r.shadow}`);
  for (const [scene, rows] of groupBy(study.rows, (r) => r.scene)) {
    const means = rows.filter((r) => r.light === "mean");
    const bars = [["bias", "#0072b2"], ["noise", "#e69f00"], ["flicker", "#cc79a7"]].map(([key, color]) => ({
      name: key, kind: "bar", color, x: means.map(name), y: means.map((r) => r[key]) }));
    parts.push(heading(scene), plot({ title: `${scene}: error of visibility`, x: "", y: "mean absolute difference", series: bars, height: 460,
      note: `Against ${means[0]?.truth_spp} traced samples a pixel, mean over the lights. Bias: what a Gaussian of 3 pixels leaves of the ` +
        "difference; noise: the rest; flicker: how differently from the truth it changes when the light moves by a pixel." }));
    const lights = unique(rows.map((r) => r.light)).filter((l) => l !== "mean");
    const byShadow = [...groupBy(rows.filter((r) => r.light !== "mean"), (r) => r.shadow)].map(([shadow, own]) => {
      const best = lights.map((light) => own.filter((r) => r.light === light && r.method !== "all").map((r) => r.mae).sort((a, b) => a - b)[0] ?? null);
      return { name: shadow, kind: "points", color: shadowColors[shadow], x: lights, y: best };
    });
    parts.push(plot({ title: `${scene}: best of each shadow method, by light`, x: "", y: "mean |difference| of visibility", series: byShadow }));
    if (means.some((r) => r.ms_move > 0)) {
      const timed = [...groupBy(means.filter((r) => r.ms_move > 0), (r) => r.shadow)].map(([shadow, own]) => ({ name: shadow, kind: "points",
        color: shadowColors[shadow], text: own.map(name), x: own.map((r) => r.ms_move), y: own.map((r) => r.mae) }));
      parts.push(plot({ title: `${scene}: error against time`, x: "milliseconds a light move, without shading", y: "mean |difference|", series: timed, logX: true }));
    }
  }
  for (const maps of study.pictures ?? []) {
    parts.push(heading(`${maps.set}: maps`),
      paragraph("Maps of visibility, a row a light: the truth, then each setting in the order of the table below.", "note"),
      element("div", { class: "scroll" }, element("img", { src: files[maps.file], alt: maps.name })));
  }
  const numbers = ["truth_visibility", "mae", "bias", "noise", "flicker", "truth_change"].map((key) => ({ label: key.replace("_", " "), value: (r) => r[key] }));
  parts.push(heading("All figures"), table({ rows: study.rows, columns: [sceneColumn, { label: "light", value: (r) => r.light }, methodColumn,
    { label: "k", value: (r) => r.records }, shadowColumn, ...numbers, { label: "eq. 7, %", value: relative },
    { label: "ms a move", value: (r) => r.ms_move || null }, { label: "MiB", value: (r) => r.structure_bytes / 2 ** 20 }] }));
  return { title: "shadows", lead: "Every way to shadow records, held against a traced truth: visibility of each pixel, unshaded, under five lights " +
    "that move.", parts };
}

function layoutPictures() {
  const sets = groupBy(study.pictures, (p) => p.set);
  const parts = [];
  for (const [scene, names] of groupBy([...sets.keys()], (name) => name.split(", ")[0])) {
    parts.push(heading(scene), side(...names.map((name) => pictures({ title: name, items: sets.get(name) }))));
  }
  parts.push(heading("All figures"), table({ rows: study.rows, columns: [sceneColumn, shadowColumn, methodColumn, recordsColumn, errorColumn,
    { label: "error, scene units", value: (r) => r.error }, { label: "largest, scene units", value: (r) => r.error_max }] }));
  const lead = study.schema.includes("smooth")
    ? "TR2007-600, figure 3: a scene of large smooth objects alone, 25 samples a pixel reduced to 2. The report found that Light Metric 4 " +
      "does worse here than PURE, while K-means and Light Metric 1 have no error."
    : "TR2007-600, figures 1 and 8 to 13: each scene under its own lights, all samples beside reduced records.";
  return { title: study.schema.includes("smooth") ? "smooth surfaces" : "pictures", lead: `${lead} Drag over a picture to wipe between the two ` +
    "chosen; a click on a small one puts it on the right. Maps of the error share one scale, 0 to 0.1 in scene units: ten times enlarged.", parts };
}

const methodSymbols = {
  "all": "star", "pure": "x", "kmeans": "square-open", "strong-kmeans": "square", "light-fit-fast": "diamond", "light-fit": "circle",
};

function layoutTradeoff() {
  const parts = [];
  for (const [scene, rows] of groupBy(study.rows, (r) => r.scene)) {
    const xy = (own) => ({ x: own.map((r) => r.ms_light), y: own.map(relative), text: own.map((r) => r.setting) });
    const traced = rows.filter((r) => r.format === "traced");
    const series = [...groupBy(rows.filter((r) => r.format !== "traced"), (r) => `shadows ${r.shadow}`)].map(([name, own]) => ({
      name, kind: "points", color: shadowColors[own[0].shadow], symbol: own.map((r) => methodSymbols[r.method] ?? "cross"),
      opacity: own.map((r) => (r.pixels === "all" ? 1 : 0.45)), ...xy(own) }));
    series.push({ name: "traced anew, 1 to 64 samples", kind: "line", color: themeColor("--faint"), dash: "dot", ...xy(traced) });
    const front = rows.filter((r) => r.pareto).sort((a, b) => a.ms_light - b.ms_light);
    series.push({ name: "Pareto front", kind: "line", color: themeColor("--ink"), shape: "hv", symbol: "circle-open", ...xy(front) });
    const size = `${rows[0].width} x ${rows[0].height}`;
    parts.push(heading(scene), plot({ title: `${scene}, ${size}: error against time`, x: "milliseconds a light move", y: "error, %", series,
      logX: true, logY: true, height: 560, note: `Error: eq. 7 over covered pixels against ${rows[0].truth_spp} traced samples a pixel, in ` +
        "percent of the truth's mean. Squares: strong-kmeans, diamonds and circles: light-fit, crosses: pure, stars: all samples; pale: a " +
        "quarter of the pixels, the others filled in. On the front no other setting is both faster and closer." }));
    const choices = study.recommended.filter((r) => r.scene === scene);
    parts.push(table({ rows: choices, columns: [{ label: "a move may take", value: (r) => r.limit },
      { label: "setting", value: (r) => r.setting + (r.within ? "" : " (the fastest, and too slow)") }, errorColumn,
      { label: "ms a light", value: (r) => r.ms_light }] }));
  }
  parts.push(heading("All figures"), table({ rows: study.rows, columns: [sceneColumn, { label: "setting", value: (r) => r.setting }, errorColumn, halfColumn,
    { label: "ms a light", value: (r) => r.ms_light }, { label: "prepare, s", value: (r) => (r.ms_prepare ? r.ms_prepare / 1e3 : null) },
    { label: "records a pixel", value: (r) => r.average_records || null }, { label: "cache, MiB", value: (r) => (r.cache_bytes ? r.cache_bytes / 2 ** 20 : null) },
    { label: "Pareto", value: (r) => r.pareto }] }));
  return { title: "error against time", lead: "What a setting costs per light move and how far its picture is from the truth, beside tracing " +
    "everything anew with Embree in the same run. Times are wall times of all threads on this machine; compare them within the page.", parts };
}

function layoutStability() {
  const parts = [];
  for (const [extreme, rows] of groupBy(study.rows.filter((r) => r.value > 0), (r) => r.extreme)) {
    const series = [...groupBy(rows, (r) => r.scene)].map(([scene, own], i) => ({ name: scene, kind: "line",
      color: ["#0072b2", "#e69f00", "#009e73"][i % 3], x: own.map((r) => r.value), y: own.map((r) => r.error_relative) }));
    parts.push(plot({ title: extreme, x: extreme, y: "kernels against double, relative", series, logX: true, logY: true, ticks: unique(rows.map((r) => r.value)), limits: [1e-8, 1e-2], height: 300 }));
  }
  const columns = ["value", "covered_pixels", "error_relative", "error_max", "error_reduced", "visibility", "replaced_values", "non_finite_values"];
  return { title: "stability", lead: "Scenes taken to extremes: what single precision loses against the same samples in double precision, whether " +
    "reduction and shadow rays still do what they did, and whether anything but finite numbers leaves.", parts: [side(...parts), heading("All figures"),
    table({ rows: study.rows, columns: [sceneColumn, { label: "extreme", value: (r) => r.extreme },
      ...columns.map((key) => ({ label: key.replaceAll("_", " "), value: (r) => r[key] }))] }),
    paragraph("error relative: eq. 7 of the kernels' picture against the double reference, over the picture's mean; error max: the largest of a pixel, " +
      "of its own value; error reduced: strong K-means against all samples; visibility: mean over covered pixels, one ray a sample.", "note")] };
}

const layouts = {
  "relume-study-methods-1": layoutMethods,
  "relume-study-rates-1": layoutRates,
  "relume-study-lights-1": layoutLights,
  "relume-study-smooth-1": layoutPictures,
  "relume-study-pictures-1": layoutPictures,
  "relume-study-shadows-1": layoutShadows,
  "relume-study-tradeoff-1": layoutTradeoff,
  "relume-study-stability-1": layoutStability,
};

show(layouts[study.schema]());
