// On a narrow page each row of a wide table is a card, whose lines begin with the heading of their column.
for (const table of document.querySelectorAll(".md-typeset table:not([class])")) {
  const headings = [...table.querySelectorAll("thead th")].map((heading) => heading.textContent.trim());
  if (headings.length < 3) continue;
  table.dataset.cards = "";
  if (headings.length > 6) table.dataset.wide = "";
  for (const row of table.querySelectorAll("tbody tr"))
    [...row.cells].forEach((cell, k) => {
      cell.dataset.heading = headings[k];
      if (!cell.hasChildNodes()) return;
      // One box for text, code and links of a cell, next to its heading.
      const content = document.createElement("span");
      content.append(...cell.childNodes);
      cell.append(content);
    });
}
// Two blanks within a line of printed text are the space between columns.
for (const text of document.querySelectorAll(".md-typeset .language-text code"))
  if (/\S {2,}\S/.test(text.textContent)) text.dataset.columns = "";
