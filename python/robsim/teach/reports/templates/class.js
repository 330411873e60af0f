// Sorts a table by the column whose heading is pressed: numbers by data-value, else by text.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  const order = new Intl.Collator(undefined, { numeric: true });
  const key = (row, column) => row.cells[column].dataset.value ?? row.cells[column].textContent;
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const wasDown = head.getAttribute("aria-sort") === "descending";
      const isNumber = table.tBodies[0].rows[0]?.cells[column].dataset.value !== undefined;
      const isUp = head.hasAttribute("aria-sort") ? wasDown : !isNumber;
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", isUp ? "ascending" : "descending");
      const rows = [...table.tBodies[0].rows].sort((a, b) => {
        const [x, y] = [key(a, column), key(b, column)];
        return (isUp ? 1 : -1) * (isNumber ? x - y : order.compare(x, y));
      });
      table.tBodies[0].append(...rows);
    });
  });
}
