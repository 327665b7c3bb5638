// Links the parts of an atlas: the orbit that is selected, its address, the filters and the keys.
// The names are those of the arguments in atlas.py.
const d = orbits.data, points = scatter.renderers[0].glyph
const sides = { 0: -1, 2: 1, 1: -1, 4: -1, 3: 1, 5: 1 }  // of the bottom, the top, the left and the right

function show(i) {
  const p = d.p[i], first = d.start[i], word = d.code[i]
  const x = [], y = [], gamma = { walls: [], arcs: [] }, delta = { walls: [], arcs: [] }
  const label = { x: [], y: [], symbol: [] }
  for (let n = 0; n < p; n++) {
    const at = first + n, s = word[n], curved = s !== "0" && s !== "2", q = bounces.data.coordinate[at]
    // the outward normal and, on a semicircle, its centre; the coordinate is x or an angle
    const nx = curved ? sides[s] * Math.cos(q) : 0, ny = curved ? Math.sin(q) : sides[s]
    const cx = curved ? sides[s] * half : q
    x.push(cx + nx); y.push(ny)
    label.x.push(cx + 1.14 * nx); label.y.push(1.14 * ny)
    label.symbol.push(s)
    const part = curved ? "arcs" : "walls"  // the top wall and the left semicircle are turned by half a turn
    gamma[part].push(bounces.data.gamma[at] / 65535); delta[part].push(bounces.data.delta[at] / 65535)
  }
  const dx = x[1] - x[0], dy = y[1] - y[0]
  path.data = { x: [...x, x[0]], y: [...y, y[0]] }
  arrow.data = { x: [x[0] + 0.4 * dx], y: [y[0] + 0.4 * dy], angle: [Math.atan2(dy, dx) - Math.PI / 2] }
  symbols.data = p <= 24 ? label : { x: [], y: [], symbol: [] }
  walls.data = { gamma: gamma.walls, delta: delta.walls }
  arcs.data = { gamma: gamma.arcs, delta: delta.arcs }
  const e = (v) => v.toExponential(1), f = (name, n) => d[name][i].toFixed(n)
  const born = Number.isFinite(d.born[i]) ? `, born at a = ${f("born", 6)}` : ""
  facts.text = `<h2 id="word">${word}</h2><p>p = ${p}, L = ${f("length", 13)} &plusmn; ${e(d.length_error[i])},
    &lambda; = ${f("lyapunov", 12)} &plusmn; ${e(d.lyapunov_error[i])},
    &lambda;/L = ${f("lambda_c", 13)} &plusmn; ${e(d.lambda_c_error[i])},
    area ${f("area", 9)} &plusmn; ${e(d.area_error[i])}, Maslov index ${d.maslov[i]}, margin ${f("margin", 6)},
    coordinates within ${e(d.error[i])}; ${d.time_reversal[i] === "self" ? "retraces its path" : "its reverse is another orbit"},
    class of ${d.class_size[i]}, symmetry ${d.symmetry[i]}${born}</p><p>words: ${d.words[i]}</p>`
  history.replaceState(null, "", "#" + word)
}

function choose(i) {
  orbits.selected.indices = [i]
  const grid = Bokeh.index.find_one(table)
  const row = grid === null ? -1 : [...grid.data.index].indexOf(i)
  if (row >= 0) grid.grid.scrollRowIntoView(row, false)
}

function follow() {  // the address names a word in any rotation, of any class
  const word = location.hash.slice(1)
  const i = word === "" ? -1 : d.words.findIndex((words) =>
    words.split(" ").some((w) => w.length === word.length && (w + w).includes(word)))
  if (i >= 0) choose(i)
  return i >= 0
}

function filter() {
  const text = sought.value_input.trim(), p = period.value, kind = reversal.value
  kept.booleans = d.code.map((_, i) =>
    (text === "" || d.words[i].split(" ").some((w) => (w + w).includes(text) && w.length >= text.length)) &&
    (p === "every p" || String(d.p[i]) === p) && (kind === "any reversal" || d.time_reversal[i] === kind))
}

function step(by) {
  const grid = Bokeh.index.find_one(table)
  const order = grid === null ? [...d.code.keys()] : [...grid.data.index]
  const now = order.indexOf(orbits.selected.indices[0])
  if (order.length) choose(order[Math.max(0, Math.min(order.length - 1, now + by))])
}

orbits.selected.properties.indices.change.connect(() => {
  const [i] = orbits.selected.indices
  if (i !== undefined) show(i)
})
sought.properties.value_input.change.connect(filter)
for (const each of [period, reversal]) each.properties.value.change.connect(filter)
for (const [each, key, axis] of [[abscissa, "x", scatter.below[0]], [ordinate, "y", scatter.left[0]]])
  each.properties.value.change.connect(() => {
    points[key] = { field: each.value }
    axis.axis_label = each.value
  })
window.addEventListener("hashchange", follow)
window.addEventListener("keydown", (event) => {
  if (["INPUT", "SELECT", "TEXTAREA"].includes(event.composedPath()[0].tagName)) return
  const by = { j: 1, ArrowDown: 1, k: -1, ArrowUp: -1 }[event.key]
  if (by === undefined || event.ctrlKey || event.metaKey || event.altKey) return
  event.preventDefault(); event.stopPropagation()
  step(by)
}, true)
if (!follow() && d.code.length) choose(0)
document.body.dataset.ready = "yes"
