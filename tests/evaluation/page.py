"""A report as Markdown and as HTML, from the same pieces."""

import html
import re
import shutil

STYLE = ("body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
         "table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.2em .6em}"
         "td+td{text-align:right}img{max-width:100%}.note{color:#666;font-size:90%}")


class Page:
    """Sections, texts, tables and pictures, in the order in which they are added.

    Text may hold **bold** and `code`, nothing else of Markdown.
    """

    def __init__(self, out, title):
        self.out = out
        self.misses = 0
        self._markdown = [f"# {title}"]
        self._html = [f"<h1>{html.escape(title)}</h1>"]

    def section(self, title):
        self._markdown.append(f"## {title}")
        self._html.append(f"<h2>{html.escape(title)}</h2>")

    def text(self, text):
        self._markdown.append(text)
        self._html.append(f"<p>{_inline(text)}</p>")

    def note(self, text):
        self._markdown.append(f"*{text}*")
        self._html.append(f'<p class="note">{_inline(text)}</p>')

    def table(self, head, rows):
        rows = [[str(cell) for cell in row] for row in rows]
        self._markdown.append("\n".join(
            "| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows]))
        lines = ["<tr>" + "".join(f"<th>{_inline(cell)}</th>" for cell in head) + "</tr>"]
        lines += ["<tr>" + "".join(f"<td>{_inline(cell)}</td>" for cell in row) + "</tr>"
                  for row in rows]
        self._html.append("<table>" + "\n".join(lines) + "</table>")

    def picture(self, name, caption):
        """A file of the folder `pictures`."""
        if not (self.out / "pictures" / name).exists():
            raise SystemExit(f"evaluate: no picture {self.out}/pictures/{name}")
        self._markdown.append(f"![{caption}](pictures/{name})\n\n{caption}")
        self._html.append(f'<p><img src="pictures/{name}" alt="{html.escape(caption)}"><br>'
                          f"{_inline(caption)}</p>")

    def judged(self, value, shown, target, at_least=True, judge=True):
        """`shown`, in bold with the target where `value` misses it."""
        met = value >= target if at_least else value <= target
        if met or not judge:
            return shown
        self.misses += 1
        return f"**{shown}: misses {target:g}**"

    def write(self):
        text = "\n\n".join(self._markdown) + "\n"
        (self.out / "evaluation.md").write_text(text, encoding="utf-8")
        body = "\n".join(self._html)
        (self.out / "evaluation.html").write_text(
            f'<!DOCTYPE html><meta charset="utf-8"><title>voxatlas evaluation</title>'
            f"<style>{STYLE}</style>\n{body}\n", encoding="utf-8")


def _inline(text):
    text = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", html.escape(str(text)))
    return re.sub(r"`(.+?)`", r"<code>\1</code>", text)


def number(value, digits=3):
    """With thin groups of three digits where it is large, else to `digits` digits."""
    if abs(value) >= 1000:
        return f"{value:,.0f}".replace(",", " ")
    return f"{value:.{digits}g}"


def need_gnuplot():
    if not shutil.which("gnuplot"):
        raise SystemExit("evaluate: no gnuplot here: run scripts/setup first")
