// Sorts the table by the column of a pressed heading: by data-value, and names as text.
const table = document.querySelector("table.sortable");
const order = new Intl.Collator(undefined, { numeric: true });
table.tHead.addEventListener("click", ({ target }) => {
  const head = target.closest("th");
  const isUp = head.ariaSort ? head.ariaSort === "descending" : head.cellIndex === 0;
  for (const other of head.parentElement.cells) other.ariaSort = null;
  head.ariaSort = isUp ? "ascending" : "descending";
  const rows = [...table.tBodies[0].rows].sort((a, b) => {
    const [x, y] = (isUp ? [a, b] : [b, a]).map((row) => row.cells[head.cellIndex]);
    return x.dataset.value - y.dataset.value || order.compare(x.textContent, y.textContent);
  });
  table.tBodies[0].append(...rows);
});
