"""A parsed HTML document, for tests of reports."""

from html.parser import HTMLParser

VOID = {"meta", "link", "img", "br", "input", "mspace", "rect"}


class Page(HTMLParser):
    """Elements of a document in order, each with its attributes and all the text in it; tables by their id."""

    def __init__(self, text):
        super().__init__()
        self.elements, self._open, self.tables, self._table = [], [], {}, None
        self.feed(text)
        self.close()
        assert not self._open, f"never closed: {self._open}"

    def handle_starttag(self, tag, attrs):
        element = {"tag": tag, "text": "", **dict(attrs)}
        self.elements.append(element)
        if tag not in VOID:
            self._open.append(element)
        if element.get("class") == "best":
            self._table[-1][-1]["best"] = True
        if tag == "table":
            self._table = self.tables.setdefault(element.get("id", f"table {len(self.tables)}"), [])
        if tag == "tr":
            self._table.append([])
        if tag in ("td", "th"):
            self._table[-1].append(element)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self._open[-1]["tag"] == tag, f"</{tag}> closes <{self._open[-1]['tag']}>"
            self._open.pop()

    def handle_data(self, data):
        for element in self._open:
            element["text"] += data

    def all(self, tag):
        return [element for element in self.elements if element["tag"] == tag]

    def one(self, anchor):
        (element,) = [element for element in self.elements if element.get("id") == anchor]
        return element

    def rows(self, table):
        """Texts of the cells of a table, row by row."""
        return [[" ".join(cell["text"].split()) for cell in row] for row in self.tables[table]]
