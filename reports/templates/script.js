// Sorts a table by the column whose heading is chosen. Without it the page loses nothing but this.
for (const table of document.querySelectorAll("table.sort")) {
  const body = table.tBodies[0];
  const number = (text) => Number.parseFloat(text.replace(/[\s\u202f]/g, "").replace("\u2212", "-").replace(/^[<>\u2264\u2265]/, ""));
  const text = (row, column) => row.cells[column]?.textContent.trim() ?? "";
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      const up = heading.getAttribute("aria-sort") !== "ascending";
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", up ? "ascending" : "descending");
      const order = (a, b) => {
        const [x, y] = [text(a, column), text(b, column)];
        const [m, n] = [number(x), number(y)];
        const both = Number.isNaN(m) || Number.isNaN(n) ? x.localeCompare(y) : m - n;
        return up ? both : -both;
      };
      body.append(...[...body.rows].sort(order));
    });
  });
}

// Shows the point nearest to the pointer, from the data that each plot carries.
const tip = document.createElement("output");
tip.className = "tip";
tip.hidden = true;
document.body.append(tip);
for (const plot of document.querySelectorAll("svg[data-plot]")) {
  const { x, y, area: [left, top, right, bottom], series } = JSON.parse(plot.dataset.plot);
  const part = (axis, value) => {
    const at = axis.log ? Math.log10(Math.max(value, 1e-300)) : value;
    return Math.min(Math.max((at - axis.from) / (axis.to - axis.from), 0), 1);
  };
  const points = series.flatMap(({ name, points }) => points.map(([a, b]) => ({
    name, a, b, across: left + part(x, a) * (right - left), down: bottom - part(y, b) * (bottom - top),
  })));
  const named = (axis, value) => axis.names?.find(([at]) => Math.abs(at - value) < 1e-9)?.[1];
  const shown = (axis, value) => {
    const text = named(axis, value) ?? String(Number(value.toPrecision(4))).replace("-", "\u2212");
    return axis.label && !named(axis, value) ? `${axis.label.split(":")[0]} = ${text}` : text;
  };
  const ring = document.createElementNS(plot.namespaceURI, "circle");
  for (const [name, value] of Object.entries({ r: 6, fill: "none", stroke: "#1d2935", "stroke-width": 1.5 })) ring.setAttribute(name, value);
  const hide = () => { tip.hidden = true; ring.remove(); };
  const show = (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse());
    // Along the horizontal axis it counts more, so that a bar answers over its whole height.
    const far = (point) => Math.hypot(point.across - at.x, (point.down - at.y) / 6);
    const nearest = points.reduce((best, point) => (!best || far(point) < far(best) ? point : best), null);
    if (!nearest || far(nearest) > 30) return hide();
    ring.setAttribute("cx", nearest.across);
    ring.setAttribute("cy", nearest.down);
    plot.append(ring);
    tip.textContent = `${nearest.name ? `${nearest.name}; ` : ""}${shown(x, nearest.a)}; ${shown(y, nearest.b)}`;
    tip.hidden = false;
    const room = document.documentElement.clientWidth - tip.offsetWidth - 8;
    tip.style.left = `${Math.max(8, Math.min(event.clientX + 14, room))}px`;
    tip.style.top = `${event.clientY + 18}px`;
  };
  plot.addEventListener("pointermove", show);
  plot.addEventListener("pointerdown", show);
  plot.addEventListener("pointerleave", hide);
}

// Opens a map over the whole window: the wheel zooms about the pointer, a drag moves it, Escape closes it.
const view = document.createElement("dialog");
view.className = "zoom";
document.body.append(view);
let [scale, across, down] = [1, 0, 0];
const place = () => {
  const map = view.firstElementChild;
  map.style.transform = `translate(${across}px, ${down}px) scale(${scale})`;
  map.style.imageRendering = scale > 2 ? "pixelated" : "auto";
};
for (const map of document.querySelectorAll("figure img, figure.features > svg")) {
  map.classList.add("opens");
  map.tabIndex = 0;
  const open = () => {
    const copy = map.cloneNode(true);
    copy.removeAttribute("tabindex");
    view.replaceChildren(copy);
    view.classList.toggle("features", map.matches(".features > svg"));
    [scale, across, down] = [1, 0, 0];
    view.showModal();
  };
  map.addEventListener("click", open);
  map.addEventListener("keydown", (event) => { if (event.key === "Enter") open(); });
}
view.addEventListener("wheel", (event) => {
  event.preventDefault();
  const to = Math.min(Math.max(scale * 2 ** (-event.deltaY / 250), 1), 32);
  const box = view.firstElementChild.getBoundingClientRect();
  const ratio = to / scale;
  across += (event.clientX - box.left - box.width / 2) * (1 - ratio);
  down += (event.clientY - box.top - box.height / 2) * (1 - ratio);
  scale = to;
  if (scale === 1) [across, down] = [0, 0];
  place();
}, { passive: false });
let moved = false;
view.addEventListener("pointerdown", (event) => { moved = false; event.preventDefault(); });
view.addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  moved ||= event.movementX !== 0 || event.movementY !== 0;
  across += event.movementX;
  down += event.movementY;
  place();
});
view.addEventListener("click", () => { if (!moved) view.close(); });
