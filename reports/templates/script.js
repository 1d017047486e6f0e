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
