// Sorts the table by the column whose heading is pressed: names as text, others by data-value.
const table = document.querySelector("table.sortable");
const order = new Intl.Collator(undefined, { numeric: true });
for (const head of table.tHead.rows[0].cells) {
  const cell = (row) => row.cells[head.cellIndex];
  head.querySelector("button").addEventListener("click", () => {
    const isName = head.cellIndex === 0;
    const isUp = head.ariaSort ? head.ariaSort === "descending" : isName;
    for (const other of table.tHead.rows[0].cells) other.ariaSort = null;
    head.ariaSort = isUp ? "ascending" : "descending";
    const rows = [...table.tBodies[0].rows].sort((a, b) => {
      const [x, y] = isUp ? [cell(a), cell(b)] : [cell(b), cell(a)];
      if (isName) return order.compare(x.textContent, y.textContent);
      return x.dataset.value - y.dataset.value;
    });
    table.tBodies[0].append(...rows);
  });
}
