"use strict";
(() => {
  const ledger = document.getElementById("ledger");
  if (ledger) {
    const body = ledger.tBodies[0];
    const rows = [...body.rows];
    const words = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));
    const filters = document.getElementById("filters");
    const search = document.getElementById("search");
    const asserted = document.getElementById("asserted");
    const choices = [...filters.querySelectorAll("select")];
    const results = document.getElementById("results");
    const status = document.getElementById("shown");

    const filter = () => {
      const wanted = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      let count = 0;
      for (const row of rows) {
        row.hidden =
          !wanted.every((word) => words.get(row).includes(word)) ||
          choices.some((choice) => choice.value && row.dataset[choice.dataset.filter] !== choice.value) ||
          (asserted.checked && !("asserted" in row.dataset)) ||
          (results.checked && ["setting", "arithmetic"].includes(row.dataset.basis));
        count += !row.hidden;
      }
      status.textContent = `${count} of ${rows.length} numbers shown`;
    };

    // What a row is sorted by in a column: its number, or else its words; null where the cell is empty.
    const key = (row, column) => {
      const cell = row.cells[column];
      if (cell.dataset.value) return Number(cell.dataset.value);
      const text = cell.textContent.trim();
      return text === "" || text === "–" ? null : text;
    };

    const compare = (a, b) => {
      if (typeof a === "number" && typeof b === "number") return a - b;
      return String(a).localeCompare(String(b), "en", { numeric: true });
    };

    const sort = (header) => {
      const rising = header.getAttribute("aria-sort") !== "ascending";
      for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
      header.setAttribute("aria-sort", rising ? "ascending" : "descending");
      const keys = new Map(rows.map((row) => [row, key(row, header.cellIndex)]));
      const order = [...rows].sort((a, b) => {
        const [x, y] = [keys.get(a), keys.get(b)];
        if (x === null || y === null) return (x === null) - (y === null); // empty cells come last either way
        return rising ? compare(x, y) : compare(y, x);
      });
      body.append(...order);
    };

    for (const header of ledger.tHead.rows[0].cells) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = header.textContent;
      button.addEventListener("click", () => sort(header));
      header.replaceChildren(button);
    }

    // A link to a row that a filter hides shows all rows.
    const reveal = () => {
      const row = document.getElementById(decodeURIComponent(location.hash.slice(1)));
      if (row && row.hidden) {
        filters.reset();
        setTimeout(() => row.scrollIntoView()); // after the filter has run
      }
    };

    filters.addEventListener("input", filter);
    filters.addEventListener("submit", (event) => event.preventDefault());
    filters.addEventListener("reset", () => setTimeout(filter));
    window.addEventListener("hashchange", reveal);
    filters.hidden = false;
    results.checked = true; // what a reader comes for; without scripts, and after "Show all", every row is shown
    filter();
    reveal();
  }

  for (const line of document.querySelectorAll(".command")) {
    const code = line.querySelector("code");
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Copy";
    button.setAttribute("aria-label", `Copy the command ${code.textContent}`);
    button.addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(code.textContent);
        button.textContent = "Copied";
      } catch {
        getSelection().selectAllChildren(code);
        button.textContent = "Selected";
      }
      setTimeout(() => (button.textContent = "Copy"), 2000);
    });
    line.append(button);
  }

  // Paper shows what is folded on the screen.
  window.addEventListener("beforeprint", () => {
    for (const part of document.querySelectorAll("details:not([open])")) {
      part.open = true;
      part.dataset.folded = "";
    }
  });
  window.addEventListener("afterprint", () => {
    for (const part of document.querySelectorAll("details[data-folded]")) {
      part.open = false;
      delete part.dataset.folded;
    }
  });
})();
